//! Facets that an end or tip of a body pierces (numerics 2.6): what is sharper than the mesh meets no node.

use super::contact_solver::SLOP;
use super::engine::Engine;
use super::facet::outward;
use crate::contact::{Body, BodyState};
use crate::fem::Potential;
use crate::geometry::{Gap, SignedDistance as _};
use crate::math::{Vector3, embed};
use crate::mesh::ElementId;

/// A facet counts as pierced up to so much beyond its edges, in its own weights. A tip in the crease between two facets is
/// otherwise held by one of them at a time, and slides down each in turn: a cone of 10 mm sank 0.7 cells of 3.3 mm deep and
/// leaked. From 0.01 to 0.2 it does not, with the same depth of the body to 0.1 %; at 0.5 facets carry that are far off.
const BEYOND: f64 = 0.05;

/// How deep behind a facet an end of the body is met that half of an element's size fits into, but not a whole one: in
/// element sizes or radii of the body, whichever is less. Met as late as 0.3, a meplat of a third of a cell leaks at 20 m/s.
const BLUNT: f64 = 0.2;

/// A facet through which the line from an end of the body inwards leaves the gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piercing {
    /// Where, m.
    pub point: Vector3,
    /// Parts of the corners of the facet there.
    pub weights: [f64; 3],
    /// Distance of the end of the body from the plane of the facet, negative behind it, and the normal into the gel.
    pub gap: Gap,
    /// The end of the body, m.
    pub end: Vector3,
    /// The point inside of the body that the line goes to, m.
    inner: Vector3,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Where the line from an end or tip of the body inwards leaves the gel through this facet; that of the deepest if of
    /// several.
    pub(super) fn piercing(&self, facet: ElementId, (fixed, body): (&Body, &BodyState)) -> Option<Piercing> {
        let corners = self.gel.surface.facets[facet.index()].map(|node| embed(&self.position_at(node, body.time)));
        let poles = fixed.shape.poles().iter();
        let place = |p: &Vector3| body.position + body.orientation.transform_vector(p);
        let piercings = poles.filter_map(|pole| pierce::<D>(&corners, &place(&pole.end), &place(&pole.inner)));
        piercings.min_by(|a, b| a.gap.distance.total_cmp(&b.gap.distance))
    }

    /// The same where that end is behind the facet by more than its bluntness allows.
    pub(super) fn pricking(&self, facet: ElementId, size: f64, body: (&Body, &BodyState)) -> Option<Piercing> {
        self.piercing(facet, body).filter(|at| -at.gap.distance > least_depth((&at.end, &at.inner), size, body))
    }
}

/// How deep behind a facet an end of a body is met there, m. A point for the mesh, into which a ball of half an element's
/// size does not fit, at once; one into which a whole size does not fit can still miss the nodes,
/// and is met at [`BLUNT`]; a blunter end is met by nodes.
fn least_depth((end, inner): (&Vector3, &Vector3), size: f64, (fixed, body): (&Body, &BodyState)) -> f64 {
    const ROUND_OFF: f64 = 1e-3;
    let fits = |radius: f64| {
        let inside = end + (inner - end).normalize() * radius;
        -fixed.gap(body, &inside).distance >= radius * (1.0 - ROUND_OFF)
    };
    match (fits(0.5 * size), fits(size)) {
        (false, _) => SLOP * size,
        (true, false) => BLUNT * size.min(fixed.shape.inner_radius()),
        (true, true) => f64::INFINITY,
    }
}

/// Where the line from `pole` to `inner` goes from the back of a facet to its front, if it does, or just beside it.
fn pierce<const D: usize>(corners: &[Vector3; 3], pole: &Vector3, inner: &Vector3) -> Option<Piercing> {
    let (a, b) = (corners[0], corners[1] - corners[0]);
    let across = outward::<D>(corners);
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
    weights.iter().all(|w| *w >= -BEYOND).then_some(Piercing { point, weights, gap, end: *pole, inner: *inner })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: Vector3 = Vector3::new(0.0, 0.0, 2.0);

    fn close(found: &Piercing, expected: Vector3, weights: [f64; 3]) {
        assert!((found.point - expected).norm() < 1e-15, "{found:?}");
        assert!(found.weights.iter().zip(weights).all(|(w, v)| (w - v).abs() < 1e-15), "{found:?}");
        assert_eq!(found.gap, Gap { distance: -0.5, normal: -Vector3::z() });
    }

    #[test]
    fn a_triangle_is_pierced_from_behind_within_its_corners_and_just_beyond() {
        let corners = [Vector3::zeros(), Vector3::x() * 4.0, Vector3::y() * 4.0];
        let at = |x: f64, y: f64| pierce::<3>(&corners, &Vector3::new(x, y, -0.5), &(UP + Vector3::new(x, y, 0.0)));
        close(&at(1.0, 2.0).unwrap(), Vector3::new(1.0, 2.0, 0.0), [0.25, 0.25, 0.5]);
        assert_eq!((at(-0.3, 1.0), at(1.0, -0.3), at(2.3, 2.0)), (None, None, None));
        close(&at(-0.1, 1.0).unwrap(), Vector3::new(-0.1, 1.0, 0.0), [0.775, -0.025, 0.25]);
        assert_eq!(pierce::<3>(&corners, &UP, &-UP), None, "from the front");
        assert_eq!(pierce::<3>(&corners, &(0.5 * UP), &UP), None, "not yet there");
    }

    #[test]
    fn an_edge_of_a_plane_gel_is_pierced_between_its_ends() {
        // The gel is below: run through with the gel on its left, the edge goes towards −x.
        let corners = [Vector3::x() * 2.0, -Vector3::x() * 2.0, -Vector3::x() * 2.0];
        let at = |x: f64| pierce::<2>(&corners, &Vector3::new(x, 0.0, -0.5), &(UP + Vector3::x() * x));
        close(&at(1.0).unwrap(), Vector3::x(), [0.75, 0.25, 0.0]);
        assert_eq!((at(2.3), at(-2.3)), (None, None));
        close(&at(2.1).unwrap(), Vector3::x() * 2.1, [1.025, -0.025, 0.0]);
    }
}
