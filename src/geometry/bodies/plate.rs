use crate::geometry::{Gap, SignedDistance};
use crate::math::{Tensor3, Vector3};
use std::f64::consts::PI;

/// Cuboid along the axes, centred on the origin, with rounded edges and corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundedCuboid {
    half: Vector3,
    edge_radius: f64,
}

impl RoundedCuboid {
    /// Builds a plate from its edge lengths, m, and the radius of the rounding of all edges, m; 0 is sharp.
    ///
    /// # Panics
    /// Unless 0 ≤ `edge_radius` ≤ half the least edge length.
    #[must_use]
    pub fn new(size: [f64; 3], edge_radius: f64) -> Self {
        let half = 0.5 * Vector3::from(size);
        assert!((0.0..=half.min()).contains(&edge_radius), "the edges of a plate have room for their rounding");
        Self { half, edge_radius }
    }

    /// Edge lengths, m.
    #[must_use]
    pub fn size(&self) -> Vector3 {
        2.0 * self.half
    }

    /// Half edge lengths of the inner cuboid that remains without the rounding, m.
    fn core(&self) -> Vector3 {
        self.half.add_scalar(-self.edge_radius)
    }

    /// Volume, m³: core, slabs on its faces, quarter cylinders along its edges, and a ball made of its corners.
    fn rounded_volume(&self) -> f64 {
        let (core, r) = (self.core(), self.edge_radius);
        let faces = core.x * core.y + core.y * core.z + core.z * core.x;
        8.0 * core.product() + 8.0 * r * faces + 2.0 * PI * r * r * core.sum() + 4.0 / 3.0 * PI * r * r * r
    }

    /// Second moment ∫x² dV along one axis, m⁵. Sections within the core, of half length a, are equal; a section at a +
    /// t in the rounding is a rectangle rounded by ρ = √(r² − t²).
    fn second_moment(&self, axis: usize) -> f64 {
        let (core, r) = (self.core(), self.edge_radius);
        let (a, b, c) = (core[axis], core[(axis + 1) % 3], core[(axis + 2) % 3]);
        let middle = 4.0 * b * c + 4.0 * r * (b + c) + PI * r * r;
        let (r2, r3) = (r * r, r * r * r);
        // ∫(a + t)² ρⁿ dt over 0…r for n = 0, 1, 2.
        let flat = a * a * r + a * r2 + r3 / 3.0;
        let straight = a * a * PI * r2 / 4.0 + 2.0 * a * r3 / 3.0 + PI * r2 * r2 / 16.0;
        let round = a * a * 2.0 * r3 / 3.0 + a * r2 * r2 / 2.0 + 2.0 * r2 * r3 / 15.0;
        let ends = 4.0 * b * c * flat + 4.0 * (b + c) * straight + PI * round;
        2.0 / 3.0 * a * a * a * middle + 2.0 * ends
    }
}

impl SignedDistance for RoundedCuboid {
    /// Distance to the inner cuboid less the edge radius: outside it the distance to its nearest point, inside it to
    /// its nearest face.
    fn gap(&self, point: &Vector3) -> Gap {
        let over = point.abs() - self.core();
        let sign = |axis: usize| 1.0_f64.copysign(point[axis]);
        let beyond = Vector3::from_fn(|axis, _| sign(axis) * over[axis].max(0.0));
        let distance = beyond.norm();
        if distance > 0.0 {
            return Gap { distance: distance - self.edge_radius, normal: beyond / distance };
        }
        let axis = over.imax();
        Gap { distance: over[axis] - self.edge_radius, normal: Vector3::ith(axis, sign(axis)) }
    }

    fn reach(&self, direction: &Vector3) -> f64 {
        self.core().dot(&direction.abs()) + self.edge_radius
    }

    fn specific_inertia(&self) -> Option<Tensor3> {
        let moment = Vector3::from_fn(|axis, _| self.second_moment(axis)) / self.rounded_volume();
        Some(Tensor3::from_diagonal(&(Vector3::repeat(moment.sum()) - moment)))
    }

    /// I = (a² + c²)/12 of a rectangle; the rounding is neglected.
    fn specific_inertia_of_section(&self) -> Option<f64> {
        let size = self.size();
        Some((size.x * size.x + size.z * size.z) / 12.0)
    }

    fn volume(&self) -> Option<f64> {
        Some(self.rounded_volume())
    }

    fn area_of_section(&self) -> Option<f64> {
        let (size, r) = (self.size(), self.edge_radius);
        Some(size.x * size.z - (4.0 - PI) * r * r)
    }

    fn inner_radius(&self) -> f64 {
        self.half.min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume, and second moments per volume, by counting the points of a fine lattice inside.
    fn counted(plate: &RoundedCuboid) -> (f64, Vector3) {
        const N: usize = 120;
        let cell = plate.size() / N as f64;
        let at = |i: usize, axis: usize| (i as f64 + 0.5) * cell[axis] - 0.5 * plate.size()[axis];
        let (mut inside, mut moment) = (0.0, Vector3::zeros());
        for i in 0..N * N * N {
            let p = Vector3::new(at(i % N, 0), at(i / N % N, 1), at(i / N / N, 2));
            if plate.gap(&p).distance <= 0.0 {
                inside += 1.0;
                moment += p.component_mul(&p);
            }
        }
        (inside * cell.product(), moment / inside)
    }

    #[test]
    fn volume_and_inertia_of_a_rounded_plate_are_those_counted() {
        for (size, radius) in [([2.0, 1.2, 0.7], 0.0), ([2.0, 1.2, 0.7], 0.3), ([1.0; 3], 0.5)] {
            let plate = RoundedCuboid::new(size, radius);
            let (volume, moment) = counted(&plate);
            assert!((plate.volume().unwrap() / volume - 1.0).abs() < 1e-3, "{volume} {}", plate.volume().unwrap());
            let inertia = plate.specific_inertia().unwrap();
            let expected = [moment.y + moment.z, moment.z + moment.x, moment.x + moment.y];
            for (axis, expected) in expected.into_iter().enumerate() {
                assert!((inertia[(axis, axis)] / expected - 1.0).abs() < 1e-3, "{radius}: {inertia} {expected}");
            }
        }
    }

    #[test]
    fn a_plate_rounded_all_over_is_a_ball() {
        let ball = RoundedCuboid::new([2.0; 3], 1.0);
        assert!((ball.volume().unwrap() - 4.0 / 3.0 * PI).abs() < 1e-14);
        assert!((ball.specific_inertia().unwrap() - Tensor3::identity() * 0.4).norm() < 1e-14);
    }
}
