//! Stretch limit: how far the gel surface is stretched over a body, and when the stretch ends a mesh or a run (A11).

use super::StepError;
use super::engine::Engine;
use super::facet::deepest;
use crate::fem::Potential;
use crate::geometry::SignedDistance as _;
use crate::mesh::ElementId;
use crate::state::Stretch;

/// Leak depth: a stopped facet deeper in the body than this, at its deepest point or where a pole of the body pierces
/// it, leaks; in the smaller of element size and inner radius of the body (A11). A facet stopped at one point still
/// turns about it: the sharp corner of a cube comes 0.6 deep and is held, so half a size would be too little.
const LEAK: f64 = 1.0;
/// Facet depth at which a mesh that can be remeshed counts as distorted, in the same measure: the surface has been
/// stretched over the body.
const STRETCHED: f64 = 0.5;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Records the stretch of the surface for the next tick; a leak ends the mesh there, or the run at once if there
    /// is no remeshing.
    pub(super) fn check_leaks(&mut self, time: f64) -> Result<(), StepError> {
        let (stretch, leak) = self.find_leak(time);
        self.state.record.stretch = stretch;
        leak.filter(|_| !self.can_wear()).map_or(Ok(()), Err)
    }

    /// Finds the greatest stretch of the facets between a node and a body, relative to the least size of their nodes,
    /// and the first leak.
    pub(super) fn find_leak(&self, time: f64) -> (Stretch, Option<StepError>) {
        let (mut stretch, mut leak) = (Stretch::Little, None);
        for (body, facet, (size, _)) in &self.scratch.facets {
            match self.check_facet(*facet, *size, (*body as usize, time)) {
                Ok(here) => stretch = stretch.max(here),
                Err(error) => (stretch, leak) = (Stretch::Leaking, leak.or(Some(error))),
            }
        }
        (stretch, leak)
    }

    fn check_facet(&self, facet: ElementId, size: f64, (body, time): (usize, f64)) -> Result<Stretch, StepError> {
        let (fixed, at) = self.placed(body);
        let unit = size.min(fixed.shape.inner_radius());
        let looked_for = if self.can_wear() { STRETCHED } else { LEAK };
        let deep = deepest::<D>(&self.corners(facet), looked_for * unit, |p| fixed.gap(at, p)).map(|deep| deep.point);
        let pierced = self.piercing(facet, (fixed, at)).map(|piercing| piercing.point);
        for point in deep.into_iter().chain(pierced) {
            let depth = -fixed.gap(at, &point).distance;
            if depth > LEAK * unit {
                let element = self.gel.behind[facet.index()].index();
                return Err(StepError::Leak { body, element, time, depth, at: point.into() });
            }
        }
        Ok(if deep.is_some() && self.can_wear() { Stretch::Worn } else { Stretch::Little })
    }
}
