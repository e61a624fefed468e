//! Set of the nodes that are active at a tick, and the sizes in which nodes are processed.

#![allow(clippy::inline_always, reason = "only inlined code is compiled for the SIMD level of its caller")]

use crate::contact::TRAVEL_BATCH;
use crate::fem::LANES;
use crate::math::SUM_BLOCK;
use std::ops::Range;

/// Nodes of a batch; each stage (sums, limits, kicks) runs over the whole batch. Not tuned: any number works that
/// fills SIMD vectors and stays in the nearest cache.
pub(super) const NODE_BATCH: usize = TRAVEL_BATCH;

const _: () = assert!(NODE_BATCH.is_multiple_of(LANES), "they fill vectors");

/// Nodes of a tile, a part of a chunk; the sums of a tile stay in the nearest cache.
pub(super) const TILE_NODES: usize = 256;

const _: () = assert!(RUN / TILE_NODES * TILE_NODES == RUN, "runs are made of whole tiles");

/// Nodes of a chunk, the unit of summation, so that sums do not depend on the threads (method A9).
pub(super) const RUN: usize = SUM_BLOCK;

/// Number of active nodes from which on the loop runs over all nodes, in chunks that threads share, and not over a
/// list.
const LIST_CAPACITY: usize = 1024;

/// Set of the nodes that are active at a tick.
#[derive(Debug, Default)]
pub(super) struct ActiveSet {
    /// Active nodes in the order of insertion, unless all are active. In the SIMD form it stays incomplete from
    /// [`LIST_CAPACITY`] nodes on.
    list: Vec<u32>,
    /// True if all nodes are active.
    pub all: bool,
    /// Membership of each node, unless all are active.
    marked: Vec<bool>,
}

impl ActiveSet {
    /// Returns the empty set for a number of nodes.
    pub fn new(n_nodes: usize) -> Self {
        Self { list: vec![], all: false, marked: vec![false; n_nodes] }
    }

    /// Removes all nodes.
    pub fn clear(&mut self) {
        // A shorter list is complete.
        if self.list.len() < LIST_CAPACITY {
            self.list.iter().for_each(|node| self.marked[*node as usize] = false);
        } else {
            self.marked.fill(false);
        }
        self.list.clear();
        self.all = false;
    }

    /// Inserts a node.
    pub fn insert(&mut self, node: usize) {
        if !self.marked[node] {
            self.marked[node] = true;
            self.list.push(node as u32);
        }
    }

    /// Inserts the nodes of a block; a full list is not extended.
    pub fn insert_all(&mut self, nodes: impl Iterator<Item = usize>) {
        if self.listed_nodes().is_some() {
            nodes.for_each(|node| self.insert(node));
        } else {
            nodes.for_each(|node| self.marked[node] = true);
        }
    }

    /// Returns the active nodes in the order of insertion; `None` if they are many and the loop runs over all nodes.
    pub fn listed_nodes(&self) -> Option<&[u32]> {
        (!self.all && self.list.len() < LIST_CAPACITY).then_some(self.list.as_slice())
    }

    /// Returns the number of chunks in which the loop runs over all nodes; 0 if it runs over the list.
    pub fn n_chunks(&self, n_nodes: usize) -> usize {
        if self.listed_nodes().is_none() { n_nodes.div_ceil(RUN) } else { 0 }
    }

    /// Returns all active nodes of the reference form, in the order of insertion.
    pub fn reference_nodes(&self) -> &[u32] {
        &self.list
    }

    /// Takes the next batch of active nodes from a range: their number and the nodes; `None` at the end. Entries
    /// beyond the number are meaningless.
    #[inline(always)]
    pub fn next_batch(&self, nodes: &mut Range<usize>) -> Option<(usize, [usize; NODE_BATCH])> {
        let (mut n, mut some) = (0, [0; NODE_BATCH]);
        if self.all {
            n = nodes.len().min(NODE_BATCH);
            some.iter_mut().zip(nodes.start..).for_each(|(place, node)| *place = node);
            nodes.start += n;
        }
        while n < NODE_BATCH && nodes.start < nodes.end {
            some[n] = nodes.start;
            n += usize::from(self.marked[nodes.start]);
            nodes.start += 1;
        }
        (n > 0).then_some((n, some))
    }

    /// Returns true if one of these nodes is active.
    #[inline]
    pub fn contains_any(&self, nodes: Range<usize>) -> bool {
        self.all || self.marked[nodes].contains(&true)
    }

    /// Returns true if a node is active.
    #[inline]
    pub fn has(&self, node: usize) -> bool {
        self.all || self.marked[node]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn active_set_holds_many_nodes_as_it_holds_few() {
        let n_nodes = 3 * LIST_CAPACITY;
        let mut active = ActiveSet::new(n_nodes);
        for n in [0, 1, LIST_CAPACITY - 1, LIST_CAPACITY, n_nodes / 2] {
            let mut odd = (0..n).map(|i| 2 * i + 1);
            let first: Vec<usize> = odd.by_ref().take(LIST_CAPACITY).collect();
            active.insert_all(first.iter().copied());
            active.insert_all(odd.chain(first.iter().copied()));
            assert!((0..n_nodes).all(|node| active.has(node) == (node % 2 == 1 && node < 2 * n)), "{n} active nodes");
            let few: Option<Vec<usize>> =
                active.listed_nodes().map(|few| few.iter().map(|node| *node as usize).collect());
            assert_eq!(few, (n < LIST_CAPACITY).then_some(first), "{n} active nodes");
            let (mut all, mut taken) = (0..n_nodes, vec![]);
            while let Some((n, some)) = active.next_batch(&mut all) {
                taken.extend_from_slice(&some[..n]);
            }
            assert!(taken.iter().copied().eq((0..n).map(|i| 2 * i + 1)), "{n} active nodes");
            active.clear();
            assert!((0..n_nodes).all(|node| !active.has(node)), "{n} active nodes were forgotten");
        }
    }
}
