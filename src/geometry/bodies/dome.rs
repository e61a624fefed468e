use crate::geometry::{Gap, SignedDistance};
use crate::math::{Tensor3, Vector3, hypotenuse};

/// Plate that fills the half-space z > 0 with a spherical cap below it: the bulge on the back face of an armour plate.
///
/// With base radius a and height h the cap is part of the sphere of radius (a² + h²)/2h about (0, 0, (a² − h²)/2h).
/// Every formula is multiplied by 2h, so that the flat plate, h = 0, needs no special case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dome {
    height: f64,
    radius: f64,
}

/// Part of the surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DomePart {
    Plate,
    Cap,
    Rim,
}

/// Signed distance, and the normal along ρ and z.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DomeDistance {
    part: DomePart,
    distance: f64,
    normal: [f64; 2],
}

impl Dome {
    /// Builds a cap of this height, at most a hemisphere, on a base of this radius, m.
    ///
    /// # Panics
    /// Unless 0 ≤ height ≤ radius and 0 < radius.
    #[must_use]
    pub fn new(height: f64, radius: f64) -> Self {
        assert!(radius > 0.0 && (0.0..=radius).contains(&height), "a dome is at most a hemisphere on its base");
        Self { height, radius }
    }

    /// Height of the cap, m.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Radius of the base, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Sensitivities [∂φ/∂h, ∂φ/∂a] at a point of the body's frame: the rate at which growth of the cap reduces the
    /// distance. Neither exceeds 1 in magnitude.
    #[must_use]
    pub fn growth(&self, point: &Vector3) -> [f64; 2] {
        let rho = hypotenuse(point.x, point.y);
        let nearest = self.nearest(rho, point.z);
        let (h, a) = (self.height, self.radius);
        match nearest.part {
            DomePart::Plate => [0.0, 0.0],
            DomePart::Rim => [0.0, -nearest.normal[0]],
            DomePart::Cap => {
                // With (u, w) = 2h (x − centre), s = |(u, w)| and 1 + n_z = u²/s(s − w):
                let (u, w) = self.scaled_arm(rho, point.z);
                let s = hypotenuse(u, w);
                let lift = if rho > 0.0 { 2.0 * rho * rho / (s * (s - w)) } else { 0.0 };
                [lift * (a * a + h * h) - 1.0, -2.0 * h * a * lift]
            }
        }
    }

    /// Vector from the centre of the sphere to (ρ, z), times 2h.
    fn scaled_arm(&self, rho: f64, z: f64) -> (f64, f64) {
        let (h, a) = (self.height, self.radius);
        (2.0 * h * rho, 2.0 * h * z - (a * a - h * h))
    }

    /// Signed distance to the sphere: |x − c| − R = (|x − c|² − R²)/(|x − c| + R), with c² − R² = −a².
    fn sphere(&self, rho: f64, z: f64) -> DomeDistance {
        let (h, a) = (self.height, self.radius);
        let (u, w) = self.scaled_arm(rho, z);
        let s = hypotenuse(u, w);
        let distance = 2.0 * (h * (rho * rho + z * z - a * a) - z * (a * a - h * h)) / (s + a * a + h * h);
        let normal = if s > 0.0 { [u / s, w / s] } else { [0.0, -1.0] };
        DomeDistance { part: DomePart::Cap, distance, normal }
    }

    /// Signed distance to the dome in the half-plane (ρ, z).
    fn nearest(&self, rho: f64, z: f64) -> DomeDistance {
        let (plate, cap) =
            (DomeDistance { part: DomePart::Plate, distance: -z, normal: [0.0, -1.0] }, self.sphere(rho, z));
        if plate.distance >= 0.0 && cap.distance >= 0.0 {
            return if rho <= self.radius || cap.distance < plate.distance { cap } else { plate };
        }
        // Inside, the nearest part is the plate beyond the base, the cap below the base, or the rim between them.
        let (across, up) = (self.radius - rho, -z);
        let depth = hypotenuse(across, up);
        let normal = if depth > 0.0 { [across / depth, up / depth] } else { [0.0, -1.0] };
        let rim = DomeDistance { part: DomePart::Rim, distance: -depth, normal };
        let (h, a) = (self.height, self.radius);
        let below = rho * (a * a - h * h) <= a * (a * a - h * h - 2.0 * h * z);
        let plate = (rho >= self.radius && z > 0.0).then_some(plate);
        let parts = [plate, (below && cap.distance < 0.0).then_some(cap)];
        parts.into_iter().flatten().fold(rim, |best, part| if part.distance > best.distance { part } else { best })
    }
}

