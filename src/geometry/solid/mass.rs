//! Volume, centre of mass and inertia of a body with a surface of triangles.

use super::surface::Surface;
use crate::math::{Tensor3, Vector3};

/// Volume, centre of mass, and inertia about it per mass, of a homogeneous body: the sums over the tetrahedra from a point
/// to the triangles, ∫dV = d/6, ∫x dV = d/24 Σa, ∫x xᵀ dV = d/120 (Σa aᵀ + Σa (Σa)ᵀ) with d = a·(b × c).
pub(super) fn properties(surface: &Surface) -> (f64, Vector3, Tensor3) {
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
    (volume, from + centre, Tensor3::identity() * spread.trace() - spread)
}
