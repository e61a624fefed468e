//! Signed distance function of a closed body, and its values.

use crate::math::{Tensor3, Vector3};

/// Signed distance (gap) and its gradient at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// φ, m: negative inside the body.
    pub distance: f64,
    /// n = ∇φ, unit vector out of the body.
    pub normal: Vector3,
}

/// End of a body that may be sharper than the mesh can resolve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SharpEnd {
    /// Position of the end, m.
    pub end: Vector3,
    /// Point inside the body, m; the segment from the end to it stays inside.
    pub inner: Vector3,
}

/// Closed body described by its signed distance function.
pub trait SignedDistance {
    /// Signed distance φ and ∇φ at a point of the body's frame; |∇φ| = 1, so φ is 1-Lipschitz. Far outside the body φ
    /// may be a lower bound of the distance, with its direction as the gradient.
    fn gap(&self, point: &Vector3) -> Gap;
    /// Support function: the greatest extent of the body along the unit vector `direction` of its frame, m. For an
    /// unbounded body, the extent of its boundary through the origin.
    fn reach(&self, direction: &Vector3) -> f64;
    /// Volume, m³; `None` for an unbounded body.
    fn volume(&self) -> Option<f64>;
    /// Area of the section y = 0, m²: the volume of a planar body per metre of thickness.
    fn area_of_section(&self) -> Option<f64>;
    /// Inertia tensor about the origin of a homogeneous body per kilogram, m²; `None` for an unbounded body.
    fn specific_inertia(&self) -> Option<Tensor3>;
    /// Inertia about y, per kilogram, of the homogeneous prism over the section y = 0, m²: the inertia of a planar
    /// body.
    fn specific_inertia_of_section(&self) -> Option<f64>;
    /// Radius of the greatest inscribed ball, m.
    fn inner_radius(&self) -> f64;
}
