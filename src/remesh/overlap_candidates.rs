//! Which old elements can lie under a new one: those of its own part of the body, where that passes through itself.

use super::Moved;
use super::Proposal;
use super::barycentric::Cell;
use super::bounds::Bounds;
use super::correspondence::Pairing;
use super::point_location::{Locator, Place};
use super::supermesh::cells;
use crate::math::Vector;
use crate::mesh::ElementId;

/// The old elements that are gone, as places for new ones.
pub(super) struct Under<'a, const D: usize> {
    cells: &'a [Cell<D>],
    /// The boxes around them.
    bounds: Vec<Bounds<D>>,
    locator: Locator<'a, D>,
    /// By new element, those that it can lie over; all where none are named.
    over: &'a [Vec<ElementId>],
    /// By old element, which of the gone ones it is.
    rank: Vec<Option<u32>>,
}

/// The cells of the old elements that are gone.
pub(super) fn gone<const D: usize>(old: &Moved<'_, D>, pairing: &Pairing) -> Vec<Cell<D>> {
    cells(old.position, pairing.gone.iter().map(|e| &old.mesh.elements[e.index()]))
}

impl<'a, const D: usize> Under<'a, D> {
    /// Of a new mesh, and of the cells of what is gone.
    pub fn new(old: &Moved<'_, D>, new: &'a Proposal<D>, (pairing, cells): (&Pairing, &'a [Cell<D>])) -> Self {
        let mut rank = vec![];
        if !new.over.is_empty() {
            rank = vec![None; old.mesh.elements.len()];
            pairing.gone.iter().zip(0..).for_each(|(e, t)| rank[e.index()] = Some(t));
        }
        let bounds = cells.iter().map(Cell::bounds).collect();
        Self { cells, bounds, locator: Locator::new(cells), over: &new.over, rank }
    }

    /// Visits what can lie under a new element with these bounds.
    pub fn near(&self, element: usize, wanted: &Bounds<D>, mut visit: impl FnMut(usize)) {
        match self.own(element) {
            Some(own) => own.filter(|t| self.bounds[*t].meets(wanted)).for_each(visit),
            None => self.locator.near(wanted, &mut visit),
        }
    }

    /// The nearest place to a point that is a node of this new element.
    pub fn nearest(&self, element: usize, p: &Vector<D>) -> Option<Place> {
        let Some(own) = self.own(element) else { return self.locator.nearest(p) };
        let mut nearest: Option<Place> = None;
        for place in own.map(|t| self.cells[t].nearest(p, t)) {
            nearest =
                Some(nearest.filter(|nearest| nearest.distance.total_cmp(&place.distance).is_le()).unwrap_or(place));
            // Nothing is nearer.
            if place.distance == 0.0 {
                break;
            }
        }
        nearest.or_else(|| self.locator.nearest(p))
    }

    fn own(&self, element: usize) -> Option<impl Iterator<Item = usize> + '_> {
        let own = self.over.get(element).filter(|own| !own.is_empty())?;
        Some(own.iter().filter_map(|e| self.rank[e.index()]).map(|t| t as usize))
    }
}
