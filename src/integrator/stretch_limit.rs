//! How far the surface of the gel is stretched over a body, and when that ends a mesh or a run (A11).

use super::StepError;
use super::engine::Engine;
use super::facet::deepest;
use crate::fem::Potential;
use crate::geometry::SignedDistance as _;
use crate::mesh::ElementId;
use crate::state::Stretch;

/// A leak is a facet that is somewhere, or where the body's axis pierces it, deeper in the body than this although facets are stopped,
/// in element sizes or radii of the body (A11). A facet that is stopped at one point still turns about it: the sharp corner of a cube comes 0.6
/// deep and is held, so half a size would be too little.
const LEAK: f64 = 1.0;
/// A mesh that can be exchanged is worn once a facet is so deep, in the same measure: it has been stretched over the body then.
const STRETCHED: f64 = 0.5;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Keeps for the next tick how far the surface is stretched: a leak ends the mesh there, or where none is exchanged the run at once.
    pub(super) fn check_leaks(&mut self, time: f64) -> Result<(), StepError> {
        let (stretch, leak) = self.find_leak(time);
        self.state.record.stretch = stretch;
        leak.filter(|_| !self.can_wear()).map_or(Ok(()), Err)
    }

    /// How far the facets that reach from a node to a body are stretched, in the least size of their nodes, and the first that leaks.
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
