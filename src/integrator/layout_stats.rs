//! Statistics of the layout of the work, for measurements only.

use super::blocks::ElementBlocks;
use super::element_block::ElementBlock;
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
    /// True if the block was swept at the last tick: it was active and not known to be at rest.
    pub was_swept: bool,
}

/// Returns the blocks of the SIMD form, in order; empty for the reference form.
pub(super) fn block_layouts<const D: usize>(blocks: Option<&ElementBlocks<D>>) -> Vec<BlockLayout<'_>> {
    let Some(blocks) = blocks else { return vec![] };
    let layout = |(i, block)| block_layout(block, blocks.groups_of(i));
    blocks.all.iter().enumerate().map(layout).collect()
}

/// Collects the statistics of a block.
fn block_layout(block: &ElementBlock, groups: Range<usize>) -> BlockLayout<'_> {
    let (n_elements, was_swept) = (block.n_elements as usize, block.report.is_some());
    BlockLayout { nodes: &block.nodes, groups, n_elements, was_swept }
}
