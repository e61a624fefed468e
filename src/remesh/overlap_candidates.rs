//! Overlap candidates: the removed old elements that a new element may overlap.

use super::DeformedMesh;
use super::ProposedMesh;
use super::barycentric::{DeformedElement, ElementLocation, cells};
use super::correspondence::MeshCorrespondence;
use super::point_location::ElementLocator;
use crate::geometry::BoundingBox;
use crate::math::{CLOSE, Vector};
use crate::mesh::ElementId;
use std::sync::{Arc, OnceLock};

/// Removed old elements with their bounding boxes.
pub(super) struct OverlapCandidates<'a, const D: usize> {
    cells: &'a [DeformedElement<D>],
    /// Bounding boxes of the removed elements.
    bounds: Vec<BoundingBox<D>>,
    /// Search tree over the removed elements, built when it is first asked for.
    locator: OnceLock<ElementLocator<'a, D>>,
    /// Old elements that each new element may overlap; an empty entry admits all.
    over: &'a [Arc<[ElementId]>],
    /// Index of each old element among the removed ones.
    rank: Vec<Option<u32>>,
}

/// Collects the removed old elements in their deformed configuration.
pub(super) fn gone<const D: usize>(old: &DeformedMesh<'_, D>, pairing: &MeshCorrespondence) -> Vec<DeformedElement<D>> {
    cells(old.position, pairing.gone.iter().map(|e| &old.mesh.elements[e.index()]))
}

impl<'a, const D: usize> OverlapCandidates<'a, D> {
    /// Builds the candidates of a new mesh from the removed elements.
    pub fn new(
        old: &DeformedMesh<'_, D>,
        new: &'a ProposedMesh<D>,
        (pairing, cells): (&MeshCorrespondence, &'a [DeformedElement<D>]),
    ) -> Self {
        let mut rank = vec![];
        if !new.over.is_empty() {
            rank = vec![None; old.mesh.elements.len()];
            pairing.gone.iter().zip(0..).for_each(|(e, t)| rank[e.index()] = Some(t));
        }
        let bounds = cells.iter().map(DeformedElement::bounds).collect();
        Self { cells, bounds, locator: OnceLock::new(), over: &new.over, rank }
    }

    /// Visits the candidates of a new element that overlap its box.
    pub fn near(&self, element: usize, wanted: &BoundingBox<D>, mut visit: impl FnMut(usize)) {
        match self.own(element) {
            Some(own) => own.filter(|t| self.bounds[*t].meets(wanted)).for_each(visit),
            None => self.locator().near(wanted, &mut visit),
        }
    }

    /// Nearest location to a node of a new element among its candidates.
    pub fn nearest(&self, element: usize, p: &Vector<D>) -> Option<ElementLocation> {
        let Some(own) = self.own(element) else { return self.locator().nearest(p) };
        let own: Vec<usize> = own.collect();
        let inside = own.iter().enumerate().find_map(|(k, t)| Some((k, self.cells[*t].place(p, *t)?)));
        if let Some((k, inside)) = inside {
            // On a common face rounding decides whether a candidate before it has the point, too.
            let close = own[..k].iter().filter(|t| self.cells[**t].weights(p).iter().all(|weight| *weight > -CLOSE));
            let touching = close.map(|t| self.cells[*t].nearest(p, *t)).find(|place| place.distance == 0.0);
            return touching.or(Some(inside));
        }
        let all = own.iter().map(|t| self.cells[*t].nearest(p, *t));
        let nearest = all.min_by(|a, b| a.distance.total_cmp(&b.distance));
        nearest.or_else(|| self.locator().nearest(p))
    }

    fn locator(&self) -> &ElementLocator<'a, D> {
        self.locator.get_or_init(|| ElementLocator::new(self.cells))
    }

    fn own(&self, element: usize) -> Option<impl Iterator<Item = usize> + '_> {
        let own = self.over.get(element).filter(|own| !own.is_empty())?;
        Some(own.iter().filter_map(|e| self.rank[e.index()]).map(|t| t as usize))
    }
}
