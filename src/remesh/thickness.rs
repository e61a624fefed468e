//! How thick the body is between two parts of its boundary that face each other.

use super::Moved;
use super::bounds::Bounds;
use super::near::Near;
use super::shape::{Point, clearance, distance};

/// Cosine of the angle between outward normals from which on two edges face each other, 120°.
const FACING: f64 = -0.5;

/// Target sizes that are nowhere larger than the body is thick, m: where boundary nodes are nearer to an edge that faces them
/// through the body than their size, that distance is their size. Where the body is thinner than its elements they are
/// needles, whatever else is done.
///
/// # Panics
/// Unless there is one size per node.
#[must_use]
pub fn confined(old: &Moved<'_, 2>, mut size: Vec<f64>) -> Vec<f64> {
    assert_eq!(size.len(), old.position.len(), "one size per node is needed");
    let x = old.position;
    let edges: Vec<[usize; 2]> = old.mesh.facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
    let near = Near::segments(&edges, x);
    let outward: Vec<Point> = edges.iter().map(|edge| normal(edge.map(|n| &x[n]))).collect();
    for (edge, out) in edges.iter().zip(&outward) {
        let middle = 0.5 * (x[edge[0]] + x[edge[1]]);
        let mut least = edge.iter().map(|&n| size[n]).fold(0.0, f64::max);
        near.any(&Bounds::about(&middle, least), |other| {
            let ends = edges[other].map(|n| &x[n]);
            let is_across = ends.iter().any(|end| (*end - middle).dot(out) < 0.0);
            if is_across && outward[other].dot(out) < FACING {
                least = least.min(clearance(ends, &middle));
            }
            false
        });
        for &n in edge {
            size[n] = size[n].min(least.max(f64::MIN_POSITIVE));
        }
    }
    size
}

/// Outward unit normal of an edge of the boundary, the body on its left; zero if it has no length.
fn normal([a, b]: [&Point; 2]) -> Point {
    let length = distance(a, b);
    if length > 0.0 { Point::new(b[1] - a[1], a[0] - b[0]) / length } else { Point::zeros() }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{moved, rings, square};
    use super::super::{Acceptance, Rules, judge, propose};
    use super::*;

    #[test]
    fn a_thin_strip_gets_elements_as_small_as_it_is_thick() {
        let mesh = square(8);
        let position = moved(&mesh, |x| Point::new(x[0], 0.05 * x[1]));
        let old = Moved { mesh: &mesh, position: &position };
        let size = confined(&old, vec![0.25; position.len()]);
        for (x, h) in position.iter().zip(&size) {
            let is_long_side = (x[1] == 0.0 || x[1] == 0.05) && x[0] > 0.0 && x[0] < 1.0;
            assert!(!is_long_side || (h - 0.05).abs() < 1e-12, "{h} at {x}");
        }
        let size = super::super::graded(&old, size, 0.3);
        let new = propose(&old, &size, &Rules::default()).unwrap();
        let found = judge(&old, &new, &Acceptance { area: 1e-12, quality: 0.4 });
        assert!(found.is_ok_and(|found| found.angle > 20.0), "{found:?}");
    }

    #[test]
    fn walls_that_face_each_other_across_a_gap_are_not_thin() {
        let mesh = rings(2, 0.25);
        // The gap between the rings and their holes become slits; the bodies stay 1 thick.
        let position = moved(&mesh, |x| if x[0] > 3.5 { x - Point::new(0.9, 0.0) } else { *x });
        let size = confined(&Moved { mesh: &mesh, position: &position }, vec![0.4; position.len()]);
        let limited = position.iter().zip(&size).filter(|(_, h)| **h < 0.2);
        assert_eq!(limited.count(), 0);
    }
}
