//! How many times a surface winds around a point: 1 inside of a body, 0 outside.

use super::field::Field;
use super::surface::SurfaceError;
use super::tree::Tree;
use crate::math::Vector3;

/// Nearer to the surface than this part of the size of the body is round-off.
const ROUND_OFF: f64 = 1e-7;

/// Where a line along an axis passes through the surface, and by how much the winding number grows there.
type Passage = (f64, i32);

/// What is wrong with a surface at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    Overlapping,
    InsideOut,
}

impl Fault {
    pub fn error(self, at: [f64; 3]) -> SurfaceError {
        match self {
            Self::Overlapping => SurfaceError::Overlapping { at },
            Self::InsideOut => SurfaceError::InsideOut { at },
        }
    }
}

/// What the lines of the grid find: a stretch around which the surface winds more than once or backwards, or a node that
/// its distance has on the other side than its winding number. Of what overlaps, only a part that is smaller than a cell
/// across two axes, and that no node is nearest to, is not seen.
pub(super) fn fault(tree: &Tree, field: &Field, exact: impl Fn(&Vector3) -> f64) -> Option<(Fault, Vector3)> {
    let slack = ROUND_OFF * field.extent().norm();
    let starts = (0..3).flat_map(|axis| field.lines(axis).map(move |start| (axis, start)));
    let lines: Vec<_> = starts.map(|(axis, start)| (axis, start, passages(tree, field, axis, start))).collect();
    let overlap = lines.iter().find_map(|(axis, start, passages)| {
        stretches(passages).filter(|(from, to, _)| to - from > slack).find_map(|(from, to, winding)| {
            let middle = on_line(field.at(*start), *axis, 0.5 * (from + to));
            refused(winding).filter(|_| exact(&middle).abs() > slack).map(|fault| (fault, middle))
        })
    });
    let line = |(axis, start, passages): &(usize, usize, Vec<Passage>)| {
        wrong_side(passages, field.line(*axis, *start), *axis, slack)
    };
    overlap.or_else(|| lines.iter().find_map(line))
}

/// The winding number of a body is 0 or 1.
fn refused(winding: i32) -> Option<Fault> {
    match winding {
        0 | 1 => None,
        ..0 => Some(Fault::InsideOut),
        2.. => Some(Fault::Overlapping),
    }
}

/// The first node of a line whose distance has another sign than its winding number says.
fn wrong_side(
    passages: &[Passage],
    mut nodes: impl Iterator<Item = (Vector3, f64)>,
    axis: usize,
    slack: f64,
) -> Option<(Fault, Vector3)> {
    let inside =
        |p: &Vector3| passages.iter().take_while(|(at, _)| *at < p[axis]).map(|(_, step)| step).sum::<i32>() > 0;
    let wrong = |(p, distance): &(Vector3, f64)| distance.abs() > slack && inside(p) != (*distance < 0.0);
    nodes.find(wrong).map(|(p, distance)| (if distance < 0.0 { Fault::InsideOut } else { Fault::Overlapping }, p))
}

/// The stretches between the passages, and their winding numbers.
fn stretches(passages: &[Passage]) -> impl Iterator<Item = (f64, f64, i32)> + '_ {
    let winding = passages.iter().scan(0, |sum, (_, step)| {
        *sum += step;
        Some(*sum)
    });
    passages.windows(2).zip(winding).map(|(pair, winding)| (pair[0].0, pair[1].0, winding))
}

/// The passages of the line through a node, in their order.
fn passages(tree: &Tree, field: &Field, axis: usize, start: usize) -> Vec<Passage> {
    let (p, mut passages) = (field.at(start), vec![]);
    let ends = [-1.0, 1.0].map(|side| on_line(p, axis, p[axis] + side * 2.0 * field.extent().norm()));
    tree.around(&ends, &mut |_, corners| passages.extend(passage(corners, &p, axis)));
    passages.sort_by(|a, b| a.0.total_cmp(&b.0));
    passages
}

fn on_line(mut p: Vector3, axis: usize, at: f64) -> Vector3 {
    p[axis] = at;
    p
}

/// Where the line through a point passes through a triangle. Seen along the axis, an edge belongs to one of the triangles at
/// it, also in round-off: for both the same numbers are computed from its ends.
fn passage(corners: &[Vector3; 3], p: &Vector3, axis: usize) -> Option<Passage> {
    let turns: i32 = (0..3).map(|i| turn(&corners[i], &corners[(i + 1) % 3], p, axis)).sum();
    if turns == 0 {
        return None;
    }
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let (arm, along) = (p - corners[0], corners.map(|corner| corner[axis]));
    let slope = (normal.dot(&arm) - normal[axis] * arm[axis]) / normal[axis];
    let (low, high) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
    let at = if slope.is_finite() { (along[0] - slope).clamp(low, high) } else { low };
    Some((at, -turns))
}

/// ±1 if, seen against the axis, the edge passes above the point, counted counter-clockwise.
fn turn(a: &Vector3, b: &Vector3, p: &Vector3, axis: usize) -> i32 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (left, leftwards) = (a[u] <= p[u], b[u] <= p[u]);
    if left == leftwards {
        return 0;
    }
    let (low, high) = if a[u] < b[u] { (a, b) } else { (b, a) };
    let at = low[v] + (high[v] - low[v]) * ((p[u] - low[u]) / (high[u] - low[u]));
    // By rounding it would be beyond its end, and a triangle count that the line is beside.
    let at = at.clamp(low[v].min(high[v]), low[v].max(high[v]));
    match (at > p[v], leftwards) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => -1,
    }
}
