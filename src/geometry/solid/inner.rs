//! The point inside of a body that a tip leads to.

use super::Solid;
use crate::geometry::SignedDistance as _;
use crate::math::Vector3;

/// Distances from the tip at which the middle of the body is looked for, in radii of the greatest ball inside: from the
/// finest that a tip is sharp at to twice the coarsest mesh allowed.
const DISTANCES: [f64; 5] = [0.125, 0.25, 0.5, 1.0, 2.0];
/// A line that comes nearer to the surface than this part of the way from the tip leaves the body.
const GRAZING: f64 = 1e-3;
/// The part of a line at the tip that is not looked at.
const START: f64 = 1e-3;

/// The centre of mass if the line from the tip to it stays inside, as it does in a convex body; else the furthest point
/// that a line inside leads to, along the middle of what ends in the tip. `None` if no line leads inside.
pub(super) fn inner(solid: &Solid, tip: &Vector3, inward: &Vector3) -> Option<Vector3> {
    if stays_inside(solid, tip, &Vector3::zeros()) {
        return Some(Vector3::zeros());
    }
    let mut direction = *inward;
    let mut found = None;
    for distance in DISTANCES.map(|part| part * solid.inner_radius()) {
        direction = deepest(solid, tip, direction, distance);
        let point = tip + direction * distance;
        if stays_inside(solid, tip, &point) {
            found = Some(point);
        }
    }
    found
}

/// The direction, from a first one, in which the point at this distance from the tip is deepest.
fn deepest(solid: &Solid, tip: &Vector3, first: Vector3, distance: f64) -> Vector3 {
    const SMALLEST: f64 = 1e-3;
    let depth = |direction: &Vector3| -solid.exact(&(tip + direction * distance)).distance;
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

/// Whether the line from a tip to a point stays inside: from ball to ball that fits in.
fn stays_inside(solid: &Solid, tip: &Vector3, point: &Vector3) -> bool {
    let (line, length) = (point - tip, (point - tip).norm());
    let mut way = START * length;
    while way < length {
        let depth = -solid.exact(&(tip + line * (way / length))).distance;
        if depth <= GRAZING * way {
            return false;
        }
        way += depth;
    }
    true
}
