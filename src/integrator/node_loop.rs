//! Node loop of the SIMD form: every active node drifts, computes its stable limit and takes its kick, in one pass.

#![allow(clippy::inline_always, reason = "only inlined code is compiled for the SIMD level of its caller")]

use super::WorkerPool;
use super::active_set::{ActiveSet, NODE_BATCH, RUN, TILE_NODES};
use super::assembly::{NodalSums, NodeTile, StepRule};
use super::blocks::ElementBlocks;
use super::element_block::{BlockActivity, ElementBlock};
use super::kick_sums::KickSums;
use super::node_chunks::NodeChunks;
use super::node_update::NodeUpdate;
use super::pool::share_work;
use super::step_monitor::StepMonitor;
use crate::fem::{Potential, on};

impl<const D: usize> NodeChunks<'_, D> {
    /// Updates the active nodes, chunk by chunk and tile by tile.
    #[inline(always)]
    fn update_active(
        mut self,
        active: &ActiveSet,
        blocks: &ElementBlocks<D>,
        rule: StepRule<'_>,
        update: &NodeUpdate<'_, D, impl Potential<D>>,
    ) {
        for chunk in 0..self.sums.len() {
            let mut sums = KickSums::default();
            let end = self.first + self.position.len().min((chunk + 1) * RUN);
            let tiles =
                (self.first + chunk * RUN..end).step_by(TILE_NODES).map(|first| first..end.min(first + TILE_NODES));
            for mut nodes in tiles.filter(|nodes| active.contains_any(nodes.clone())) {
                let mut tile = NodeTile::new(nodes.start, blocks);
                // A loop and not a closure: so large a closure is not inlined and thus not compiled for the SIMD
                // level.
                while let Some((n, some)) = active.next_batch(&mut nodes) {
                    let mut nodal = tile.nodal_sums(&some[..n], rule);
                    let greatest = std::mem::take(&mut sums.max_speed_squared);
                    update.apply(&mut self, &some[..n], &mut nodal, &mut sums);
                    self.note_speed(&some[..n], sums.max_speed_squared.sqrt());
                    sums.max_speed_squared = sums.max_speed_squared.max(greatest);
                    tile.record(&some[..n], &nodal);
                }
                sums.limit = sums.limit.min(tile.least());
                tile.notify_blocks(blocks);
            }
            self.sums[chunk] = sums;
        }
    }

    /// Sets or raises the speed bounds of the batches of some nodes, ascending, to their greatest speed, m/s: sets it if
    /// they are all nodes of a batch.
    #[inline(always)]
    fn note_speed(&mut self, nodes: &[usize], speed: f64) {
        let (first, end) = (nodes[0] - self.first, nodes[nodes.len() - 1] - self.first + 1);
        let batches = first / NODE_BATCH..end.div_ceil(NODE_BATCH);
        let is_whole = end - first == nodes.len()
            && first.is_multiple_of(NODE_BATCH)
            && (end.is_multiple_of(NODE_BATCH) || end == self.position.len());
        for bound in &mut self.speeds[batches] {
            *bound = if is_whole { speed } else { bound.max(speed) };
        }
    }
}

impl<const D: usize> ElementBlocks<D> {
    /// Collects the nodes of the active blocks that are not known to be at rest.
    pub fn find_active_nodes(&mut self, active: &mut ActiveSet) {
        active.clear();
        for (block, monitor) in self.all.iter().zip(&mut self.monitors) {
            monitor.prepare(block);
        }
        let contributes = |(block, monitor): (&ElementBlock, &StepMonitor)| {
            block.activity == BlockActivity::All && monitor.contributes
        };
        active.all = self.all.iter().zip(&self.monitors).all(contributes);
        if active.all {
            return;
        }
        for block in self.all.iter().filter(|block| block.contributes()) {
            active.insert_all(block.active_nodes().map(|number| block.nodes[number].index()));
        }
        let is_at_rest = |block: &&mut ElementBlock| block.activity != BlockActivity::Nothing && !block.contributes();
        for block in self.all.iter_mut().filter(is_at_rest) {
            block.has_active_nodes = block.nodes.iter().any(|node| active.has(node.index()));
        }
    }
}

/// Node phase of the SIMD form: reads the sums of the blocks, and drifts and kicks the active nodes.
pub(super) struct NodePhase<'a, const D: usize, P> {
    pub update: NodeUpdate<'a, D, P>,
    pub rule: StepRule<'a>,
    pub blocks: &'a ElementBlocks<D>,
    pub active: &'a ActiveSet,
    pub pool: Option<&'a WorkerPool>,
    /// Nodal data and the sums of its chunks; without chunks the loop runs over a list.
    pub nodes: NodeChunks<'a, D>,
}

