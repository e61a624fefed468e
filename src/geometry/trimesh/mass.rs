//! Volume, centre of mass and inertia of a body bounded by a triangulated surface.

use super::surface::TriangleSurface;
use crate::math::{Tensor3, Vector3};

/// Mass properties of a homogeneous body.
pub(super) struct MassProperties {
    /// Volume, in units of the surface.
    pub volume: f64,
    /// Centre of mass.
    pub centre: Vector3,
    /// Inertia tensor about the centre of mass per mass.
    pub inertia: Tensor3,
}

/// Computes the mass properties of a homogeneous body as sums over the tetrahedra from one point to the triangles: ∫dV
/// = d/6, ∫x dV = d/24 Σa, ∫x xᵀ dV = d/120 (Σa aᵀ + Σa (Σa)ᵀ) with d = a·(b × c).
pub(super) fn mass_properties(surface: &TriangleSurface) -> MassProperties {
    let (lower, upper) = surface.bounds();
    let from = (lower + upper) / 2.0;
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Tensor3::zeros());
    for corners in surface.corners() {
        let [a, b, c] = corners.map(|p| p - from);
        let (d, sum) = (a.dot(&b.cross(&c)), a + b + c);
        volume += d / 6.0;
        first += sum * (d / 24.0);
        second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (d / 120.0);
    }
    let centre = first / volume;
    let spread = second / volume - centre * centre.transpose();
    let inertia = Tensor3::identity() * spread.trace() - spread;
    MassProperties { volume, centre: from + centre, inertia }
}
