//! Effective mass and inertia of the bodies.

use crate::simulation::Simulation;

/// Returns the mass, kg; 0 for a fixed body.
pub(super) fn mass(simulation: &Simulation, body: usize) -> f64 {
    let (mass, _) = simulation.inertia(body);
    if mass.is_finite() { mass } else { 0.0 }
}

/// Returns the inertia in the body frame, xx yy zz xy xz yz, kg m²; 0 for a fixed body.
pub(super) fn inertia(simulation: &Simulation, body: usize) -> [f64; 6] {
    let (mass, inertia) = simulation.inertia(body);
    if mass.is_finite() { inertia } else { [0.0; 6] }
}