impl<const D: usize, P: Potential<D>> NodePhase<'_, D, P> {
    /// Drifts the active nodes, finds their stable limits, kicks and damps them.
    ///
    /// The kick is v += p/m in the free directions; p and Σ κ are summed over the blocks in their order. Held
    /// directions take the rest as reactions. The sums do not depend on the threads.
    pub fn update(self) -> KickSums {
        let Self { update, rule, blocks, active, pool, mut nodes } = self;
        let mut total = KickSums::default();
        if let Some(few) = active.listed_nodes() {
            for some in few.chunks(NODE_BATCH) {
                let mut batch = [0; NODE_BATCH];
                batch.iter_mut().zip(some).for_each(|(node, listed)| *node = *listed as usize);
                let batch = &batch[..some.len()];
                let mut nodal = NodalSums::new(&blocks.sum_parts(batch), batch, rule);
                update.apply(&mut nodes, batch, &mut nodal, &mut total);
                total.limit = nodal.limit[..batch.len()].iter().copied().fold(total.limit, f64::min);
                nodal.notify_blocks(batch, blocks);
            }
            return total;
        }
        let (level, n_chunks) = (blocks.level, nodes.sums.len());
        let chunks = NodeChunks { sums: &mut *nodes.sums, ..nodes };
        share_work(pool, n_chunks, chunks, |chunks: NodeChunks<'_, D>| {
            on!(level, _simd => chunks.update_active(active, blocks, rule, &update));
        });
        nodes.sums.iter().fold(total, KickSums::merge)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_cube;
    use super::*;
    use crate::contact::{FreeDirections, ImpulseExchange};
    use crate::math::Vector;
    use crate::state::Tick;

    /// Result of an update, bit by bit: nodal vectors, limits, residuals and last ticks; flags of the blocks.
    type After = ([Vec<Vector<3>>; 3], [Vec<u64>; 2], Vec<Tick>, [Vec<bool>; 2]);

    #[test]
    fn updates_by_tile_and_by_list_agree_bit_for_bit() {
        let mut engine = test_cube::engine(test_cube::gel(&test_cube::mixed()));
        engine.advance_to(1e-3, &mut [ImpulseExchange::default()]).expect("the gel only swings");
        let gel = engine.system.model.gel.clone();
        let n_nodes = gel.mass.len();
        let mut blocks = engine.system.blocks.take().expect("bins have the fast form");
        let (grid, tick) = (engine.system.model.grid, engine.system.state.now.expect("it has begun") + 1);
        let freedom = FreeDirections::SPATIAL;
        let update = NodeUpdate { gel: &gel, grid, freedom, tick, leading_share: 0.5, damping_rate: 0.0 };
        let rule = StepRule { mass: &gel.mass, cfl: 0.8 };
        let mut active = ActiveSet::new(n_nodes);
        active.insert_all((0..n_nodes).filter(|node| node % 7 != 3 || node % TILE_NODES > 100));
        assert!(active.listed_nodes().is_none() && blocks.monitors.len() > 2);
        let mut after = |by_tile: bool| -> After {
            for (block, monitor) in blocks.all.iter_mut().zip(&mut blocks.monitors) {
                *block.awake.get_mut() = true;
                block.activity = BlockActivity::All;
                monitor.prepare(block);
            }
            let (mut position, mut velocity) =
                (engine.system.state.position.clone(), engine.system.state.velocity.clone());
            let (mut before, mut last) = (vec![Vector::<3>::zeros(); n_nodes], engine.system.clock.last_ticks.clone());
            let (mut limit, mut excess) = (vec![0.0; n_nodes], engine.system.state.excess.clone());
            let (mut decay, mut sums) = (vec![0.0; n_nodes], vec![KickSums::default(); n_nodes.div_ceil(RUN)]);
            let mut speeds = vec![0.0; n_nodes.div_ceil(NODE_BATCH)];
            let mut chunks = NodeChunks {
                first: 0,
                position: &mut position,
                velocity: &mut velocity,
                before: &mut before,
                last: &mut last,
                limit: &mut limit,
                excess: &mut excess,
                decay: &mut decay,
                speeds: &mut speeds,
                sums: &mut sums,
            };
            if by_tile {
                chunks.update_active(&active, &blocks, rule, &update);
            } else {
                let all: Vec<usize> = (0..n_nodes).filter(|node| active.has(*node)).collect();
                for nodes in all.chunks(NODE_BATCH) {
                    let mut nodal = NodalSums::new(&blocks.sum_parts(nodes), nodes, rule);
                    update.apply(&mut chunks, nodes, &mut nodal, &mut KickSums::default());
                    nodal.notify_blocks(nodes, &blocks);
                }
            }
            let least = |run: usize| {
                let nodes = (run * RUN..n_nodes.min((run + 1) * RUN)).filter(|node| active.has(*node));
                nodes.map(|node| limit[node]).fold(f64::INFINITY, f64::min)
            };
            assert!(!by_tile || sums.iter().enumerate().all(|(run, sums)| sums.limit == least(run)));
            let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect();
            let calm = blocks.monitors.iter_mut().map(StepMonitor::holds_steps).collect();
            let awake = blocks.all.iter().map(ElementBlock::is_moving).collect();
            ([position, velocity, before], [bits(limit), bits(excess)], last, [calm, awake])
        };
        assert!(after(true) == after(false));
    }
}
