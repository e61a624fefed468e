//! Rings of four tetrahedra around a common edge.
//!
//! In the centred lattice every tetrahedron is in the rings of two opposite edges, one between the middles of cells and one
//! of the cells' own, and either set of rings fills space. At the boundary only one of the two is closed. So where a
//! tetrahedron has one ring left, that one is taken, and what this settles for its neighbours next: the choice of the
//! boundary spreads inwards and the rings of the two sets do not mix.

use super::element_graph::Dual;
use crate::mesh::{ElementId, Simplex};
use std::cmp::Reverse;
use std::collections::VecDeque;

/// Four elements around an edge, each a neighbour of the next.
pub(super) type Ring = [ElementId; 4];

/// Disjoint rings: first those of elements that have no other, then the most compact one, and so on.
pub(super) fn rings<const D: usize>(
    elements: &[Simplex],
    across: &[[Option<ElementId>; 4]],
    dual: &Dual<D>,
) -> Vec<Ring> {
    let rings = closed(elements, across);
    let mut choice = Choice::new(&rings, elements.len());
    let mut order: Vec<(Reverse<u32>, u32)> =
        rings.iter().zip(0..).map(|(ring, id)| (Reverse(dual.compactness(ring)), id)).collect();
    order.sort_unstable();
    for (_, id) in order {
        choice.follow();
        choice.take(id);
    }
    choice.taken
}

/// Every closed ring of four, in the order of its first element.
fn closed(elements: &[Simplex], across: &[[Option<ElementId>; 4]]) -> Vec<Ring> {
    const EDGES: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let walk = Walk { elements, across };
    let of = |e| EDGES.into_iter().filter_map(move |opposite| walk.around(e, opposite));
    (0..elements.len() as u32).map(ElementId).flat_map(of).filter(|ring| ring.iter().all(|&e| e >= ring[0])).collect()
}

/// From element to element around an edge.
#[derive(Clone, Copy)]
struct Walk<'a> {
    elements: &'a [Simplex],
    across: &'a [[Option<ElementId>; 4]],
}

impl Walk<'_> {
    /// The ring around the edge of an element that is opposite its corners `k` and `l`, if four elements close it.
    fn around(self, first: ElementId, (k, l): (usize, usize)) -> Option<Ring> {
        let mut ring = [first; 4];
        let (mut leave, mut keep) = (k, self.elements[first.index()][l]);
        for i in 0..4 {
            let next = self.across[ring[i].index()][leave]?;
            if i == 3 {
                return (next == first).then_some(ring);
            }
            let old = self.elements[ring[i].index()];
            ring[i + 1] = next;
            let corners = self.elements[next.index()];
            leave = corners.iter().position(|&node| node == keep)?;
            keep = *corners.iter().find(|node| !old.contains(node))?;
        }
        None
    }
}

/// Which rings are taken, and what that leaves to their elements.
struct Choice<'a> {
    rings: &'a [Ring],
    /// The rings of each element, one for each of its edges at most; then [`NO_RING`].
    of: Vec<[u32; 6]>,
    /// Whether a ring can still be taken.
    open: Vec<bool>,
    /// Number of open rings of each element.
    left: Vec<u8>,
    /// Elements that had one ring left, first come first served.
    forced: VecDeque<ElementId>,
    taken: Vec<Ring>,
}

/// Stands where an edge has no ring.
const NO_RING: u32 = u32::MAX;

impl<'a> Choice<'a> {
    fn new(rings: &'a [Ring], n_elements: usize) -> Self {
        let (mut of, mut left) = (vec![[NO_RING; 6]; n_elements], vec![0; n_elements]);
        for (ring, id) in rings.iter().zip(0..) {
            for e in ring.map(ElementId::index) {
                of[e][usize::from(left[e])] = id;
                left[e] += 1;
            }
        }
        let forced = (0..).map(ElementId).zip(&left).filter(|(_, left)| **left == 1).map(|(e, _)| e).collect();
        Self { rings, of, open: vec![true; rings.len()], left, forced, taken: vec![] }
    }

    /// The open rings of an element.
    fn open_rings(&self, element: ElementId) -> impl Iterator<Item = u32> + use<'_> {
        let all = self.of[element.index()].into_iter().take_while(|&id| id != NO_RING);
        all.filter(|&id| self.open[id as usize])
    }

    /// Takes the rings that are the last of an element, until no element has but one.
    fn follow(&mut self) {
        while let Some(element) = self.forced.pop_front() {
            let last = self.open_rings(element).next();
            if let Some(id) = last {
                self.take(id);
            }
        }
    }

    /// Takes a ring if it is open, and closes those that share an element with it.
    fn take(&mut self, id: u32) {
        if !self.open[id as usize] {
            return;
        }
        let ring = self.rings[id as usize];
        self.taken.push(ring);
        for element in ring {
            let open: Vec<u32> = self.open_rings(element).collect();
            for other in open {
                self.close(other);
            }
        }
    }

    fn close(&mut self, id: u32) {
        self.open[id as usize] = false;
        for element in self.rings[id as usize] {
            self.left[element.index()] -= 1;
            if self.left[element.index()] == 1 {
                self.forced.push_back(element);
            }
        }
    }
}
