//! The point of a triangle that is nearest to a point.

use crate::math::Vector3;

/// What part of a triangle a point lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Feature {
    /// Its inside.
    Face,
    /// The edge opposite to a corner.
    Edge(usize),
    /// A corner.
    Corner(usize),
}

/// The nearest point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Closest {
    pub point: Vector3,
    pub feature: Feature,
    /// Square of its distance.
    pub square: f64,
}

/// The foot of the perpendicular if it is inside; else the nearest point of those edges that it is beyond: by the
/// condition of optimality for a convex set the nearest point lies on one of them.
pub(super) fn closest(corners: &[Vector3; 3], p: &Vector3) -> Closest {
    let arms = corners.map(|corner| corner - p);
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let square = normal.norm_squared();
    let parts = [0, 1, 2].map(|i| normal.dot(&arms[(i + 1) % 3].cross(&arms[(i + 2) % 3])));
    if square > 0.0 && parts.iter().all(|part| *part >= 0.0) {
        let foot = normal * (normal.dot(&arms[0]) / square);
        return Closest { point: p + foot, feature: Feature::Face, square: foot.norm_squared() };
    }
    let beyond = (0..3).filter(|i| square == 0.0 || parts[*i] < 0.0);
    let edges = beyond.map(|i| closest_of_edge(corners, i, p));
    edges.reduce(|best, edge| if edge.square < best.square { edge } else { best }).expect("a point is beyond an edge")
}

fn closest_of_edge(corners: &[Vector3; 3], i: usize, p: &Vector3) -> Closest {
    let (a, b) = ((i + 1) % 3, (i + 2) % 3);
    let along = corners[b] - corners[a];
    let t = (p - corners[a]).dot(&along) / along.norm_squared();
    let (point, feature) = if t <= 0.0 {
        (corners[a], Feature::Corner(a))
    } else if t >= 1.0 {
        (corners[b], Feature::Corner(b))
    } else {
        (corners[a] + along * t, Feature::Edge(i))
    };
    Closest { point, feature, square: (p - point).norm_squared() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [Vector3; 3] =
        [Vector3::new(0.0, 0.0, 0.0), Vector3::new(4.0, 0.0, 0.0), Vector3::new(-3.0, 1.0, 0.0)];

    /// The nearest of many points all over the triangle.
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
            let found = closest(&TRIANGLE, &p);
            let (distance, near) = (found.square.sqrt(), sampled(&p));
            assert!((distance - (found.point - p).norm()).abs() < 1e-14);
            assert!(distance <= near + 1e-14 && near - distance < 0.01, "{p}: {distance} {near}");
        }
    }

    #[test]
    fn features_are_told_apart() {
        let at = |x: f64, y: f64| closest(&TRIANGLE, &Vector3::new(x, y, 1.0)).feature;
        assert_eq!(
            (at(0.3, 0.1), at(1.0, -1.0), at(-0.1, -1.0)),
            (Feature::Face, Feature::Edge(2), Feature::Corner(0))
        );
        assert_eq!(
            (at(5.0, 0.1), at(-4.0, 1.0), at(1.0, 2.0)),
            (Feature::Corner(1), Feature::Corner(2), Feature::Edge(0))
        );
    }

    #[test]
    fn a_triangle_without_an_area_is_its_edges() {
        let flat = [Vector3::zeros(), Vector3::x(), 2.0 * Vector3::x()];
        let found = closest(&flat, &Vector3::new(1.5, 2.0, 0.0));
        assert_eq!(found.point, 1.5 * Vector3::x());
        assert_ne!(found.feature, Feature::Face);
    }
}
