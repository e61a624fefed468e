use crate::geometry::{Gap, SignedDistance};
use crate::math::{Tensor3, Vector3};
use std::f64::consts::PI;

/// Sphere about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Radius, m.
    pub radius: f64,
}

impl SignedDistance for Sphere {
    fn gap(&self, point: &Vector3) -> Gap {
        let r = point.norm();
        Gap { distance: r - self.radius, normal: if r > 0.0 { point / r } else { Vector3::z() } }
    }

    fn reach(&self, _direction: &Vector3) -> f64 {
        self.radius
    }

    /// 4/3 π R³.
    fn volume(&self) -> Option<f64> {
        Some(4.0 / 3.0 * PI * self.radius.powi(3))
    }

    /// π R².
    fn area_of_section(&self) -> Option<f64> {
        Some(PI * self.radius * self.radius)
    }

    /// I = 2/5 R².
    fn specific_inertia(&self) -> Option<Tensor3> {
        Some(Tensor3::identity() * (0.4 * self.radius * self.radius))
    }

    /// I = R²/2 of a disc.
    fn specific_inertia_of_section(&self) -> Option<f64> {
        Some(0.5 * self.radius * self.radius)
    }

    fn inner_radius(&self) -> f64 {
        self.radius
    }
}
