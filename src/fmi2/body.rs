//! Mass and inertia that the simulation uses for a body.

use crate::simulation::Simulation;

/// Mass, kg; 0 for a body that is held in place.
pub(super) fn mass(simulation: &Simulation, body: usize) -> f64 {
    let (mass, _) = simulation.inertia(body);
    if mass.is_finite() { mass } else { 0.0 }
}

/// Inertia in the frame of the body, xx yy zz xy xz yz, kg m²; 0 for a body that is held in place.
pub(super) fn inertia(simulation: &Simulation, body: usize) -> [f64; 6] {
    let (mass, inertia) = simulation.inertia(body);
    if mass.is_finite() { inertia } else { [0.0; 6] }
}
