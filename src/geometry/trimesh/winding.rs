//! Winding number test of a closed surface: 1 inside a body, 0 outside.

use super::field::DistanceGrid;
use super::surface::SurfaceError;
use super::tree::TriangleTree;
use crate::math::Vector3;

/// Round-off limit of distances, as a part of the size of the body.
const ROUND_OFF: f64 = 1e-7;

/// Crossing of an axis-parallel line with the surface: coordinate and increment of the winding number.
#[derive(Debug, Clone, Copy)]
struct LineCrossing {
    /// Coordinate along the line, m.
    at: f64,
    /// Increment of the winding number.
    step: i32,
}

/// Defect of a surface at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SurfaceFault {
    Overlapping,
    InsideOut,
}

impl SurfaceFault {
    /// Converts the fault at a position to the error of the surface.
    pub fn error(self, at: [f64; 3]) -> SurfaceError {
        match self {
            Self::Overlapping => SurfaceError::Overlapping { at },
            Self::InsideOut => SurfaceError::InsideOut { at },
        }
    }
}

/// Searches the grid lines for a fault: a stretch with a winding number above 1 or below 0, or a node whose distance
/// has the wrong sign for its winding number. An overlap escapes only if it is smaller than a cell across two axes and
/// nearest to no node.
pub(super) fn find_fault(
    tree: &TriangleTree,
    field: &DistanceGrid,
    exact: impl Fn(&Vector3) -> f64,
) -> Option<(SurfaceFault, Vector3)> {
    let slack = ROUND_OFF * field.extent().norm();
    let starts = (0..3).flat_map(|axis| field.lines(axis).map(move |start| (axis, start)));
    let lines: Vec<_> = starts.map(|(axis, start)| (axis, start, line_crossings(tree, field, axis, start))).collect();
    let overlap = lines.iter().find_map(|(axis, start, crossings)| {
        stretches(crossings).filter(|(from, to, _)| to - from > slack).find_map(|(from, to, winding)| {
            let middle = on_line(field.position(*start), *axis, 0.5 * (from + to));
            winding_fault(winding).filter(|_| exact(&middle).abs() > slack).map(|fault| (fault, middle))
        })
    });
    let line = |(axis, start, crossings): &(usize, usize, Vec<LineCrossing>)| {
        wrong_side(crossings, field.line(*axis, *start), *axis, slack)
    };
    overlap.or_else(|| lines.iter().find_map(line))
}

/// Fault of a winding number; a body has 0 or 1.
fn winding_fault(winding: i32) -> Option<SurfaceFault> {
    match winding {
        0 | 1 => None,
        ..0 => Some(SurfaceFault::InsideOut),
        2.. => Some(SurfaceFault::Overlapping),
    }
}

/// First node of a line whose distance disagrees in sign with the winding number.
fn wrong_side(
    crossings: &[LineCrossing],
    mut nodes: impl Iterator<Item = (Vector3, f64)>,
    axis: usize,
    slack: f64,
) -> Option<(SurfaceFault, Vector3)> {
    let inside = |p: &Vector3| {
        crossings.iter().take_while(|crossing| crossing.at < p[axis]).map(|crossing| crossing.step).sum::<i32>() > 0
    };
    let wrong = |(p, distance): &(Vector3, f64)| distance.abs() > slack && inside(p) != (*distance < 0.0);
    nodes
        .find(wrong)
        .map(|(p, distance)| (if distance < 0.0 { SurfaceFault::InsideOut } else { SurfaceFault::Overlapping }, p))
}

/// Stretches between consecutive crossings, and their winding numbers.
fn stretches(crossings: &[LineCrossing]) -> impl Iterator<Item = (f64, f64, i32)> + '_ {
    let winding = crossings.iter().scan(0, |sum, crossing| {
        *sum += crossing.step;
        Some(*sum)
    });
    crossings.windows(2).zip(winding).map(|(pair, winding)| (pair[0].at, pair[1].at, winding))
}

/// Crossings of the grid line through a node, in ascending order.
fn line_crossings(tree: &TriangleTree, field: &DistanceGrid, axis: usize, start: usize) -> Vec<LineCrossing> {
    let (p, mut crossings) = (field.position(start), vec![]);
    let ends = [-1.0, 1.0].map(|side| on_line(p, axis, p[axis] + side * 2.0 * field.extent().norm()));
    tree.visit_near(&ends, &mut |_, corners| crossings.extend(triangle_crossing(corners, &p, axis)));
    crossings.sort_by(|a, b| a.at.total_cmp(&b.at));
    crossings
}

/// Replaces the coordinate along an axis.
fn on_line(mut p: Vector3, axis: usize, at: f64) -> Vector3 {
    p[axis] = at;
    p
}

/// Crossing of the line through a point with a triangle. Seen along the axis, an edge belongs to exactly one of its two
/// triangles, also in round-off: both compute the same numbers from its ends.
fn triangle_crossing(corners: &[Vector3; 3], p: &Vector3, axis: usize) -> Option<LineCrossing> {
    let turns: i32 = (0..3).map(|i| edge_turn(&corners[i], &corners[(i + 1) % 3], p, axis)).sum();
    if turns == 0 {
        return None;
    }
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let (arm, along) = (p - corners[0], corners.map(|corner| corner[axis]));
    let slope = (normal.dot(&arm) - normal[axis] * arm[axis]) / normal[axis];
    let (low, high) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
    let at = if slope.is_finite() { (along[0] - slope).clamp(low, high) } else { low };
    Some(LineCrossing { at, step: -turns })
}

/// Orientation: ±1 if, seen against the axis, the edge passes above the point, positive counter-clockwise; otherwise 0.
fn edge_turn(a: &Vector3, b: &Vector3, p: &Vector3, axis: usize) -> i32 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (left, leftwards) = (a[u] <= p[u], b[u] <= p[u]);
    if left == leftwards {
        return 0;
    }
    let (low, high) = if a[u] < b[u] { (a, b) } else { (b, a) };
    let at = low[v] + (high[v] - low[v]) * ((p[u] - low[u]) / (high[u] - low[u]));
    // Rounding could put the value beyond the edge's end, and a triangle beside the line would count.
    let at = at.clamp(low[v].min(high[v]), low[v].max(high[v]));
    match (at > p[v], leftwards) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => -1,
    }
}
