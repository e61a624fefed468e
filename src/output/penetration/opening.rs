//! How wide the gel is open around a vertical line, depth by depth.

use super::PER_METRE;
use crate::algebra::Vector3;
use crate::scene::Dimension;
use crate::simulation::Frame;

/// A piece of the surface of the gel at a depth, seen from the line.
type Piece = [nalgebra::Vector2<f64>; 2];

/// Radius of the opening at the first `n` millimetres of depth, m: 0 where the line runs through gel, none where there is no gel
/// around it.
///
/// Along the axis it is the least radius of the gel, in the plane half of the width, in space the distance of the surface.
pub(super) fn openings(dimension: Dimension, frame: &Frame, line: &Vector3, n: usize) -> Vec<Option<f64>> {
    let mut depths: Vec<Vec<Piece>> = vec![vec![]; n];
    for nodes in &frame.cells.facets {
        let corners = nodes.map(|node| frame.points[node as usize] - line);
        cut(&corners[..frame.dimension], line.z, &mut depths);
    }
    let opening = match dimension {
        Dimension::Planar => half_width,
        Dimension::Axisymmetric | Dimension::Spatial => distance,
    };
    depths.iter().map(|pieces| if is_inside(pieces) { Some(0.0) } else { opening(pieces) }).collect()
}

/// Adds what a facet, given from a point at this height, is at each depth that it crosses.
fn cut(corners: &[Vector3], height: f64, depths: &mut [Vec<Piece>]) {
    let down = |corner: &Vector3| -(corner.z + height) * PER_METRE;
    let (least, most) =
        corners.iter().map(down).fold((f64::INFINITY, 0.0f64), |(least, most), k| (least.min(k), most.max(k)));
    let first = least.max(1.0).ceil() as usize;
    for k in first..=(most as usize).min(depths.len()) {
        let z = -(k as f64 / PER_METRE) - height;
        let sides = corners.iter().zip(corners.iter().cycle().skip(1)).take(if corners.len() == 2 { 1 } else { 3 });
        let mut ends = sides.filter_map(|(a, b)| crossing(a, b, z));
        if let Some(a) = ends.next() {
            depths[k - 1].push([a, ends.next().unwrap_or(a)]);
        }
    }
}

/// Where an edge crosses a height; of its two ends one counts as below.
fn crossing(a: &Vector3, b: &Vector3, z: f64) -> Option<nalgebra::Vector2<f64>> {
    let crosses = (a.z > z) != (b.z > z);
    crosses.then(|| (a + (b - a) * ((z - a.z) / (b.z - a.z))).xy())
}

/// Whether the line is in the gel: what goes from it towards +x leaves the gel once more than it enters.
fn is_inside(pieces: &[Piece]) -> bool {
    let crossed = |[a, b]: &&Piece| {
        if a == b {
            return a.x > 0.0;
        }
        (a.y > 0.0) != (b.y > 0.0) && a.x - a.y * (b.x - a.x) / (b.y - a.y) > 0.0
    };
    pieces.iter().filter(crossed).count() % 2 == 1
}

/// From the line to the nearest piece.
fn distance(pieces: &[Piece]) -> Option<f64> {
    let to = |[a, b]: &Piece| {
        let along = b - a;
        let share = if a == b { 0.0 } else { (-a.dot(&along) / along.norm_squared()).clamp(0.0, 1.0) };
        (a + share * along).norm()
    };
    pieces.iter().map(to).reduce(f64::min)
}

/// Half of what is open between gel on the left and gel on the right.
fn half_width(pieces: &[Piece]) -> Option<f64> {
    let right = pieces.iter().map(|[a, _]| a.x).filter(|x| *x >= 0.0).reduce(f64::min);
    let left = pieces.iter().map(|[a, _]| a.x).filter(|x| *x < 0.0).reduce(f64::max);
    right.zip(left).map(|(right, left)| 0.5 * (right - left))
}
