use crate::geometry::{Gap, SignedDistance};
use crate::math::{Tensor3, Vector3};

/// Half-space bounded by a plane through the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    normal: Vector3,
}

impl HalfSpace {
    /// Builds the half-space whose boundary has this outward normal, of any length but zero.
    ///
    /// # Panics
    /// If the normal is zero or not finite.
    #[must_use]
    pub fn new(normal: Vector3) -> Self {
        let length = normal.norm();
        assert!(length > 0.0 && length.is_finite(), "the normal of a half-space must have a direction");
        Self { normal: normal / length }
    }

    /// Unit normal of the boundary, out of the body.
    #[must_use]
    pub fn normal(&self) -> Vector3 {
        self.normal
    }
}

impl SignedDistance for HalfSpace {
    fn gap(&self, point: &Vector3) -> Gap {
        Gap { distance: point.dot(&self.normal), normal: self.normal }
    }

    fn reach(&self, _direction: &Vector3) -> f64 {
        0.0
    }

    fn volume(&self) -> Option<f64> {
        None
    }

    fn area_of_section(&self) -> Option<f64> {
        None
    }

    fn specific_inertia(&self) -> Option<Tensor3> {
        None
    }

    fn specific_inertia_of_section(&self) -> Option<f64> {
        None
    }

    fn inner_radius(&self) -> f64 {
        f64::INFINITY
    }
}
