//! Chisel-nosed cylinder: the outline of a fragment simulating projectile.

use super::{SurfaceError, TriangleSurface, TriangulatedBody};
use crate::math::Vector3;

/// Chisel-nosed cylinder about the z axis, its nose towards −z: a flat face across the diameter along y, and two flats
/// that slope back from it at both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChiselCylinder {
    /// Radius, m.
    pub radius: f64,
    /// Overall length, m.
    pub length: f64,
    /// Width of the front face along x, m.
    pub face_width: f64,
    /// Tangent of the angle between a sloping flat and the plane of the front face.
    pub slope: f64,
}

/// Corners of a quarter of the rim: the polygon has the area of the circle less 0.2 %.
const QUARTER: usize = 14;

impl ChiselCylinder {
    /// Length of the sloping flats along the axis, m.
    #[must_use]
    pub fn flat_length(&self) -> f64 {
        (self.radius - 0.5 * self.face_width) * self.slope
    }

    /// Builds the solid body.
    ///
    /// # Errors
    /// [`SurfaceError`] if the flats are longer than the cylinder, or a length is no positive number.
    pub fn solid(&self) -> Result<TriangulatedBody, SurfaceError> {
        TriangulatedBody::new(TriangleSurface::new(&self.triangles())?, 1.0)
    }

    /// Height of the front at a distance from the middle plane, m: 0 on the face.
    fn front(&self, x: f64) -> f64 {
        (x.abs() - 0.5 * self.face_width).max(0.0) * self.slope
    }

    /// Rim of the base, x and y, counter-clockwise about z and symmetric to both planes; the edges of the face end in it.
    fn rim(&self) -> Vec<[f64; 2]> {
        let edge = 0.5 * self.face_width;
        let mut quarter: Vec<[f64; 2]> = (0..=QUARTER)
            .map(|i| match i {
                0 => [self.radius, 0.0],
                QUARTER => [0.0, self.radius],
                _ => {
                    let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_2 * i as f64 / QUARTER as f64);
                    [self.radius * cos, self.radius * sin]
                }
            })
            .filter(|[x, _]| (x - edge).abs() > 0.02 * self.radius)
            .collect();
        if edge < 0.98 * self.radius {
            quarter.push([edge, (self.radius * self.radius - edge * edge).sqrt()]);
        }
        quarter.sort_by(|a, b| b[0].total_cmp(&a[0]));
        let turned_back = || quarter.iter().rev().skip(usize::from(quarter.last().is_some_and(|p| p[0] == 0.0)));
        let half: Vec<[f64; 2]> = quarter.iter().copied().chain(turned_back().map(|[x, y]| [-x, *y])).collect();
        let lower = half.iter().filter(|[_, y]| *y > 0.0).map(|[x, y]| [-x, -y]);
        half.iter().copied().chain(lower).collect()
    }

    fn triangles(&self) -> Vec<[Vector3; 3]> {
        let edge = 0.5 * self.face_width;
        let rim = self.rim();
        let front: Vec<Vector3> = rim.iter().map(|[x, y]| Vector3::new(*x, *y, self.front(*x))).collect();
        let base: Vec<Vector3> = rim.iter().map(|[x, y]| Vector3::new(*x, *y, self.length)).collect();
        let n = rim.len();
        let sides = (0..n).flat_map(|i| {
            let j = (i + 1) % n;
            [[front[i], front[j], base[j]], [front[i], base[j], base[i]]]
        });
        let part = |is_part: &dyn Fn(f64) -> bool| -> Vec<Vector3> {
            front.iter().copied().filter(|corner| is_part(corner.x)).collect()
        };
        // Corners in the order of the rim bound each flat: the right one is cut by the start of the list.
        let right = {
            let at = front.iter().position(|corner| corner.y < 0.0 && corner.x >= edge).unwrap_or(0);
            let mut turned = front.clone();
            turned.rotate_left(at);
            turned.into_iter().filter(|corner| corner.x >= edge).collect()
        };
        let flats = [part(&|x| x.abs() <= edge), right, part(&|x| x <= -edge)];
        let mut triangles: Vec<[Vector3; 3]> = sides.collect();
        triangles.extend(flats.iter().flat_map(|flat| fan(flat)).map(|[a, b, c]| [a, c, b]));
        triangles.extend(fan(&base));
        triangles
    }
}

/// Triangles of a convex polygon.
fn fan(polygon: &[Vector3]) -> Vec<[Vector3; 3]> {
    polygon.windows(2).skip(1).map(|pair| [polygon[0], pair[0], pair[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::ChiselCylinder;
    use crate::geometry::SignedDistance;
    use crate::math::Vector3;

    /// The fragment simulating projectile of 1.1 g.
    const FRAGMENT: ChiselCylinder =
        ChiselCylinder { radius: 2.6925e-3, length: 6.35e-3, face_width: 2.54e-3, slope: 0.700_207_538_209_709_8 };

    #[test]
    fn steel_of_the_outline_of_the_fragment_weighs_1_1_grams() {
        let body = FRAGMENT.solid().unwrap();
        let mass = 7850.0 * body.volume().unwrap();
        assert!((mass / 1.102e-3 - 1.0).abs() < 0.01, "{mass}");
        // The closed form: the cylinder less the two cuts, by Simpson's rule over x.
        let (r, edge, n) = (FRAGMENT.radius, 0.5 * FRAGMENT.face_width, 2000);
        let step = (r - edge) / f64::from(n);
        let cut = |x: f64| 2.0 * (r * r - x * x).max(0.0).sqrt() * (x - edge) * FRAGMENT.slope;
        let weight = |i: i32| if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        let cuts: f64 = (0..=n).map(|i| weight(i) * cut(edge + f64::from(i) * step)).sum::<f64>() * step / 3.0;
        let exact = std::f64::consts::PI * r * r * FRAGMENT.length - 2.0 * cuts;
        assert!((body.volume().unwrap() / exact - 1.0).abs() < 3e-3);
    }

    #[test]
    fn the_face_is_flat_and_the_body_symmetric_to_two_planes() {
        let body = FRAGMENT.solid().unwrap();
        let nose = body.reach(&-Vector3::z());
        assert!((nose + body.reach(&Vector3::z()) - FRAGMENT.length).abs() < 1e-15);
        for x in [-1.2e-3, 0.0, 1.2e-3] {
            let gap = body.gap(&Vector3::new(x, 0.4e-3, -nose - 1e-3));
            assert!((gap.distance - 1e-3).abs() < 1e-12, "{x}: {}", gap.distance);
        }
        let beside = body.gap(&Vector3::new(2.6e-3, 0.0, -nose));
        assert!(beside.distance > 0.5e-3, "the flat slopes back: {}", beside.distance);
        assert!(body.centre().x.abs() < 1e-18 && body.centre().y.abs() < 1e-18);
        for mirrored in [Vector3::new(-1e-3, 2e-3, 1e-3), Vector3::new(1e-3, -2e-3, 1e-3)] {
            let whole = body.gap(&Vector3::new(1e-3, 2e-3, 1e-3)).distance;
            assert!((body.gap(&mirrored).distance - whole).abs() < 1e-15);
        }
    }
}
