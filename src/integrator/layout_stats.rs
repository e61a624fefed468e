//! Statistics of the layout of the work, for measurements only.

use super::element_block::ElementBlock;
use super::system::DiscreteSystem;
use crate::fem::Potential;
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

/// Returns the blocks of the SIMD form, in order; empty for the reference form.
pub(super) fn runs<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>) -> Vec<BlockLayout<'_>> {
    let Some(blocks) = &system.blocks else { return vec![] };
    blocks.all.iter().enumerate().map(|(i, block)| block_layout(system, block, blocks.groups_of(i))).collect()
}

/// Collects the statistics of a block.
fn block_layout<'a, const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    block: &'a ElementBlock,
    groups: Range<usize>,
) -> BlockLayout<'a> {
    let of_group = |group: usize| {
        let n_elements = system.model.layout.elements(system.model.layout.slots(group)).count();
        n_elements as f64 / system.model.grid.time(system.state.clocks[group].step)
    };
    let moves = block.is_moving() && system.state.now.is_some();
    let rate = if moves { groups.clone().map(of_group).sum() } else { 0.0 };
    BlockLayout {
        nodes: &block.nodes,
        groups,
        n_elements: block.n_elements as usize,
        rate,
        was_swept: block.report.is_some(),
    }
}
