use super::case::Case;
use ballistic_gel::constitutive::NeoHookean;
use ballistic_gel::contact::{Body, BodyState, Freedom, Law, Motion};
use ballistic_gel::fem::{Section, Simplices};
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::integrator::{Engine, Gel, Kind, Rules, Surface};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{Facet, Mesh};
use ballistic_gel::scene::{Contact, Scene};

/// Fraction of the stable step that an element takes, in every schedule.
pub const CFL: f64 = 0.8;

/// The integrator on a mesh, on one thread.
pub fn engine(case: &Case, schedule: Kind) -> Engine<3, Simplices<3>> {
    let Case { scene, mesh, .. } = case;
    let Contact { restitution, bias, friction, .. } = scene.contact;
    let law = Law::Moreau { restitution, bias, friction };
    let rules = Rules { schedule, cfl: CFL, law, force_window: scene.force_window(), damping: 0.0 };
    let nodes = mesh.rest.iter().map(|x| (*x, Vector::<3>::zeros())).collect();
    Engine::new(gel(scene, mesh), vec![ball(scene)], rules, nodes)
}

fn gel(scene: &Scene, mesh: &Mesh<3>) -> Gel<3, Simplices<3>> {
    let material = NeoHookean::new(scene.gel.shear_modulus, scene.gel.bulk_modulus);
    let simplices = Simplices::new(mesh, material, Section::Spatial);
    let mass = simplices.lumped_masses(mesh, scene.gel.density);
    let surface = Surface::new::<3>(mesh.rest.len(), mesh.facets.clone(), |facet| {
        let area = area(mesh, facet);
        (area, area)
    });
    Gel::new(simplices, mass, &mesh.held, surface)
}

fn area(mesh: &Mesh<3>, facet: &Facet) -> f64 {
    let [a, b, c] = facet.map(|node| mesh.rest[node.index()]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// The projectile of a scene, which does not spin.
fn ball(scene: &Scene) -> (Body, BodyState) {
    let (shape, mass) = (scene.shape(0), scene.projectile.mass.expect("the scene gives a mass"));
    let inertia = shape.specific_inertia().expect("a ball has an inertia") * mass;
    let state = BodyState::starting(scene.projectile.position.into(), scene.projectile.velocity.into());
    (Body::new(shape, Motion::Free, Freedom::SPATIAL, (mass, inertia)), state)
}
