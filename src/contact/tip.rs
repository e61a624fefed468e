//! Tip-in-facet contact: facets pierced by a pole, an end or tip, of a body sharper than the mesh, which meets no
//! node (method 2.6).

use super::facet::outward_normal;
use super::tolerance::SLOP;
use super::{BodyState, RigidBody};
use crate::geometry::{Gap, SharpEnd, SignedDistance as _};
use crate::math::Vector3;

/// Margin beyond the edges of a facet within which it counts as pierced, in barycentric coordinates. Without it one
/// facet at a time holds a tip in the crease between two, and the tip slides down each in turn. A cone of 10 mm then
/// sank 0.7 cells of 3.3 mm deep and leaked. Margins from 0.01 to 0.2 prevent this, with the same depth of the body
/// to 0.1 %; at 0.5 facets far off carry contact.
const EDGE_MARGIN: f64 = 0.05;

/// Depth behind a facet at which a blunt pole is met, in the smaller of element size and inner radius of the body. A
/// pole is blunt if a ball of half the element size fits into it, but not one of the whole size. Met as late as 0.3,
/// a meplat of a third of a cell leaks at 20 m/s.
const BLUNT_DEPTH: f64 = 0.2;

/// Penetration of a facet by a tip: the line from a pole of the body inwards leaves the gel through the facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TipPenetration {
    /// Point where the line crosses the facet, m.
    pub point: Vector3,
    /// Barycentric coordinates of the point.
    pub weights: [f64; 3],
    /// Signed distance of the pole from the plane of the facet, negative behind it, and the normal into the gel.
    pub gap: Gap,
    /// Pole of the body, m.
    pub end: Vector3,
    /// Inner point of the body at the other end of the line, m.
    inner: Vector3,
}

/// Line inwards from a pole of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoleLine {
    /// Pole, m.
    end: Vector3,
    /// Inner point of the body at the other end of the line, m.
    inner: Vector3,
}

/// Returns the lines inwards from the poles of a body in a state.
pub(super) fn pole_lines(rigid: &RigidBody, state: &BodyState) -> Vec<PoleLine> {
    let to_world = |p: &Vector3| state.position + state.orientation.transform_vector(p);
    let line = |pole: &SharpEnd| PoleLine { end: to_world(&pole.end), inner: to_world(&pole.inner) };
    rigid.poles(state).iter().map(line).collect()
}

/// Finds where a line from a pole of a body inwards leaves the gel through a facet with these corners, m; the deepest
/// of several.
pub(super) fn find_penetration<const D: usize>(corners: &[Vector3; 3], lines: &[PoleLine]) -> Option<TipPenetration> {
    let penetrations = lines.iter().filter_map(|line| intersect_facet::<D>(corners, &line.end, &line.inner));
    penetrations.min_by(|a, b| a.gap.distance.total_cmp(&b.gap.distance))
}

impl TipPenetration {
    /// Returns true if the pole is behind a facet of this size, m, by more than its bluntness allows.
    pub(super) fn is_deep(&self, size: f64, rigid: &RigidBody, state: &BodyState) -> bool {
        -self.gap.distance > least_depth(self, size, rigid, state)
    }
}

/// Returns the depth behind a facet at which a pole of the body is met, m. A sharp pole, into which a ball of half
/// the element size does not fit, is met at once. A blunt pole, into which a ball of the whole size does not fit, can
/// still miss the nodes and is met at [`BLUNT_DEPTH`]. Nodes meet any other pole.
fn least_depth(tip: &TipPenetration, size: f64, rigid: &RigidBody, state: &BodyState) -> f64 {
    const ROUND_OFF: f64 = 1e-3;
    let fits = |radius: f64| {
        let inside = tip.end + (tip.inner - tip.end).normalize() * radius;
        -rigid.gap(state, &inside).distance >= radius * (1.0 - ROUND_OFF)
    };
    match (fits(0.5 * size), fits(size)) {
        (false, _) => SLOP * size,
        (true, false) => BLUNT_DEPTH * size.min(rigid.shape.inner_radius()),
        (true, true) => f64::INFINITY,
    }
}

/// Finds where the line from `pole` to `inner` passes from the back of a facet to its front, within the facet or just
/// beside it.
fn intersect_facet<const D: usize>(corners: &[Vector3; 3], pole: &Vector3, inner: &Vector3) -> Option<TipPenetration> {
    let (a, b) = (corners[0], corners[1] - corners[0]);
    let across = outward_normal::<D>(corners);
    let outward = across / across.norm();
    let (behind, before) = (outward.dot(&(a - pole)), outward.dot(&(inner - a)));
    if !(behind > 0.0 && before > 0.0) {
        return None;
    }
    let point = pole + (inner - pole) * (behind / (behind + before));
    let (beta, gamma) = if D == 3 {
        let part = |v: Vector3| v.dot(&across) / across.norm_squared();
        (part((point - a).cross(&(corners[2] - a))), part(b.cross(&(point - a))))
    } else {
        ((point - a).dot(&b) / b.norm_squared(), 0.0)
    };
    let weights = [1.0 - beta - gamma, beta, gamma];
    let gap = Gap { distance: -behind, normal: -outward };
    weights.iter().all(|w| *w >= -EDGE_MARGIN).then_some(TipPenetration {
        point,
        weights,
        gap,
        end: *pole,
        inner: *inner,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Vector3 = Vector3::new(0.0, 0.0, 2.0);

    fn close(found: &TipPenetration, expected: Vector3, weights: [f64; 3]) {
        assert!((found.point - expected).norm() < 1e-15, "{found:?}");
        assert!(found.weights.iter().zip(weights).all(|(w, v)| (w - v).abs() < 1e-15), "{found:?}");
        assert_eq!(found.gap, Gap { distance: -0.5, normal: -Vector3::z() });
    }

    #[test]
    fn a_triangle_is_pierced_from_behind_within_its_corners_and_just_beyond() {
        let corners = [Vector3::zeros(), Vector3::x() * 4.0, Vector3::y() * 4.0];
        let at =
            |x: f64, y: f64| intersect_facet::<3>(&corners, &Vector3::new(x, y, -0.5), &(UP + Vector3::new(x, y, 0.0)));
        close(&at(1.0, 2.0).unwrap(), Vector3::new(1.0, 2.0, 0.0), [0.25, 0.25, 0.5]);
        assert_eq!((at(-0.3, 1.0), at(1.0, -0.3), at(2.3, 2.0)), (None, None, None));
        close(&at(-0.1, 1.0).unwrap(), Vector3::new(-0.1, 1.0, 0.0), [0.775, -0.025, 0.25]);
        assert_eq!(intersect_facet::<3>(&corners, &UP, &-UP), None, "from the front");
        assert_eq!(intersect_facet::<3>(&corners, &(0.5 * UP), &UP), None, "not yet there");
    }

    #[test]
    fn an_edge_of_a_plane_gel_is_pierced_between_its_ends() {
        // The gel is below: with the gel on its left, the edge goes towards −x.
        let corners = [Vector3::x() * 2.0, -Vector3::x() * 2.0, -Vector3::x() * 2.0];
        let at = |x: f64| intersect_facet::<2>(&corners, &Vector3::new(x, 0.0, -0.5), &(UP + Vector3::x() * x));
        close(&at(1.0).unwrap(), Vector3::x(), [0.75, 0.25, 0.0]);
        assert_eq!((at(2.3), at(-2.3)), (None, None));
        close(&at(2.1).unwrap(), Vector3::x() * 2.1, [1.025, -0.025, 0.0]);
    }
}
