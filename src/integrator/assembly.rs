//! Assembly of the contributions of blocks at their nodes, and the feedback of the nodes to the blocks.
//!
//! A few nodes are summed one by one. Many nodes are summed tile by tile and block by block: a block and a tile
//! have some tens of nodes in common, contiguous in both, while going node by node would alternate between blocks.
//! Each sum runs over the blocks in their order either way, so the bits are equal.

#![allow(clippy::inline_always, reason = "only inlined code is compiled for the SIMD level of its caller")]

use super::active_set::{NODE_BATCH, TILE_NODES};
use super::blocks::ElementBlocks;
use super::stability::nodal_step_limit;
use crate::fem::{LANES, NodeAccumulator};
use crate::math::Vector;
use crate::mesh::NodeId;

/// Panic message for a [contiguous](NodalSums::is_contiguous) batch that is not full.
pub(super) const FULL_BATCH: &str = "that many nodes go together";

/// Data of the stable step rule at a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepRule<'a> {
    /// Nodal masses, kg.
    pub mass: &'a [f64],
    /// CFL number.
    pub cfl: f64,
}

/// Assembled impulses, stiffnesses and stable limits of a batch of nodes.
pub(super) struct NodalSums<const D: usize> {
    /// Components of Σ p, N·s, and last Σ κ, N/m, each for the whole batch.
    pub parts: [[f64; NODE_BATCH]; 4],
    /// Stable limit CFL · 2/√λ_a, s.
    pub limit: [f64; NODE_BATCH],
    /// True for nodes that move after their kicks.
    pub moves: [bool; NODE_BATCH],
    /// True if the batch is known to be full and its nodes consecutive.
    pub is_contiguous: bool,
}

impl<const D: usize> NodalSums<D> {
    /// Computes the limits of these nodes from their sums.
    #[inline(always)]
    pub fn new(given: &[NodeAccumulator; NODE_BATCH], nodes: &[usize], rule: StepRule<'_>) -> Self {
        let mut mass = [1.0; NODE_BATCH];
        nodes.iter().zip(&mut mass).for_each(|(node, own)| *own = rule.mass[*node]);
        Self::of(given, &mass, rule.cfl)
    }

    /// Computes the limits of a [contiguous](Self::is_contiguous) batch from its first node on.
    #[inline(always)]
    fn of_contiguous(given: &[NodeAccumulator; NODE_BATCH], first: usize, rule: StepRule<'_>) -> Self {
        let mass = rule.mass[first..].first_chunk().expect(FULL_BATCH);
        Self { is_contiguous: true, ..Self::of(given, mass, rule.cfl) }
    }

    /// Computes the limits of a batch from its sums and masses, kg.
    #[inline(always)]
    fn of(given: &[NodeAccumulator; NODE_BATCH], mass: &[f64; NODE_BATCH], cfl: f64) -> Self {
        // All four components are moved at once; the last ones of a subset would be moved singly.
        let (mut parts, mut limit) = ([[0.0; NODE_BATCH]; 4], [0.0; NODE_BATCH]);
        for (i, given) in given.iter().enumerate() {
            (0..4).for_each(|k| parts[k][i] = given[k]);
        }
        // In a loop of its own, so that roots and divisions are vectorised.
        for i in 0..NODE_BATCH {
            limit[i] = cfl * nodal_step_limit(parts[3][i], mass[i]);
        }
        Self { parts, limit, moves: [false; NODE_BATCH], is_contiguous: false }
    }

    /// Returns Σ p of the i-th node, N·s.
    #[inline(always)]
    pub fn impulse(&self, i: usize) -> Vector<D> {
        Vector::<D>::from_fn(|axis, _| self.parts[axis][i])
    }

    /// Notifies the blocks around these nodes of limits that may change a step and of nodes that move.
    pub fn notify_blocks(&self, nodes: &[usize], blocks: &ElementBlocks<D>) {
        for (i, node) in nodes.iter().enumerate() {
            for copy in blocks.node_copies(*node) {
                let monitor = &blocks.monitors[copy.block as usize];
                if !monitor.holds_at(copy.at as usize - blocks.all[copy.block as usize].first, self.limit[i]) {
                    monitor.request_check();
                }
                if self.moves[i] && !monitor.contributes {
                    blocks.activate(copy.block as usize);
                }
            }
        }
    }
}

/// Tile of nodes, each at its number modulo [`TILE_NODES`].
pub(super) struct NodeTile {
    /// Number of the tile.
    at: usize,
    /// Σ p, N·s, and Σ κ, N/m.
    parts: [NodeAccumulator; TILE_NODES],
    /// Active nodes, their stable limits CFL · 2/√λ_a, s, and the nodes that move after their kicks.
    active: [bool; TILE_NODES],
    limit: [f64; TILE_NODES],
    moves: [bool; TILE_NODES],
    /// Least and greatest limit, lane by lane, and whether all limits are numbers.
    least: [f64; LANES],
    most: [f64; LANES],
    are_numbers: bool,
}