impl SignedDistance for Dome {
    fn gap(&self, point: &Vector3) -> Gap {
        let rho = hypotenuse(point.x, point.y);
        let DomeDistance { distance, normal: [across, up], .. } = self.nearest(rho, point.z);
        let outward = if rho > 0.0 { across / rho } else { 0.0 };
        Gap { distance, normal: Vector3::new(outward * point.x, outward * point.y, up) }
    }

    /// Support function of the cap.
    fn reach(&self, direction: &Vector3) -> f64 {
        let (h, a) = (self.height, self.radius);
        let across = hypotenuse(direction.x, direction.y);
        // The sphere supports directions at least as steep as its normal at the rim, (2ha, h² − a²); the rim supports
        // the others.
        if h > 0.0 && across * (a * a - h * h) <= -direction.z * 2.0 * h * a {
            let down = 1.0 - direction.z;
            return 0.5 * ((a * across) * (a * across) / (h * down) + h * down);
        }
        a * across
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

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: f64 = 0.8;

    fn points() -> impl Iterator<Item = Vector3> {
        let at = |i: u32| f64::from(i);
        (0..500).map(move |i| {
            Vector3::new((at(i) * 0.711).sin() * 1.2, (at(i) * 1.37).cos() * 0.4, (at(i) * 0.239).sin() - 0.2)
        })
    }

    #[test]
    fn the_surface_grows_as_fast_as_the_distance_shrinks() {
        let step = 1e-6;
        for height in [1e-5, 0.1, 0.5, 0.79] {
            let mut smooth = 0;
            for p in points() {
                let phi = |dh: f64, da: f64| Dome::new(height + dh, BASE + da).gap(&p).distance;
                let slope =
                    [phi(step, 0.0) - phi(-step, 0.0), phi(0.0, step) - phi(0.0, -step)].map(|d| d / (2.0 * step));
                let here = 2.0 * phi(0.0, 0.0);
                let bend = [phi(step, 0.0) + phi(-step, 0.0) - here, phi(0.0, step) + phi(0.0, -step) - here];
                if bend.iter().any(|b| b.abs() > 1e-9) {
                    continue;
                }
                smooth += 1;
                let growth = Dome::new(height, BASE).growth(&p);
                for (found, expected) in growth.iter().zip(slope) {
                    assert!((found - expected).abs() < 1e-5, "{height} {p}: {growth:?} {slope:?}");
                    assert!(found.abs() <= 1.0 + 1e-12, "{growth:?}");
                }
            }
            assert!(smooth > 400, "{smooth}");
        }
    }

    #[test]
    fn beside_the_cap_the_nearer_of_plate_and_cap_counts() {
        let dome = Dome::new(BASE, BASE);
        let gap = |x: f64, z: f64| dome.gap(&Vector3::new(x, 0.0, z));
        assert_eq!(gap(1.0, -0.1), Gap { distance: 0.1, normal: -Vector3::z() });
        let beside = gap(0.9, -0.6);
        assert!((beside.distance - (f64::hypot(0.9, 0.6) - BASE)).abs() < 1e-15 && beside.normal.x > 0.8);
    }

    #[test]
    fn a_dome_without_height_is_a_plate() {
        let flat = Dome::new(0.0, BASE);
        for p in points() {
            let gap = flat.gap(&p);
            assert!((gap.distance + p.z).abs() < 1e-15 && gap.normal == -Vector3::z(), "{gap:?}");
        }
        assert_eq!(flat.growth(&Vector3::new(0.1, 0.0, -0.2))[1], 0.0);
        assert!((flat.growth(&Vector3::new(0.4, 0.0, 0.0))[0] + 0.75).abs() < 1e-15, "a shallow cap is a paraboloid");
    }

    /// Point of the cap at this distance from the axis, by bisection.
    fn on_cap(dome: &Dome, rho: f64) -> Vector3 {
        let (mut low, mut high) = (-dome.height(), 0.0);
        for _ in 0..60 {
            let z = 0.5 * (low + high);
            if dome.gap(&Vector3::new(rho, 0.0, z)).distance > 0.0 { low = z } else { high = z }
        }
        Vector3::new(rho, 0.0, low)
    }

    #[test]
    fn reach_is_that_of_points_on_the_cap() {
        for height in [0.0, 0.3, BASE] {
            let dome = Dome::new(height, BASE);
            let cap: Vec<Vector3> = (0..=100).map(|i| on_cap(&dome, f64::from(i) * 0.01 * BASE)).collect();
            for angle in [0.0, 0.2, 0.7, 1.3, 2.0] {
                let direction = Vector3::new(f64::sin(angle), 0.0, -f64::cos(angle));
                let greatest = cap.iter().map(|p| p.dot(&direction)).fold(f64::MIN, f64::max);
                let reach = dome.reach(&direction);
                assert!(
                    (reach - greatest).abs() < 1e-3 && reach > greatest - 1e-12,
                    "{height} {angle}: {reach} {greatest}"
                );
            }
        }
    }
}
