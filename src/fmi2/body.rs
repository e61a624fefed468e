//! Mass and inertia that the simulation uses for the projectile.

use super::instance::Model;

/// Mass, kg; 0 for a projectile that is held in place.
pub(super) fn mass(model: &Model) -> f64 {
    let body = &model.scene.projectile;
    if body.fixed { 0.0 } else { body.mass.unwrap_or(0.0) }
}

/// Inertia in the frame of the body, xx yy zz xy xz yz, kg m²; 0 for a projectile that is held in place.
pub(super) fn inertia(model: &Model) -> [f64; 6] {
    let body = &model.scene.projectile;
    if body.fixed { [0.0; 6] } else { body.inertia.unwrap_or_default() }
}
