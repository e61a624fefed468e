//! Closest point of a triangle to a query point.

use crate::math::Vector3;

/// Feature of a triangle that contains a point: face, edge or corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TriangleFeature {
    /// Interior of the triangle.
    Face,
    /// Edge opposite a corner.
    Edge(usize),
    /// Corner.
    Corner(usize),
}

/// Closest point, its feature and its distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClosestPoint {
    pub point: Vector3,
    pub feature: TriangleFeature,
    /// Squared distance, m².
    pub square: f64,
}

/// Closest point of a triangle: the foot of the perpendicular if it is inside. Otherwise the closest point of those
/// edges that the query point is beyond: by the optimality condition of a convex set it lies on one of them.
pub(super) fn closest_point(corners: &[Vector3; 3], p: &Vector3) -> ClosestPoint {
    let arms = corners.map(|corner| corner - p);
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let square = normal.norm_squared();
    let parts = [0, 1, 2].map(|i| normal.dot(&arms[(i + 1) % 3].cross(&arms[(i + 2) % 3])));
    if square > 0.0 && parts.iter().all(|part| *part >= 0.0) {
        let foot = normal * (normal.dot(&arms[0]) / square);
        return ClosestPoint { point: p + foot, feature: TriangleFeature::Face, square: foot.norm_squared() };
    }
    let beyond = (0..3).filter(|i| square == 0.0 || parts[*i] < 0.0);
    let edges = beyond.map(|i| closest_on_edge(corners, i, p));
    edges.reduce(|best, edge| if edge.square < best.square { edge } else { best }).expect("a point is beyond an edge")
}

fn closest_on_edge(corners: &[Vector3; 3], i: usize, p: &Vector3) -> ClosestPoint {
    let (a, b) = ((i + 1) % 3, (i + 2) % 3);
    let along = corners[b] - corners[a];
    let t = (p - corners[a]).dot(&along) / along.norm_squared();
    let (point, feature) = if t <= 0.0 {
        (corners[a], TriangleFeature::Corner(a))
    } else if t >= 1.0 {
        (corners[b], TriangleFeature::Corner(b))
    } else {
        (corners[a] + along * t, TriangleFeature::Edge(i))
    };
    ClosestPoint { point, feature, square: (p - point).norm_squared() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vector3; 3] =
        [Vector3::new(0.0, 0.0, 0.0), Vector3::new(4.0, 0.0, 0.0), Vector3::new(-3.0, 1.0, 0.0)];

    /// Distance to the nearest of many sample points of the triangle.
    fn sampled(p: &Vector3) -> f64 {
        const N: u32 = 400;
        let [a, b, c] = TRIANGLE;
        let point = move |i: u32, j: u32| a + ((b - a) * f64::from(i) + (c - a) * f64::from(j)) / f64::from(N);
        let all = (0..=N).flat_map(move |i| (0..=N - i).map(move |j| point(i, j)));
        all.map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_nearest_point_of_an_obtuse_triangle_is_no_further_than_any_other() {
        for i in 0..300 {
            let t = f64::from(i);
            let p = Vector3::new(5.0 * (0.71 * t).sin(), 3.0 * (1.37 * t).cos(), (0.239 * t).sin());
            let found = closest_point(&TRIANGLE, &p);
            let (distance, near) = (found.square.sqrt(), sampled(&p));
            assert!((distance - (found.point - p).norm()).abs() < 1e-14);
            assert!(distance <= near + 1e-14 && near - distance < 0.01, "{p}: {distance} {near}");
        }
    }

    #[test]
    fn features_are_told_apart() {
        let at = |x: f64, y: f64| closest_point(&TRIANGLE, &Vector3::new(x, y, 1.0)).feature;
        assert_eq!(
            (at(0.3, 0.1), at(1.0, -1.0), at(-0.1, -1.0)),
            (TriangleFeature::Face, TriangleFeature::Edge(2), TriangleFeature::Corner(0))
        );
        assert_eq!(
            (at(5.0, 0.1), at(-4.0, 1.0), at(1.0, 2.0)),
            (TriangleFeature::Corner(1), TriangleFeature::Corner(2), TriangleFeature::Edge(0))
        );
    }

    #[test]
    fn a_triangle_without_an_area_is_its_edges() {
        let flat = [Vector3::zeros(), Vector3::x(), 2.0 * Vector3::x()];
        let found = closest_point(&flat, &Vector3::new(1.5, 2.0, 0.0));
        assert_eq!(found.point, 1.5 * Vector3::x());
        assert_ne!(found.feature, TriangleFeature::Face);
    }
}
