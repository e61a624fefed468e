//! Test cube: a gel cube, stretched a little and released, that oscillates.

use super::{DiscreteGel, Engine, IntegratorSettings, SteppingSchedule};
use crate::constitutive::NeoHookean;
pub(super) use crate::contact::test_surface::{any, mesh};
use crate::contact::{BodyState, FreeDirections, ImpulseLaw, RigidBody};
use crate::fem::{Potential, Section, Simplices};
use crate::geometry::{ShapeGeometry, Sphere};
use crate::math::Vector3;
use crate::mesh::{ElementPatches, Mesh, graded};

/// Creates a mesh of several blocks and tiles, with steps of several lengths.
pub(super) fn mixed() -> Mesh<3> {
    mesh(&graded(1.0, 0.05, (0.3, 1.3, 0.2)))
}

/// Creates a gel of simplices without patches.
pub(super) fn gel(mesh: &Mesh<3>) -> DiscreteGel<3, Simplices<3>> {
    gel_in(mesh, ElementPatches::alone(mesh.elements.len()))
}

/// Creates a gel of simplices in patches.
pub(super) fn gel_in(mesh: &Mesh<3>, patches: ElementPatches) -> DiscreteGel<3, Simplices<3>> {
    let simplices = Simplices::in_patches(mesh, patches, (NeoHookean::new(1e3, 1e4), Section::Spatial));
    let mass = simplices.lumped_masses(mesh, 1.0);
    let surface = crate::contact::test_surface::surface(mesh);
    DiscreteGel::new(simplices, mass, &mesh.held, surface)
}

/// Returns rules with the binned schedule.
pub(super) fn rules() -> IntegratorSettings {
    let law = ImpulseLaw::Moreau { restitution: 0.0, bias: 0.0, friction: 0.0 };
    IntegratorSettings { schedule: SteppingSchedule::Bins, cfl: 0.8, law, force_window: 1.0, damping: 0.0 }
}

/// Creates an engine with a body that touches nothing.
pub(super) fn engine(gel: DiscreteGel<3, Simplices<3>>) -> Engine<3, Simplices<3>> {
    let nobody = BodyState { active: false, ..BodyState::at_start(Vector3::zeros(), Vector3::zeros()) };
    let body = (RigidBody::fixed(ShapeGeometry::Sphere(Sphere { radius: 1.0 }), FreeDirections::SPATIAL), nobody);
    let nodes = gel.potential.rest().iter().map(|x| (x * 1.01, x * 0.1)).collect();
    Engine::new(gel, vec![body], rules(), nodes)
}
