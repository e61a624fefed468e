//! Statistics of the layout of the work, for measurements only.

use super::blocks::ElementBlock;
use super::engine::Engine;
use crate::fem::{ElementBatches, Potential};
use crate::mesh::NodeId;
use std::ops::Range;

/// Block of elements that is swept at once with local node numbers; no block is divided among threads.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockLayout<'a> {
    /// Nodes in the order of their local numbers.
    pub nodes: &'a [NodeId],
    /// Groups of patches.
    pub groups: Range<usize>,
    /// Number of elements.
    pub n_elements: usize,
    /// Element updates per second of simulated time at the current steps, 1/s; 0 for a block known to be at rest,
    /// and before the first tick.
    pub rate: f64,
    /// True if the block was swept at the last tick: it was active and not known to be at rest.
    pub was_swept: bool,
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Returns the blocks of the SIMD form, in order; empty for the reference form.
    #[must_use]
    pub fn runs(&self) -> Vec<BlockLayout<'_>> {
        let Some(blocks) = &self.blocks else { return vec![] };
        blocks.all.iter().enumerate().map(|(i, block)| self.block_layout(block, blocks.groups_of(i))).collect()
    }

    /// Returns the elements of the blocks in SIMD layout.
    #[must_use]
    pub fn lanes(&self) -> Option<&ElementBatches<D>> {
        self.blocks.as_ref().map(|blocks| &blocks.lanes)
    }

    /// Collects the statistics of a block.
    fn block_layout<'a>(&self, block: &'a ElementBlock, groups: Range<usize>) -> BlockLayout<'a> {
        let of_group = |group: usize| {
            let n_elements = self.order.elements(self.order.slots(group)).count();
            n_elements as f64 / self.grid.time(self.state.clocks[group].step)
        };
        let moves = block.is_moving() && self.state.now.is_some();
        let rate = if moves { groups.clone().map(of_group).sum() } else { 0.0 };
        BlockLayout {
            nodes: &block.nodes,
            groups,
            n_elements: block.n_elements as usize,
            rate,
            was_swept: block.report.is_some(),
        }
    }
}
