//! Stretch limit: how far the gel surface is stretched over a body, and when the stretch ends a mesh or a run (A11).

use super::StepError;
use super::surface_at_tick::SurfaceAtTick;
use crate::contact::{BodyState, FacetCandidate, RigidBody};
use crate::fem::Potential;
use crate::geometry::SignedDistance as _;
use crate::math::Vector3;
use crate::state::SurfaceStretch;

/// Leak depth: a stopped facet leaks if it is deeper in the body, at its deepest point or where a pole of the body
/// pierces it. It is measured in the smaller of element size and inner radius of the body (A11). A facet stopped at
/// one point still turns about it: the sharp corner of a cube comes 0.6 deep and is held, so half a size would be too
/// little.
const LEAK_DEPTH: f64 = 1.0;
/// Facet depth at which a mesh that can be remeshed counts as distorted, in the same measure: the surface has been
/// stretched over the body.
const DISTORTED_DEPTH: f64 = 0.5;

/// Stretch of the surface over the bodies, and the first leak.
pub(super) struct SurfaceStretches {
    /// Greatest stretch of the facets.
    pub stretch: SurfaceStretch,
    /// First leak.
    pub leak: Option<StepError>,
}

/// Check of the stretch: reads the surface and the facets near bodies.
pub(super) struct StretchCheck<'a, const D: usize, P> {
    pub surface: SurfaceAtTick<'a, D, P>,
    /// Facets that reach to a body, as found at this tick.
    pub facets: &'a [FacetCandidate],
    pub can_be_distorted: bool,
    /// Greatest edge of a facet that touches a body, m.
    pub greatest_edge: f64,
}

impl<const D: usize, P: Potential<D>> StretchCheck<'_, D, P> {
    /// Finds the greatest stretch of the facets, relative to the least size of their nodes, and the first leak.
    pub fn find_stretch(&self) -> SurfaceStretches {
        let (mut stretch, mut leak) = (SurfaceStretch::Little, None);
        for candidate in self.facets {
            match self.check_facet(candidate) {
                Ok(here) => stretch = stretch.max(here),
                Err(error) => (stretch, leak) = (SurfaceStretch::Leaking, leak.or(Some(error))),
            }
        }
        SurfaceStretches { stretch, leak }
    }

    /// Returns the stretch of a facet over a body, or the leak.
    fn check_facet(&self, candidate: &FacetCandidate) -> Result<SurfaceStretch, StepError> {
        let FacetCandidate { body, facet, least_size: size, ref corners, .. } = *candidate;
        let (rigid, at) = self.surface.bodies().get(body);
        let unit = size.min(rigid.shape.inner_radius());
        let threshold = if self.can_be_distorted { DISTORTED_DEPTH } else { LEAK_DEPTH };
        let deep = candidate.deepest_point::<D>(threshold * unit, rigid, at).map(|deep| deep.point);
        let pierced = candidate.penetration.map(|tip| tip.point);
        for point in deep.into_iter().chain(pierced) {
            let depth = -rigid.gap(at, &point).distance;
            if depth > LEAK_DEPTH * unit {
                let element = self.surface.model.gel.behind[facet.index()].index();
                return Err(StepError::Leak { body, element, time: self.surface.time(), depth, at: point.into() });
            }
        }
        let is_distorted = deep.is_some() || self.is_long(corners, rigid, at);
        Ok(if is_distorted && self.can_be_distorted { SurfaceStretch::Distorted } else { SurfaceStretch::Little })
    }

    /// Returns true if an edge of a facet touches a body and is longer than the mesh allows.
    fn is_long(&self, corners: &[Vector3; 3], rigid: &RigidBody, at: &BodyState) -> bool {
        let sides = (0..D).map(|i| (corners[i], corners[(i + 1) % D]));
        let mut long = sides.filter(|(a, b)| (a - b).norm() > self.greatest_edge);
        long.any(|(a, b)| rigid.gap(at, &((a + b) * 0.5)).distance < 0.0)
    }
}
