//! Selection of disjoint rings of four tetrahedra around a common edge.
//!
//! In the centred lattice every tetrahedron is in the rings of two opposite edges: one joins cell centres, the other is
//! a cell edge. Either family of rings fills space, but at the boundary only one of them is closed. Where a tetrahedron
//! has one ring left, that ring is taken, with its consequences for the neighbours. The choice at the boundary
//! propagates inwards, and the two families do not mix.

use super::element_graph::ElementGraph;
use crate::mesh::{ElementId, Simplex};
use std::cmp::Reverse;
use std::collections::VecDeque;

/// Four elements around an edge, each a face neighbour of the next.
pub(super) type EdgeRing = [ElementId; 4];

/// Selects disjoint rings: first those of elements with one candidate left, then the most compact remaining ring, and
/// so on.
pub(super) fn rings<const D: usize>(
    elements: &[Simplex],
    across: &[[Option<ElementId>; 4]],
    graph: &ElementGraph<D>,
) -> Vec<EdgeRing> {
    let rings = closed_rings(elements, across);
    let mut selection = RingSelection::new(&rings, elements.len());
    let mut order: Vec<(Reverse<u32>, u32)> =
        rings.iter().zip(0..).map(|(ring, id)| (Reverse(graph.compactness(ring)), id)).collect();
    order.sort_unstable();
    for (_, id) in order {
        selection.take_forced();
        selection.take(id);
    }
    selection.taken
}

/// Every closed ring of four elements, in the order of its first element.
fn closed_rings(elements: &[Simplex], across: &[[Option<ElementId>; 4]]) -> Vec<EdgeRing> {
    const EDGES: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let walk = EdgeWalk { elements, across };
    let of = |e| EDGES.into_iter().filter_map(move |(k, l)| walk.ring_around(e, k, l));
    (0..elements.len() as u32).map(ElementId).flat_map(of).filter(|ring| ring.iter().all(|&e| e >= ring[0])).collect()
}

/// Traversal of the elements around an edge through their faces.
#[derive(Clone, Copy)]
struct EdgeWalk<'a> {
    elements: &'a [Simplex],
    across: &'a [[Option<ElementId>; 4]],
}

impl EdgeWalk<'_> {
    /// Ring around the edge opposite the corners `k` and `l` of an element, if four elements close it.
    fn ring_around(self, first: ElementId, k: usize, l: usize) -> Option<EdgeRing> {
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

/// State of the selection: rings taken so far, and candidates left to each element.
struct RingSelection<'a> {
    rings: &'a [EdgeRing],
    /// Candidate rings of each element, at most one per edge, padded with [`NO_RING`].
    of: Vec<[u32; 6]>,
    /// True for a ring that can still be taken.
    open: Vec<bool>,
    /// Number of open rings of each element.
    left: Vec<u8>,
    /// Queue of elements with one open ring left.
    forced: VecDeque<ElementId>,
    taken: Vec<EdgeRing>,
}

/// Padding of an element's list of rings.
const NO_RING: u32 = u32::MAX;

impl<'a> RingSelection<'a> {
    fn new(rings: &'a [EdgeRing], n_elements: usize) -> Self {
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

    /// Open rings of an element.
    fn open_rings(&self, element: ElementId) -> impl Iterator<Item = u32> + use<'_> {
        let all = self.of[element.index()].into_iter().take_while(|&id| id != NO_RING);
        all.filter(|&id| self.open[id as usize])
    }

    /// Takes the last open ring of every queued element until the queue is empty.
    fn take_forced(&mut self) {
        while let Some(element) = self.forced.pop_front() {
            let last = self.open_rings(element).next();
            if let Some(id) = last {
                self.take(id);
            }
        }
    }

    /// Takes a ring if it is open, and closes all rings that share an element with it.
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

    /// Closes a ring; elements left with one open ring join the queue.
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