/// Range of the stable limits of the active nodes of a tile, s; both NaN if a limit is not a number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LimitRange {
    least: f64,
    greatest: f64,
}

impl NodeTile {
    /// Sums the contributions of the blocks at the tile that begins with this node, in the order of the blocks.
    #[inline(always)]
    pub fn new<const D: usize>(first: usize, blocks: &ElementBlocks<D>) -> Self {
        let (at, mut parts) = (first / TILE_NODES, [[0.0; 4]; TILE_NODES]);
        for overlap in &blocks.overlaps[at] {
            let block = &blocks.all[overlap.block as usize];
            let nodes = &block.nodes[overlap.numbers()];
            let given = &blocks.parts[block.first..][overlap.numbers()];
            // Two loops, because a branch at each node takes half as long again.
            if blocks.monitors[overlap.block as usize].contributes {
                for (node, given) in nodes.iter().zip(given) {
                    let part = &mut parts[node.index() % TILE_NODES];
                    (0..4).for_each(|i| part[i] += given[i]);
                }
            } else {
                nodes.iter().zip(given).for_each(|(node, given)| parts[node.index() % TILE_NODES][3] += given[3]);
            }
        }
        let (active, limit, moves) = ([false; TILE_NODES], [0.0; TILE_NODES], [false; TILE_NODES]);
        Self { at, parts, active, limit, moves, least: [f64::INFINITY; LANES], most: [0.0; LANES], are_numbers: true }
    }

    /// Returns the sums of some nodes of the tile with their limits.
    #[inline(always)]
    pub fn nodal_sums<const D: usize>(&self, nodes: &[usize], rule: StepRule<'_>) -> NodalSums<D> {
        let (n, first) = (nodes.len(), nodes[0]);
        // Node numbers ascend.
        if n == NODE_BATCH && nodes[n - 1] - first == n - 1 {
            let given = self.parts[first % TILE_NODES..].first_chunk().expect(FULL_BATCH);
            return NodalSums::of_contiguous(given, first, rule);
        }
        let mut given = [[0.0; 4]; NODE_BATCH];
        nodes.iter().zip(&mut given).for_each(|(node, given)| *given = self.parts[node % TILE_NODES]);
        NodalSums::new(&given, nodes, rule)
    }

    /// Records the limits of these active nodes and whether they move.
    #[inline(always)]
    pub fn record<const D: usize>(&mut self, nodes: &[usize], nodal: &NodalSums<D>) {
        self.record_limits(&nodal.limit, nodes.len());
        if nodal.is_contiguous {
            let at = nodes[0] % TILE_NODES;
            let all = at..at + NODE_BATCH;
            self.active[all.clone()].fill(true);
            self.limit[all.clone()].copy_from_slice(&nodal.limit);
            return self.moves[all].copy_from_slice(&nodal.moves);
        }
        for (i, node) in nodes.iter().enumerate() {
            let at = node % TILE_NODES;
            (self.active[at], self.limit[at], self.moves[at]) = (true, nodal.limit[i], nodal.moves[i]);
        }
    }

    /// Records the first `n` of these limits.
    #[inline(always)]
    fn record_limits(&mut self, limits: &[f64; NODE_BATCH], n: usize) {
        let (mut limits, first) = (*limits, limits[0]);
        limits[n..].fill(first);
        // Eight independent lanes avoid a chain of dependent comparisons.
        for eight in limits.as_chunks::<LANES>().0 {
            for (i, limit) in eight.iter().enumerate() {
                self.least[i] = if *limit < self.least[i] { *limit } else { self.least[i] };
                self.most[i] = if *limit > self.most[i] { *limit } else { self.most[i] };
                self.are_numbers &= !limit.is_nan();
            }
        }
    }

    /// Notifies the blocks of the tile of limits that may change a step and of nodes that move.
    #[inline(always)]
    pub fn notify_blocks<const D: usize>(&self, blocks: &ElementBlocks<D>) {
        let limits = self.limit_range();
        for overlap in &blocks.overlaps[self.at] {
            let (block, monitor) = (&blocks.all[overlap.block as usize], &blocks.monitors[overlap.block as usize]);
            let nodes = &block.nodes[overlap.numbers()];
            if monitor.contributes {
                let holds = |(node, number): (&NodeId, usize)| {
                    let at = node.index() % TILE_NODES;
                    !self.active[at] || monitor.holds_at(number, self.limit[at])
                };
                if !monitor.holds_for_all(limits.least, limits.greatest)
                    && !nodes.iter().zip(overlap.numbers()).all(holds)
                {
                    monitor.request_check();
                }
            } else if !block.is_moving() && nodes.iter().any(|node| self.moves[node.index() % TILE_NODES]) {
                blocks.activate(overlap.block as usize);
            }
        }
    }

