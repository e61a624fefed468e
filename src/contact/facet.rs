//! Deepest point of a facet in a body (method 2.6): between the nodes nothing else holds the surface.

use crate::geometry::Gap;
use crate::math::Vector3;

/// Deepest point of a facet inside a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeepestPoint {
    /// Position, m.
    pub point: Vector3,
    /// Weights of the corners of the facet.
    pub weights: [f64; 3],
    /// φ and n at the point.
    pub gap: Gap,
}

/// Maximum number of points queried on a facet. It finds the depth of a facet stretched over a sharp rim to a tenth.
const MAX_QUERIES: u32 = 16;
/// Tolerance that ends the search: the depth yet to be gained, relative to the allowed depth.
const TOLERANCE: f64 = 0.1;

/// Returns the normal of a facet out of the gel, of any length. An edge of a plane gel is a strip across the plane.
#[inline]
pub(super) fn outward_normal<const D: usize>(corners: &[Vector3; 3]) -> Vector3 {
    let b = corners[1] - corners[0];
    b.cross(&if D == 3 { corners[2] - corners[0] } else { -Vector3::y() })
}

/// Returns the corner of a facet towards which φ of a convex body falls most, and that bound min_i n·(x_i − x) of its
/// change, m.
fn steepest_corner(gap: &Gap, point: &Vector3, corners: &[Vector3]) -> (usize, f64) {
    let falls = corners.iter().map(|x| gap.normal.dot(&(x - point))).enumerate();
    falls.fold((0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
}

/// Returns a lower bound of φ on a facet for a convex body, m: φ(x) + min_i n·(x_i − x), x its centroid.
pub(super) fn distance_lower_bound<const D: usize>(corners: &[Vector3; 3], gap: impl Fn(&Vector3) -> Gap) -> f64 {
    let corners = &corners[..D];
    let middle = corners.iter().sum::<Vector3>() / D as f64;
    let gap = gap(&middle);
    gap.distance + steepest_corner(&gap, &middle, corners).1
}

/// Returns the weights of the corners of a facet at its centroid.
fn middle_weights<const D: usize>() -> [f64; 3] {
    std::array::from_fn(|i| if i < D { 1.0 / D as f64 } else { 0.0 })
}

/// Returns the point of a facet with these weights of its corners, m.
fn point_at<const D: usize>(corners: &[Vector3; 3], weights: &[f64; 3]) -> Vector3 {
    (0..D).map(|i| corners[i] * weights[i]).sum()
}

/// Returns the centroid of a facet, m.
pub(super) fn centroid<const D: usize>(corners: &[Vector3; 3]) -> Vector3 {
    point_at::<D>(corners, &middle_weights::<D>())
}

/// Finds the deepest point of a facet that is deeper than `allowed`, m, by the Frank–Wolfe method from the centroid,
/// where φ and n are `middle`.
///
/// φ of a convex body is convex along the facet, and bounded below by φ(x) + min_i n·(x_i − x). Where the bound is
/// not deeper than allowed, one query at the centroid is enough. For a body that is not convex the deepest queried
/// point is taken.
///
/// At a sharp rim the body has two normals, with the facet's between them, and the facet's normal is taken there.
/// Elsewhere the body's own normal is taken, to keep a smooth ball without friction from turning.
pub(crate) fn find_deepest_point<const D: usize>(
    corners: &[Vector3; 3],
    middle: &Gap,
    allowed: f64,
    gap: impl Fn(&Vector3) -> Gap,
) -> Option<DeepestPoint> {
    let mut weights = middle_weights::<D>();
    let mut best: Option<DeepestPoint> = None;
    for query in 0..MAX_QUERIES {
        let point = point_at::<D>(corners, &weights);
        let found_gap = if query == 0 { *middle } else { gap(&point) };
        let least_distance = best.map_or(-allowed, |best| best.gap.distance);
        if found_gap.distance < least_distance {
            best = Some(DeepestPoint { point, weights, gap: found_gap });
        }
        let (corner, slope) = steepest_corner(&found_gap, &point, &corners[..D]);
        let threshold = best.map_or(-allowed, |best| best.gap.distance - TOLERANCE * allowed);
        if found_gap.distance + slope >= threshold {
            break;
        }
        let step = 2.0 / (f64::from(query) + 3.0);
        weights = weights.map(|w| (1.0 - step) * w);
        weights[corner] += step;
    }
    let inward = -outward_normal::<D>(corners).normalize();
    best.map(|deep| if deep.is_at_rim(&inward, gap) { deep.with_normal(inward) } else { deep })
}

impl DeepestPoint {
    /// Returns true if the normal of the body turns to another face a little further towards the facet's normal. A
    /// quarter of the depth away, the normal of a ball as large as a cell turns by 10° at most.
    fn is_at_rim(&self, inward: &Vector3, gap: impl Fn(&Vector3) -> Gap) -> bool {
        const OFFSET: f64 = 0.25;
        const MAX_COSINE: f64 = 0.9;
        let normal = self.gap.normal;
        let aside = inward - normal * normal.dot(inward);
        let faces = normal.dot(inward) > 0.0;
        let beside = || gap(&(self.point - aside.normalize() * (OFFSET * self.gap.distance))).normal;
        faces && aside.norm() > 0.1 && normal.dot(&beside()) < MAX_COSINE
    }

    /// Replaces the normal.
    fn with_normal(self, normal: Vector3) -> Self {
        Self { gap: Gap { normal, ..self.gap }, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_surface;
    use super::*;
    use crate::geometry::{
        HalfSpace, ProfileBody, ProfileOutline, ProfileSweep, RoundedCuboid, ShapeGeometry, SignedDistance, Sphere,
    };

    /// Finds the deepest point of a facet from its centroid.
    fn deepest<const D: usize>(
        corners: &[Vector3; 3],
        allowed: f64,
        gap: impl Fn(&Vector3) -> Gap,
    ) -> Option<DeepestPoint> {
        find_deepest_point::<D>(corners, &gap(&centroid::<D>(corners)), allowed, gap)
    }

    #[test]
    fn one_query_is_enough_for_a_facet_outside_the_body() {
        let corners = [Vector3::x(), Vector3::y(), -Vector3::x()].map(|p| 0.1 * p - Vector3::z());
        let n_queries = std::cell::Cell::new(0);
        let ball = Sphere { radius: 1.0 };
        let gap = |p: &Vector3| {
            n_queries.set(n_queries.get() + 1);
            ball.gap(p)
        };
        assert_eq!(deepest::<3>(&corners, 0.02, gap), None);
        assert_eq!(n_queries.get(), 1);
    }

    /// Checks that no point of a facet is nearer to a body than [`distance_lower_bound`], less the travel of both.
    fn check_distance_bound<const D: usize>(shape: &ShapeGeometry) {
        let any = test_surface::any;
        let vector = |i: usize| Vector3::new(any(i * i), any(7 * i * i + 3), any(13 * i * i + 5));
        let mut deep = 0;
        for i in (0..3000).step_by(11) {
            let corners = [0, 3, 6].map(|k| 1.5 * vector(i + k));
            let proved = distance_lower_bound::<D>(&corners, |x| shape.gap(x));
            let (gone, body) = (0.2 * any(i + 40).abs(), 0.1 * vector(i + 50));
            let moved: Vec<Vector3> = (0..D).map(|k| corners[k] + gone * vector(i + 7 * k).normalize()).collect();
            for j in 0..30 {
                let parts: Vec<f64> = (0..D).map(|k| any(i + 5 * j + k).abs()).collect();
                let point = (0..D).map(|k| moved[k] * parts[k]).sum::<Vector3>() / parts.iter().sum::<f64>();
                let distance = shape.gap(&(point - body)).distance;
                assert!(distance >= proved - gone - body.norm() - 1e-12, "{distance}, {proved} were proved");
                deep += usize::from(distance < 0.0);
            }
        }
        assert!(deep > 100, "{deep} points were in the body");
    }

    #[test]
    fn the_distance_bound_holds_at_every_point_of_a_facet() {
        let plate = RoundedCuboid::new([1.2, 0.8, 0.6], 0.05);
        let half_space = HalfSpace::new(Vector3::new(0.6, 0.0, 0.8));
        for shape in [
            ShapeGeometry::Sphere(Sphere { radius: 0.7 }),
            ShapeGeometry::Plate(plate),
            ShapeGeometry::HalfSpace(half_space),
        ] {
            assert!(shape.is_blunt());
            check_distance_bound::<2>(&shape);
            check_distance_bound::<3>(&shape);
        }
    }

    #[test]
    fn the_deepest_point_is_found_beside_the_middle() {
        let ball = Sphere { radius: 1.0 };
        // A long edge at a depth of 0.5, its deepest point a tenth from one end.
        let corners = [-0.4, 3.6, 0.0].map(|x| Vector3::new(x, 0.0, -0.5));
        let found = deepest::<2>(&corners, 0.1, |p| ball.gap(p)).unwrap();
        assert!((found.gap.distance + 0.5).abs() < 0.02 && found.point.x.abs() < 0.25, "{found:?}");
        assert_eq!(found.gap.normal, found.point.normalize(), "a ball pushes along its radius");
        assert!((found.weights[0] + found.weights[1] - 1.0).abs() < 1e-15 && found.weights[2] == 0.0);
        // A triangle whose middle is outside.
        let corners = [Vector3::new(-0.2, -0.2, -0.7), Vector3::new(4.0, 0.0, -0.7), Vector3::new(0.0, 4.0, -0.7)];
        assert!(ball.gap(&(corners.iter().sum::<Vector3>() / 3.0)).distance > 0.5);
        let found = deepest::<3>(&corners, 0.1, |p| ball.gap(p)).unwrap();
        assert!((found.gap.distance + 0.3).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn a_sharp_rim_is_found_wherever_it_crosses_a_stretched_edge() {
        let outline = ProfileOutline::at_tip().line(1.0, 0.0).line(1.0, 2.0).line(0.0, 2.0);
        let cylinder = ProfileBody::new(&outline, ProfileSweep::Revolution);
        // An edge across the rim at 45°, 0.3 deep there, ten times as long.
        let (rim, along) = (Vector3::new(1.0, 0.0, -1.0), Vector3::new(1.0, 0.0, 1.0).normalize());
        let inward = Vector3::new(-1.0, 0.0, 1.0).normalize();
        for place in 1..20 {
            let start = rim + inward * 0.3 - along * (3.0 * f64::from(place) / 20.0);
            // Run through with the gel on its left, as the gel is outside the cylinder.
            let corners = [start + along * 3.0, start, start];
            let found = deepest::<2>(&corners, 0.05, |p| cylinder.gap(p));
            // Where the rim is not at the end of the edge.
            let between = found.is_some_and(|deep| deep.gap.normal.dot(&inward).abs() > 0.999);
            assert!(between || !(4..=16).contains(&place), "{place}: {found:?}");
            let found = found.map_or(0.0, |deep| -deep.gap.distance);
            let exact = (0..=3000).map(|i| -cylinder.gap(&(start + along * (f64::from(i) * 1e-3))).distance);
            let exact = exact.fold(0.0, f64::max);
            assert!(found > 0.85 * exact, "{place}: {found} of {exact}");
        }
    }
}
