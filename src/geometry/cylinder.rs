use super::{Gap, SignedDistance};
use crate::algebra::{Tensor3, Vector3};

/// A right circular cylinder about the z axis, centred on the origin, with rounded rims.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Radius, m.
    pub radius: f64,
    /// Length, m.
    pub length: f64,
    /// Radius of the rounding of both rims, m; 0 is sharp.
    pub edge_radius: f64,
}

impl SignedDistance for Cylinder {
    /// In the half-plane (ρ, |z|) the distance to the rectangle that the rounding leaves, less the edge radius: outside
    /// the rectangle to its nearest point, inside to the nearer of mantle and end.
    fn gap(&self, point: &Vector3) -> Gap {
        let rho = hypotenuse(point.x, point.y);
        let outward = if rho > 0.0 { Vector3::new(point.x / rho, point.y / rho, 0.0) } else { Vector3::x() };
        let axial = Vector3::new(0.0, 0.0, 1.0_f64.copysign(point.z));
        let edge = self.edge_radius;
        let (side, end) = (rho - (self.radius - edge), point.z.abs() - (0.5 * self.length - edge));
        if side > 0.0 && end > 0.0 {
            let distance = hypotenuse(side, end);
            return Gap { distance: distance - edge, normal: (outward * side + axial * end) / distance };
        }
        let (distance, normal) = if side > end { (side, outward) } else { (end, axial) };
        Gap { distance: distance - edge, normal }
    }

    fn reach(&self, direction: &Vector3) -> f64 {
        let (across, along) = (hypotenuse(direction.x, direction.y), direction.z.abs());
        let edge = self.edge_radius;
        (0.5 * self.length - edge) * along + (self.radius - edge) * across + edge
    }

    /// Iₓ = R²/4 + L²/12, I_z = R²/2, the rounding neglected.
    fn specific_inertia(&self) -> Option<Tensor3> {
        let r2 = self.radius * self.radius;
        let across = 0.25 * r2 + self.length * self.length / 12.0;
        Some(Tensor3::from_diagonal(&Vector3::new(across, across, 0.5 * r2)))
    }

    /// I = R²/3 + L²/12 of a rectangle, the rounding neglected.
    fn specific_inertia_of_section(&self) -> Option<f64> {
        Some(self.radius * self.radius / 3.0 + self.length * self.length / 12.0)
    }

    fn inner_radius(&self) -> f64 {
        self.radius.min(0.5 * self.length)
    }
}

/// √(a² + b²) from exact operations only, so that it has the same bits on every platform.
fn hypotenuse(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