    /// Returns the least limit of the active nodes that is a number, s.
    #[inline(always)]
    pub fn least(&self) -> f64 {
        self.least.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Returns the range of the limits of the active nodes.
    #[inline(always)]
    fn limit_range(&self) -> LimitRange {
        let least = self.least();
        let greatest = self.most.into_iter().fold(0.0, f64::max);
        if self.are_numbers {
            LimitRange { least, greatest }
        } else {
            LimitRange { least: f64::NAN, greatest: f64::NAN }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::active_set::ActiveSet;
    use super::super::element_block::ElementBlock;
    use super::super::step_monitor::StepMonitor;
    use super::super::test_cube;
    use super::*;
    use crate::contact::ImpulseExchange;
    use crate::fem::Potential;

    /// Prepares the monitors so that two of three blocks contribute.
    fn open(blocks: &mut ElementBlocks<3>) {
        for (i, (block, monitor)) in blocks.all.iter_mut().zip(&mut blocks.monitors).enumerate() {
            *block.awake.get_mut() = i % 3 > 0;
            monitor.prepare(block);
            monitor.contributes = i % 3 > 0;
        }
    }

    fn move_some(nodes: &[usize], nodal: &mut NodalSums<3>) {
        nodes.iter().zip(&mut nodal.moves).for_each(|(node, moves)| *moves = node % 50 == 0);
    }

    fn by_tile(nodes: &[usize], rule: StepRule<'_>, blocks: &ElementBlocks<3>) {
        let n_nodes = rule.mass.len();
        let mut active = ActiveSet::new(n_nodes);
        let first = nodes[0] / TILE_NODES * TILE_NODES;
        let mut all = first..n_nodes.min(first + TILE_NODES);
        for node in nodes {
            active.insert(*node);
        }
        active.all = nodes.len() == all.len();
        let (mut tile, mut limits) = (NodeTile::new(first, blocks), vec![]);
        while let Some((n, some)) = active.next_batch(&mut all) {
            let nodes = &some[..n];
            let mut nodal = tile.nodal_sums(nodes, rule);
            limits.extend_from_slice(&nodal.limit[..n]);
            let is_next = |pair: &[usize]| pair[0] + 1 == pair[1];
            assert_eq!(nodal.is_contiguous, n == NODE_BATCH && nodes.windows(2).all(is_next));
            assert_eq!(nodal.parts, NodalSums::<3>::new(&blocks.sum_parts(nodes), nodes, rule).parts);
            move_some(nodes, &mut nodal);
            tile.record(nodes, &nodal);
        }
        let least = limits.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = limits.iter().copied().fold(0.0, f64::max);
        assert_eq!(tile.limit_range(), LimitRange { least, greatest });
        tile.notify_blocks(blocks);
    }

    fn by_node(nodes: &[usize], rule: StepRule<'_>, blocks: &ElementBlocks<3>) {
        for nodes in nodes.chunks(NODE_BATCH) {
            let mut nodal = NodalSums::new(&blocks.sum_parts(nodes), nodes, rule);
            move_some(nodes, &mut nodal);
            nodal.notify_blocks(nodes, blocks);
        }
    }

    #[test]
    fn assembly_by_tile_and_by_node_agree_bit_for_bit() {
        let mut engine = test_cube::engine(test_cube::gel(&test_cube::mixed()));
        engine.advance_to(1e-3, &mut [ImpulseExchange::default()]).expect("the gel only swings");
        let (n_nodes, mass) = (engine.gel().potential.rest().len(), engine.gel().mass.clone());
        let mut blocks = engine.system.blocks.take().expect("bins have the fast form");
        assert!(n_nodes > 3 * TILE_NODES && blocks.all.iter().any(|block| block.steps.0 < block.steps.1));
        let some: Vec<usize> = (0..n_nodes).filter(|node| node % 7 != 3 || node % TILE_NODES > 100).collect();
        let every: Vec<usize> = (0..n_nodes).collect();
        let mut all = vec![];
        for (cfl, active) in [0.1, 0.4, 0.8, 1.6, 6.4].into_iter().flat_map(|cfl| [(cfl, &some), (cfl, &every)]) {
            let rule = StepRule { mass: &mass, cfl };
            let told = [by_tile, by_node].map(|tell| {
                open(&mut blocks);
                active.chunk_by(|a, b| a / TILE_NODES == b / TILE_NODES).for_each(|nodes| tell(nodes, rule, &blocks));
                let calm: Vec<bool> = blocks.monitors.iter_mut().map(StepMonitor::holds_steps).collect();
                (calm, blocks.all.iter().map(ElementBlock::is_moving).collect::<Vec<bool>>())
            });
            assert_eq!(told[0], told[1], "at a CFL of {cfl}");
            all.push(told[0].clone());
        }
        let has = |calm: bool| all.iter().any(|(of_blocks, _)| of_blocks.contains(&calm));
        assert!(has(true) && has(false), "some blocks are calm and some are not");
        assert!(all.iter().all(|(_, awake)| awake[0]), "who moves wakes a block that slept");
    }
}
