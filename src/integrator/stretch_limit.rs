//! Stretch limit: how far the gel surface is stretched over a body, and when the stretch ends a mesh or a run (A11).

use super::StepError;
use super::engine::Engine;
use super::facet::find_deepest_point;
use crate::fem::Potential;
use crate::geometry::SignedDistance as _;
use crate::mesh::ElementId;
use crate::state::SurfaceStretch;

/// Leak depth: a stopped facet leaks if it is deeper in the body, at its deepest point or where a pole of the body
/// pierces it. It is measured in the smaller of element size and inner radius of the body (A11). A facet stopped at
/// one point still turns about it: the sharp corner of a cube comes 0.6 deep and is held, so half a size would be too
/// little.
const LEAK_DEPTH: f64 = 1.0;
/// Facet depth at which a mesh that can be remeshed counts as distorted, in the same measure: the surface has been
/// stretched over the body.
const DISTORTED_DEPTH: f64 = 0.5;

/// Result of a check of the facets near bodies.
pub(super) struct StretchCheck {
    /// Greatest stretch of the facets.
    stretch: SurfaceStretch,
    /// First leak.
    pub leak: Option<StepError>,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Records the stretch of the surface for the next tick; a leak ends the mesh there, or the run at once if there
    /// is no remeshing.
    pub(super) fn check_stretch(&mut self, time: f64) -> Result<(), StepError> {
        let StretchCheck { stretch, leak } = self.find_stretch(time);
        self.state.record.stretch = stretch;
        leak.filter(|_| !self.can_be_distorted()).map_or(Ok(()), Err)
    }

    /// Finds the greatest stretch of the facets between a node and a body, relative to the least size of their nodes,
    /// and the first leak.
    pub(super) fn find_stretch(&self, time: f64) -> StretchCheck {
        let (mut stretch, mut leak) = (SurfaceStretch::Little, None);
        for (body, facet, (size, _)) in &self.scratch.facets {
            match self.check_facet(*facet, *size, *body as usize, time) {
                Ok(here) => stretch = stretch.max(here),
                Err(error) => (stretch, leak) = (SurfaceStretch::Leaking, leak.or(Some(error))),
            }
        }
        StretchCheck { stretch, leak }
    }

    /// Returns the stretch of a facet over a body, or the leak.
    fn check_facet(&self, facet: ElementId, size: f64, body: usize, time: f64) -> Result<SurfaceStretch, StepError> {
        let (rigid, at) = self.body_at_tick(body);
        let unit = size.min(rigid.shape.inner_radius());
        let threshold = if self.can_be_distorted() { DISTORTED_DEPTH } else { LEAK_DEPTH };
        let deep = find_deepest_point::<D>(&self.facet_corners(facet), threshold * unit, |p| rigid.gap(at, p))
            .map(|deep| deep.point);
        let pierced = self.find_penetration(facet, rigid, at).map(|tip| tip.point);
        for point in deep.into_iter().chain(pierced) {
            let depth = -rigid.gap(at, &point).distance;
            if depth > LEAK_DEPTH * unit {
                let element = self.gel.behind[facet.index()].index();
                return Err(StepError::Leak { body, element, time, depth, at: point.into() });
            }
        }
        Ok(if deep.is_some() && self.can_be_distorted() { SurfaceStretch::Worn } else { SurfaceStretch::Little })
    }
}
