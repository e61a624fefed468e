//! Facet candidate: a facet that reaches to a body at a tick, with what the contact and the stretch limit ask of both.

use super::facet::{DeepestPoint, centroid, find_deepest_point};
use super::tip::{PoleLine, TipPenetration, find_penetration};
use super::{BodyState, RigidBody};
use crate::geometry::Gap;
use crate::math::Vector3;
use crate::mesh::ElementId;

/// Facet that reaches to a body at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FacetCandidate {
    pub body: usize,
    pub facet: ElementId,
    /// Least and greatest size of its nodes near the body, m.
    pub least_size: f64,
    pub greatest_size: f64,
    /// Positions of its corners before the impulses of the tick, m.
    pub corners: [Vector3; 3],
    /// φ and n at its centroid.
    middle: Gap,
    /// Penetration by a pole of the body.
    pub penetration: Option<TipPenetration>,
}

/// Facet at nodes near a body, with the distance of the body from the nearest of them and their sizes, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearFacet {
    pub facet: ElementId,
    pub distance: f64,
    pub least_size: f64,
    pub greatest_size: f64,
}

/// Body of a search for candidates: its index, properties, state, and the lines inwards from its poles.
pub(super) struct BodyOfSearch<'a> {
    pub index: usize,
    pub rigid: &'a RigidBody,
    pub at: &'a BodyState,
    pub poles: Vec<PoleLine>,
}

impl FacetCandidate {
    /// Creates the candidate of a facet with its corners at these positions, m; `None` if the body is at least as far
    /// from its nodes as the facet is long.
    pub(super) fn new<const D: usize>(
        near: &NearFacet,
        corners: [Vector3; 3],
        body: &BodyOfSearch<'_>,
    ) -> Option<Self> {
        let NearFacet { facet, distance, least_size, greatest_size } = *near;
        let is_longer = |i: usize| (corners[(i + 1) % D] - corners[i]).norm() > distance;
        (distance < 0.0 || (0..D).any(is_longer)).then(|| Self {
            body: body.index,
            facet,
            least_size,
            greatest_size,
            corners,
            middle: body.rigid.gap(body.at, &centroid::<D>(&corners)),
            penetration: find_penetration::<D>(&corners, &body.poles),
        })
    }

    /// Returns the deepest point of the facet in the body in the state of the tick, if it is deeper than `allowed`, m.
    pub fn deepest_point<const D: usize>(
        &self,
        allowed: f64,
        rigid: &RigidBody,
        at: &BodyState,
    ) -> Option<DeepestPoint> {
        find_deepest_point::<D>(&self.corners, &self.middle, allowed, |point| rigid.gap(at, point))
    }
}
