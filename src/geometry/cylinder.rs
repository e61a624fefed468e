use super::{Gap, SignedDistance};
use crate::algebra::{Tensor3, Vector3};

/// A right circular cylinder about the z axis, centred on the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Radius, m.
    pub radius: f64,
    /// Length, m.
    pub length: f64,
}

impl SignedDistance for Cylinder {
    /// In the half-plane (ρ, |z|): inside, the nearer of mantle and end; outside, the distance to the rectangle.
    fn gap(&self, point: &Vector3) -> Gap {
        let rho = hypotenuse(point.x, point.y);
        let outward = if rho > 0.0 { Vector3::new(point.x / rho, point.y / rho, 0.0) } else { Vector3::x() };
        let axial = Vector3::new(0.0, 0.0, 1.0_f64.copysign(point.z));
        let (side, end) = (rho - self.radius, point.z.abs() - 0.5 * self.length);
        if side > 0.0 && end > 0.0 {
            let distance = hypotenuse(side, end);
            return Gap { distance, normal: (outward * side + axial * end) / distance };
        }
        if side > end { Gap { distance: side, normal: outward } } else { Gap { distance: end, normal: axial } }
    }

    fn reach(&self, direction: &Vector3) -> f64 {
        0.5 * self.length * direction.z.abs() + self.radius * hypotenuse(direction.x, direction.y)
    }

    /// Iₓ = R²/4 + L²/12, I_z = R²/2.
    fn specific_inertia(&self) -> Option<Tensor3> {
        let r2 = self.radius * self.radius;
        let across = 0.25 * r2 + self.length * self.length / 12.0;
        Some(Tensor3::from_diagonal(&Vector3::new(across, across, 0.5 * r2)))
    }
}

/// √(a² + b²) from exact operations only, so that it has the same bits on every platform.
fn hypotenuse(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
