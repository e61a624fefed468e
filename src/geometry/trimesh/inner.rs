//! Inner point of a tip: a point inside the body that a straight line from the tip reaches.

use super::exact::ExactDistance;
use crate::math::Vector3;

/// Distances from the tip at which the middle of the body is sought, in radii of the greatest inscribed ball. They
/// range from the finest scale at which a tip is sharp to twice the coarsest mesh allowed.
const DISTANCES: [f64; 5] = [0.125, 0.25, 0.5, 1.0, 2.0];
/// Clearance, as a part of the distance from the tip, below which a line leaves the body.
const GRAZING: f64 = 1e-3;
/// Part of a line next to the tip that is not tested.
const START: f64 = 1e-3;

/// Finds the inner point of a tip. It is the centre of mass if the line from the tip to it stays inside, as in a convex
/// body. Otherwise it is the furthest point reached by a line that follows the deepest points from the tip. `None` if
/// no line leads inside.
pub(super) fn inner_point(
    solid: &ExactDistance,
    inner_radius: f64,
    tip: &Vector3,
    inward: &Vector3,
) -> Option<Vector3> {
    if stays_inside(solid, tip, &Vector3::zeros()) {
        return Some(Vector3::zeros());
    }
    let mut direction = *inward;
    let mut found = None;
    for distance in DISTANCES.map(|part| part * inner_radius) {
        direction = deepest_direction(solid, tip, direction, distance);
        let point = tip + direction * distance;
        if stays_inside(solid, tip, &point) {
            found = Some(point);
        }
    }
    found
}

/// Direction in which the point at this distance from the tip is deepest, by pattern search from `first`.
fn deepest_direction(solid: &ExactDistance, tip: &Vector3, first: Vector3, distance: f64) -> Vector3 {
    const SMALLEST: f64 = 1e-3;
    let depth = |direction: &Vector3| -solid.gap(&(tip + direction * distance)).distance;
    let (mut best, mut at, mut step) = (depth(&first), first, 0.5);
    while step > SMALLEST {
        let aside = (0..6).map(|i| Vector3::ith(i / 2, if i % 2 == 0 { step } else { -step }));
        let turned = aside.map(|aside| (at + aside).normalize());
        match turned.map(|direction| (depth(&direction), direction)).find(|(found, _)| *found > best) {
            Some(found) => (best, at) = found,
            None => step *= 0.5,
        }
    }
    at
}

/// Returns true if the segment from a tip to a point stays inside the body; marches by inscribed balls (sphere
/// tracing).
fn stays_inside(solid: &ExactDistance, tip: &Vector3, point: &Vector3) -> bool {
    let (line, length) = (point - tip, (point - tip).norm());
    let mut way = START * length;
    while way < length {
        let depth = -solid.gap(&(tip + line * (way / length))).distance;
        if depth <= GRAZING * way {
            return false;
        }
        way += depth;
    }
    true
}
