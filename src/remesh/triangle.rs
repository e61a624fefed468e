//! Triangles and segments in the plane.

use crate::math::{Vector, hypotenuse};

/// Point of the plane.
pub(super) type PlanarPoint = Vector<2>;

/// Twice the signed area of a triangle, m².
pub(super) fn cross(a: &PlanarPoint, b: &PlanarPoint, c: &PlanarPoint) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Distance of two points, m.
pub(super) fn distance(a: &PlanarPoint, b: &PlanarPoint) -> f64 {
    hypotenuse(b[0] - a[0], b[1] - a[1])
}

/// Mean-ratio quality of a triangle, q = 4√3 A/Σl²: 1 if equilateral, 0 if degenerate, negative if inverted.
pub(super) fn quality([a, b, c]: [&PlanarPoint; 3]) -> f64 {
    let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    if squares > 0.0 { 2.0 * 3.0_f64.sqrt() * cross(a, b, c) / squares } else { 0.0 }
}

/// Barycentric coordinates of a point in a triangle; not finite if the triangle is degenerate.
pub(super) fn barycentric([a, b, c]: [&PlanarPoint; 3], p: &PlanarPoint) -> [f64; 3] {
    let all = cross(a, b, c);
    let [first, second] = [cross(p, b, c) / all, cross(a, p, c) / all];
    [first, second, 1.0 - first - second]
}

/// Distance of a point from a segment, m.
pub(super) fn clearance([a, b]: [&PlanarPoint; 2], p: &PlanarPoint) -> f64 {
    let along = b - a;
    let squared = along.norm_squared();
    let share = if squared > 0.0 { ((p - a).dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    distance(&(a + share * along), p)
}

/// Returns true if two segments cross in a point inside both of them.
pub(super) fn do_cross([a, b]: [&PlanarPoint; 2], [c, d]: [&PlanarPoint; 2]) -> bool {
    let are_apart = |s: f64, t: f64| (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0);
    are_apart(cross(a, b, c), cross(a, b, d)) && are_apart(cross(c, d, a), cross(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: PlanarPoint = PlanarPoint::new(0.0, 0.0);
    const B: PlanarPoint = PlanarPoint::new(4.0, 0.0);
    const C: PlanarPoint = PlanarPoint::new(0.0, 3.0);

    #[test]
    fn shares_give_the_point_back() {
        let p = PlanarPoint::new(1.0, 0.7);
        let [s, t, u] = barycentric([&A, &B, &C], &p);
        assert!((A * s + B * t + C * u - p).norm() < 1e-15);
    }

    #[test]
    fn quality_is_one_for_equal_sides_and_negative_if_inverted() {
        let top = PlanarPoint::new(2.0, 12.0_f64.sqrt());
        assert!((quality([&A, &B, &top]) - 1.0).abs() < 1e-15);
        assert!((quality([&B, &A, &top]) + 1.0).abs() < 1e-15);
        assert_eq!(quality([&A, &A, &A]), 0.0);
    }

    #[test]
    fn distance_from_a_segment_ends_at_its_ends() {
        assert_eq!(clearance([&A, &B], &PlanarPoint::new(1.0, 2.0)), 2.0);
        assert_eq!(clearance([&A, &B], &PlanarPoint::new(7.0, 4.0)), 5.0);
        assert_eq!(clearance([&A, &A], &C), 3.0);
    }

    #[test]
    fn segments_that_only_touch_do_not_cross() {
        assert!(do_cross([&A, &PlanarPoint::new(4.0, 3.0)], [&B, &C]));
        assert!(!do_cross([&A, &B], [&A, &C]) && !do_cross([&A, &B], [&PlanarPoint::new(2.0, 0.0), &C]));
    }
}
