//! Overlaps of blocks and tiles of nodes: the nodes that both have in common.

use super::active_set::TILE_NODES;
use super::element_block::ElementBlock;
use std::ops::Range;

/// Overlap of a block and a tile of nodes: the local number of the first common node and their count.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileOverlap {
    pub block: u32,
    first: u16,
    n: u16,
}

impl TileOverlap {
    /// Finds the overlaps of each tile of nodes, in the order of the blocks.
    pub fn find_all(blocks: &[ElementBlock], n_nodes: usize) -> Vec<Vec<Self>> {
        let mut overlaps = vec![vec![]; n_nodes.div_ceil(TILE_NODES)];
        for (block, own) in (0..).zip(blocks) {
            let mut first = 0;
            for nodes in own.nodes.chunk_by(|a, b| a.index() / TILE_NODES == b.index() / TILE_NODES) {
                let n = nodes.len() as u16;
                overlaps[nodes[0].index() / TILE_NODES].push(Self { block, first, n });
                first += n;
            }
        }
        overlaps
    }

    /// Returns the local numbers of the nodes in the block.
    #[inline]
    pub fn numbers(self) -> Range<usize> {
        let first = usize::from(self.first);
        first..first + usize::from(self.n)
    }
}
