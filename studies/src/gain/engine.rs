use super::case::Case;
use ballistic_gel::constitutive::NeoHookean;
use ballistic_gel::contact::{BodyMotion, BodyState, ContactSurface, FreeDirections, ImpulseLaw, RigidBody};
use ballistic_gel::fem::{Section, Simplices};
use ballistic_gel::geometry::SignedDistance as _;
use ballistic_gel::integrator::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use ballistic_gel::math::Vector;
use ballistic_gel::mesh::{Facet, Mesh};
use ballistic_gel::scene::{ContactSpec, Scene};

/// Fraction of the stable step that an element takes, in every schedule.
pub const CFL: f64 = 0.8;

/// The integrator on a mesh, on one thread.
pub fn engine(case: &Case, schedule: SteppingSchedule) -> Engine<3, Simplices<3>> {
    let Case { scene, mesh, .. } = case;
    let ContactSpec { restitution, bias, friction, .. } = scene.contact;
    let law = ImpulseLaw::Moreau { restitution, bias, friction };
    let rules = IntegratorSettings { schedule, cfl: CFL, law, force_window: scene.force_window(), damping: 0.0 };
    let nodes = mesh.rest.iter().map(|x| (*x, Vector::<3>::zeros())).collect();
    Engine::new(gel(scene, mesh), vec![ball(scene)], rules, nodes)
}

fn gel(scene: &Scene, mesh: &Mesh<3>) -> DiscreteGel<3, Simplices<3>> {
    let material = NeoHookean::new(scene.gel.shear_modulus, scene.gel.bulk_modulus);
    let simplices = Simplices::new(mesh, material, Section::Spatial);
    let mass = simplices.lumped_masses(mesh, scene.gel.density);
    let surface = ContactSurface::new::<3>(mesh.rest.len(), mesh.facets.clone(), |facet| {
        let area = area(mesh, facet);
        (area, area)
    });
    DiscreteGel::new(simplices, mass, &mesh.held, surface)
}

fn area(mesh: &Mesh<3>, facet: &Facet) -> f64 {
    let [a, b, c] = facet.map(|node| mesh.rest[node.index()]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// The projectile of a scene, which does not spin.
fn ball(scene: &Scene) -> (RigidBody, BodyState) {
    let (shape, mass) = (scene.shape(0), scene.projectile.mass.expect("the scene gives a mass"));
    let inertia = shape.specific_inertia().expect("a ball has an inertia") * mass;
    let state = BodyState::at_start(scene.projectile.position.into(), scene.projectile.velocity.into());
    (RigidBody::new(shape, BodyMotion::Free, FreeDirections::SPATIAL, mass, inertia), state)
}
