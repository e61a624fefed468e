//! Node loop of the SIMD form: every active node drifts, computes its stable limit and takes its kick, in one pass.

#![allow(clippy::inline_always, reason = "only inlined code is compiled for the SIMD level of its caller")]

use super::active_set::{ActiveSet, NODE_BATCH, RUN, TILE_NODES};
use super::assembly::{NodalSums, NodeTile, StepRule};
use super::blocks::ElementBlocks;
use super::element_block::BlockActivity;
use super::kick_sums::KickSums;
use super::node_chunks::NodeChunks;
use super::node_update::NodeUpdate;
use super::pool::share_work;
use super::system::DiscreteSystem;
use crate::fem::{Potential, on};
use crate::state::Tick;

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

/// Collects the nodes of the active blocks that are not known to be at rest.
pub(super) fn find_active_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let Some(blocks) = &mut system.blocks else { return };
    let active = &mut system.workspace.active_nodes;
    active.clear();
    for (block, monitor) in blocks.all.iter().zip(&mut blocks.monitors) {
        monitor.prepare(block);
    }
    active.all = blocks
        .all
        .iter()
        .zip(&blocks.monitors)
        .all(|(block, monitor)| block.activity == BlockActivity::All && monitor.contributes);
    if active.all {
        return;
    }
    for block in blocks.all.iter().filter(|block| block.contributes()) {
        active.insert_all(block.active_nodes().map(|number| block.nodes[number].index()));
    }
    for block in blocks.all.iter_mut().filter(|block| block.activity != BlockActivity::Nothing && !block.contributes())
    {
        block.has_active_nodes = block.nodes.iter().any(|node| active.has(node.index()));
    }
}

/// Drifts the active nodes without a kick.
pub(super) fn drift_active<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let active = &system.workspace.active_nodes;
    for (node, last) in system.clock.last_ticks.iter_mut().enumerate().filter(|(node, _)| active.has(*node)) {
        let passed = system.model.grid.time(tick - *last);
        system.state.position[node] += system.state.velocity[node] * passed;
        *last = tick;
    }
}

/// Drifts the active nodes, finds their stable limits, kicks and damps them.
///
/// The kick is v += p/m in the free directions; p and Σ κ are summed over the blocks in their order. Held
/// directions take the rest as reactions.
pub(super) fn update_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> KickSums {
    let (gel, freedom) = (system.model.gel.clone(), system.freedom());
    let (grid, leading_share, damping_rate) =
        (system.model.grid, system.leading_share(), system.model.settings.damping);
    update_active_nodes(system, &NodeUpdate { gel: &gel, grid, freedom, tick, leading_share, damping_rate })
}

/// Updates the active nodes batch by batch; the sums do not depend on the threads.
fn update_active_nodes<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    update: &NodeUpdate<'_, D, P>,
) -> KickSums {
    let pool = system.pool.clone().filter(|_| system.is_worth_sharing());
    let blocks = system.blocks.take().expect("the fast form has blocks");
    let (state, workspace) = (&mut system.state, &mut system.workspace);
    let level = blocks.level;
    let few = workspace.active_nodes.listed_nodes();
    let n_chunks = if few.is_none() { state.position.len().div_ceil(RUN) } else { 0 };
    workspace.chunk_sums.resize(n_chunks, KickSums::default());
    let mut all = NodeChunks {
        first: 0,
        position: &mut state.position,
        velocity: &mut state.velocity,
        before: &mut workspace.velocities_before,
        last: &mut system.clock.last_ticks,
        limit: &mut workspace.node_limits,
        excess: &mut state.excess,
        decay: &mut workspace.decay,
        speeds: &mut system.batch_travel.speeds,
        sums: &mut workspace.chunk_sums,
    };
    let (active, mut total) = (&workspace.active_nodes, KickSums::default());
    let rule = StepRule { mass: &update.gel.mass, cfl: system.model.settings.cfl };
    if let Some(few) = few {
        for some in few.chunks(NODE_BATCH) {
            let mut nodes = [0; NODE_BATCH];
            nodes.iter_mut().zip(some).for_each(|(node, listed)| *node = *listed as usize);
            let nodes = &nodes[..some.len()];
            let mut nodal = NodalSums::new(&blocks.sum_parts(nodes), nodes, rule);
            update.apply(&mut all, nodes, &mut nodal, &mut total);
            total.limit = nodal.limit[..nodes.len()].iter().copied().fold(total.limit, f64::min);
            nodal.notify_blocks(nodes, &blocks);
        }
    } else {
        share_work(pool.as_deref(), n_chunks, all, |chunks: NodeChunks<'_, D>| {
            on!(level, _simd => chunks.update_active(active, &blocks, rule, update));
        });
        total = workspace.chunk_sums.iter().fold(total, KickSums::merge);
    }
    system.blocks = Some(blocks);
    total
}

#[cfg(test)]
mod tests {
    use super::super::element_block::ElementBlock;
    use super::super::step_monitor::StepMonitor;
    use super::super::test_cube;
    use super::*;
    use crate::contact::{FreeDirections, ImpulseExchange};
    use crate::math::Vector;

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
