//! Element loop: finds the active elements and evaluates them in one pass from positions to forces, shared among
//! threads.

#![allow(clippy::inline_always, reason = "only inlined code is compiled for the SIMD level of its caller")]

use super::blocks::{ElementBlocks, group_range};
use super::element_block::{BlockActivity, BlockReport, ElementBlock, SweepCache};
use super::element_order::{ElementLayout, SLOTS};
use super::partial_block::GroupStar;
use super::pool::{SplitWork, share_work};
use super::substep::{MeshPhase, TickContext};
use super::{TickGrid, WorkerPool};
use crate::fem::{
    ElementBatches, GroupKick, GroupKicks, GroupResponse, HistoryLanes, LANES, NodeAccumulator, NodeCache, NodeMotion,
    NodeSource, ReportPower,
};
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::{GroupClock, Tick};
use fearless_simd::Level;
use std::sync::atomic::Ordering;

/// Input of a sweep over the elements.
#[derive(Clone, Copy)]
pub(super) struct ElementLoopInput<'a, const D: usize> {
    pub moment: TickContext,
    pub grid: TickGrid,
    pub position: &'a [Vector<D>],
    pub velocity: &'a [Vector<D>],
    pub rest: &'a [Vector<D>],
    /// Last tick of each node.
    pub last: &'a [Tick],
    pub clocks: &'a [GroupClock],
    pub order: &'a ElementLayout,
}

/// Output of a sweep, from a first block on.
struct ElementLoopOutput<'a> {
    first: usize,
    blocks: &'a mut [ElementBlock],
    parts: &'a mut [NodeAccumulator],
    stiffness: &'a mut [f64],
    responses: &'a mut [GroupResponse],
    memory: &'a mut [HistoryLanes],
    /// Groups per block, and rows of history variables per block, eight lanes each.
    groups: usize,
    rows: usize,
}

impl SplitWork for ElementLoopOutput<'_> {
    /// Splits by the number of elements to sweep.
    fn split_at_part(self, part: usize, of: usize) -> (Self, Self) {
        let Self { first, blocks, parts, stiffness, responses, memory, groups, rows } = self;
        let middle = count_for_share(blocks, part as f64 / of as f64);
        let (blocks, more_blocks) = blocks.split_at_mut(middle);
        let (parts, more_parts) = parts.split_at_mut(blocks.iter().map(|block| block.nodes.len()).sum());
        let (stiffness, more_stiffness) = stiffness.split_at_mut(stiffness.len().min(middle * SLOTS));
        let (responses, more_responses) = responses.split_at_mut(responses.len().min(middle * groups));
        let (memory, more_memory) = memory.split_at_mut(memory.len().min(middle * rows));
        let own = Self { first, blocks, parts, stiffness, responses, memory, groups, rows };
        let (first, blocks, parts, stiffness) = (first + middle, more_blocks, more_parts, more_stiffness);
        let (responses, memory) = (more_responses, more_memory);
        (own, Self { first, blocks, parts, stiffness, responses, memory, groups, rows })
    }
}

/// SIMD batches per block.
const BATCHES_PER_BLOCK: usize = SLOTS / LANES;

impl<const D: usize> ElementBlocks<D> {
    /// Finds the active groups of every block; returns the number of elements to sweep.
    pub fn find_active(&mut self, input: &ElementLoopInput<'_, D>) -> u64 {
        for (i, block) in self.all.iter_mut().enumerate() {
            block.find_active(input, group_range(i, self.groups, input.clocks.len()));
        }
        self.all.iter().map(ElementBlock::elements_to_sweep).sum()
    }

    /// Sweeps all active blocks that are not known to be at rest, shared among the threads of a pool if there is one.
    pub fn sweep(
        &mut self,
        input: &ElementLoopInput<'_, D>,
        stiffness: &mut [f64],
        responses: &mut [GroupResponse],
        pool: Option<&WorkerPool>,
    ) {
        if self.never_rest {
            let at_rest = self.all.iter_mut().filter(|block| block.cache == SweepCache::AtRest);
            at_rest.for_each(|block| block.cache = SweepCache::Swept);
        }
        if let Some(pool) = pool {
            let still = self.still;
            self.locals.ensure_threads(pool, || NodeCache::new(still));
        }
        let kernel = BlockKernel { lanes: &self.lanes, level: self.level, is_prestrained: self.is_prestrained };
        let locals = &self.locals;
        let (n_blocks, blocks, parts) = (self.all.len(), self.all.as_mut_slice(), self.parts.as_mut_slice());
        let (memory, groups, rows) = (self.memory.as_mut_slice(), self.groups, BATCHES_PER_BLOCK * self.lanes.rows());
        let all = ElementLoopOutput { first: 0, blocks, parts, stiffness, responses, memory, groups, rows };
        share_work(pool, n_blocks, all, |output| {
            let (mut parts, mut memory, mut local) = (output.parts, output.memory, locals.own());
            let block_outputs = output.stiffness.chunks_mut(SLOTS).zip(output.responses.chunks_mut(output.groups));
            for (i, (block, (stiffness, responses))) in output.blocks.iter_mut().zip(block_outputs).enumerate() {
                let (part, more) = parts.split_at_mut(block.nodes.len());
                parts = more;
                let (own, more) = memory.split_at_mut(memory.len().min(rows));
                memory = more;
                let groups = group_range(output.first + i, output.groups, input.clocks.len());
                let output = BlockOutput { groups, part, stiffness, responses, history: own };
                block.sweep(input, kernel, output, &mut local);
            }
        });
    }
}

/// Output of the sweep of one block.
struct BlockOutput<'a> {
    /// Groups of the block.
    groups: std::ops::Range<usize>,
    /// Impulse, N·s, and stiffness, N/m, of the block at each of its nodes.
    part: &'a mut [NodeAccumulator],
    /// κ by slot, N/m.
    stiffness: &'a mut [f64],
    /// Responses of its groups.
    responses: &'a mut [GroupResponse],
    /// History variables of its elements, in rows.
    history: &'a mut [HistoryLanes],
}

/// Element kernel of a sweep: the elements in SIMD layout and the instruction set for them.
#[derive(Clone, Copy)]
struct BlockKernel<'a, const D: usize> {
    lanes: &'a ElementBatches<D>,
    level: Level,
    /// True if elements can pull although all their nodes are at rest positions.
    is_prestrained: bool,
}

/// Counts the leading blocks that have about this fraction of the elements to sweep.
pub(super) fn count_for_share(blocks: &[ElementBlock], part: f64) -> usize {
    let target = blocks.iter().map(ElementBlock::elements_to_sweep).sum::<u64>() as f64 * part;
    let mut so_far = 0;
    let reached = |block: &ElementBlock| {
        so_far += block.elements_to_sweep();
        so_far as f64 >= target
    };
    blocks.iter().position(reached).map_or(blocks.len(), |at| at + 1)
}

/// Returns the longest of these steps that is active at a tick, if the least one is: each is a power of two, one
/// bit of `lengths`.
fn longest_active_step(lengths: Tick, tick: Tick) -> Tick {
    // The lowest bit of the tick and all bits below it.
    let active = lengths & (tick ^ (tick - 1));
    1 << active.ilog2()
}

impl ElementBlock {
    /// Finds the activity of the block, its active groups and the number of their elements.
    fn find_active<const D: usize>(&mut self, input: &ElementLoopInput<'_, D>, groups: std::ops::Range<usize>) {
        self.has_active_nodes = false;
        let is_active = |step: Tick| input.moment.is_active(step);
        self.activity = match (is_active(self.steps.0), is_active(self.steps.1)) {
            (false, _) => BlockActivity::Nothing,
            (true, true) => BlockActivity::All,
            (true, false) => BlockActivity::Some,
        };
        self.n_active_elements = if self.activity == BlockActivity::All { self.n_elements } else { 0 };
        if self.activity == BlockActivity::Some {
            let active = groups.filter(|group| is_active(input.clocks[*group].step));
            self.longest_active = longest_active_step(self.lengths, input.moment.tick);
            let star = self
                .active_stars
                .entry(self.longest_active)
                .or_insert_with(|| GroupStar::of_groups(input.order, active));
            self.n_active_elements = star.n_elements;
        }
    }

    /// Finds the node star of the active groups where some are active, unless an earlier tick has found it.
    fn find_star<const D: usize>(&mut self, lanes: &ElementBatches<D>, groups: std::ops::Range<usize>) {
        if let Some(star) = self.active_stars.get_mut(&self.longest_active).filter(|star| star.nodes.is_empty()) {
            star.find_nodes(lanes, groups);
        }
    }

    /// Returns the active groups among all groups of the block.
    fn active_groups(&self, all: std::ops::Range<usize>) -> impl Iterator<Item = usize> + '_ {
        let all = if self.activity == BlockActivity::All { all } else { 0..0 };
        let some = if self.activity == BlockActivity::Some { self.active_star().groups.as_slice() } else { &[] };
        all.chain(some.iter().map(|group| *group as usize))
    }

    /// Loads the nodes at this tick and sweeps the active elements, unless all are at rest and were fully swept at
    /// rest before.
    fn sweep<const D: usize>(
        &mut self,
        input: &ElementLoopInput<'_, D>,
        kernel: BlockKernel<'_, D>,
        output: BlockOutput<'_>,
        local: &mut NodeCache,
    ) {
        let BlockKernel { lanes, level, is_prestrained } = kernel;
        let BlockOutput { groups, part, stiffness, responses, history } = output;
        (self.report, self.power_accumulator) = (None, None);
        if self.activity == BlockActivity::Some {
            self.find_star(lanes, groups.clone());
        }
        if !self.needs_sweep() {
            if self.cache == SweepCache::Empty {
                lanes.sum_stiffness(groups, stiffness, part);
                self.cache = SweepCache::Swept;
            }
            return;
        }
        let moves = self.load_nodes(input, level, local);
        // In a partly active block the other nodes may move.
        let moves = moves || is_prestrained || (self.activity == BlockActivity::Some && self.is_moving());
        self.awake.store(moves, Ordering::Relaxed);
        if !moves && self.cache == SweepCache::AtRest {
            return;
        }
        let kick = |group: usize| input.kick(input.clocks[group].step);
        self.has_unsaved_history |= !history.is_empty();
        let uniform = self.uniform_step(&input.moment);
        let power = if uniform.is_some() { ReportPower::Untold } else { ReportPower::Told };
        let common = uniform.and_then(|step| input.kick(step));
        let kicks = common.map_or(GroupKicks::Each(&kick), GroupKicks::Same);
        lanes.sweep(level, (groups.clone(), kicks, power), local, (&mut *stiffness, &mut *responses, history));
        self.dissipation = local.spent();
        if let Some(step) = uniform {
            responses[0].power = local.work(self.nodes.len()) / input.grid.time(step);
        }
        let sums = local.accumulated(self.nodes.len());
        if self.activity == BlockActivity::All {
            part.copy_from_slice(sums);
        } else {
            self.store_partial(sums, stiffness, part);
            if self.cache == SweepCache::Empty {
                lanes.sum_stiffness(groups.clone(), stiffness, part);
            }
        }
        self.cache = if !moves && self.activity == BlockActivity::All { SweepCache::AtRest } else { SweepCache::Swept };
        self.make_report(input, groups.clone(), responses, moves);
        self.power_accumulator = uniform.map(|_| groups.start);
    }

    /// Stores the sweep of some groups in the part; the other groups contribute only their κ.
    fn store_partial(&self, sums: &[NodeAccumulator], stiffness: &[f64], part: &mut [NodeAccumulator]) {
        let GroupStar { nodes, slots, ends, .. } = self.active_star();
        for part in part.iter_mut() {
            part[..3].fill(0.0);
        }
        let mut first = 0;
        for (number, end) in nodes.iter().zip(ends) {
            let all = &slots[first..usize::from(*end)];
            let sum = all.iter().fold(0.0, |sum, slot| sum + stiffness[usize::from(*slot)]);
            let [x, y, z, _] = sums[usize::from(*number)];
            part[usize::from(*number)] = [x, y, z, sum];
            first = usize::from(*end);
        }
    }

    /// Returns the step of all groups, ticks, if all are active after a whole step: the power of all groups is then
    /// summed at the nodes at once.
    fn uniform_step(&self, moment: &TickContext) -> Option<Tick> {
        let (least, most) = self.steps;
        let whole = moment.phase == MeshPhase::Between && most > 0 && moment.ticks_since_last(most) == most;
        (self.activity == BlockActivity::All && least == most && whole).then_some(most)
    }

    /// Loads the active nodes; returns true if one of them has moved or moves.
    fn load_nodes<const D: usize>(&self, input: &ElementLoopInput<'_, D>, level: Level, local: &mut NodeCache) -> bool {
        local.begin();
        let nodes = self.nodes.as_slice();
        if self.activity == BlockActivity::All {
            return local.load(level, input, nodes.iter().copied().enumerate());
        }
        let some = self.active_star().nodes.iter().map(|number| usize::from(*number));
        local.load(level, input, some.map(|number| (number, nodes[number])))
    }

    /// Summarises the responses of the active groups in the report.
    fn make_report<const D: usize>(
        &mut self,
        input: &ElementLoopInput<'_, D>,
        groups: std::ops::Range<usize>,
        responses: &[GroupResponse],
        moves: bool,
    ) {
        let updates = if moves { self.elements_to_sweep() } else { 0 };
        let mut report = BlockReport { updates, ..BlockReport::default() };
        // A clock is read only where needed: it is far in memory.
        for group in self.active_groups(groups.clone()) {
            let response = &responses[group - groups.start];
            report.least_jacobian = report.least_jacobian.min(response.least_jacobian);
            report.closes |= response.closing > 0.0 && closes(response, input.grid.time(input.clocks[group].step));
            if report.failed_group.is_none() && is_failure(&input.clocks[group], response) {
                report.failed_group = Some(group);
            }
        }
        self.report = Some(report);
    }
}

/// Returns true if an element of a group would invert within a step, s.
pub(super) fn closes(response: &GroupResponse, step: f64) -> bool {
    response.closing * step > 1.0
}

/// Returns true if a response ends the run: an element inverted for the second tick in a row, or an energy that is
/// not a number.
pub(super) fn is_failure(clock: &GroupClock, response: &GroupResponse) -> bool {
    needs_check(response) && (!response.energy.is_finite() || response.inverted & clock.inverted != 0)
}

/// Returns true if a response may end the run, whatever the previous tick.
fn needs_check(response: &GroupResponse) -> bool {
    !response.energy.is_finite() || response.inverted != 0
}

impl<const D: usize> ElementLoopInput<'_, D> {
    /// Returns the kick of an active group; its length is 0 at the start, when no step is known yet.
    #[inline(always)]
    fn kick(&self, step: Tick) -> Option<GroupKick> {
        let kick = || GroupKick {
            length: self.grid.length(self.moment.planned_kick(step)),
            elapsed: self.grid.time(self.moment.elapsed(step)),
        };
        self.moment.is_active(step).then(kick)
    }
}

impl<const D: usize> NodeSource<D> for ElementLoopInput<'_, D> {
    #[inline(always)]
    fn of(&self, node: NodeId) -> NodeMotion<'_, D> {
        let a = node.index();
        let passed = self.grid.time(self.moment.tick - self.last[a]);
        NodeMotion { position: &self.position[a], velocity: &self.velocity[a], rest: &self.rest[a], passed }
    }
}

#[cfg(test)]
mod tests {
    use super::super::blocks::MIN_SHARED_ELEMENTS;
    use super::super::test_cube;
    use super::super::{DiscreteGel, Engine, LoadedFacet, PressureHistory, PressureLoads};
    use super::*;
    use crate::contact::ImpulseExchange;
    use crate::fem::{Section, Simplices};
    use crate::mesh::{ElementId, Facet, graded};

    #[test]
    fn partly_active_blocks_agree_bit_for_bit_for_any_number_of_threads() {
        let mesh = test_cube::mesh(&graded(1.0, 0.025, (0.3, 1.3, 0.2)));
        let run = |threads| {
            let mut engine = test_cube::engine(test_cube::gel(&mesh)).with_pool(WorkerPool::new(threads));
            let (mut in_part, mut tick) = (0, 0);
            for _ in 0..32 {
                engine
                    .advance_to(engine.system.model.grid.time(tick), &mut [ImpulseExchange::default()])
                    .expect("the gel only swings");
                tick += engine.system.clock.step_range.0;
                let all = &engine.system.blocks.as_ref().expect("bins have the fast form").all;
                let some = all.iter().any(|block| block.activity == BlockActivity::Some);
                in_part += usize::from(
                    some && all.iter().map(ElementBlock::elements_to_sweep).sum::<u64>() > MIN_SHARED_ELEMENTS,
                );
            }
            (engine.system.state.position, engine.system.state.velocity, in_part)
        };
        let one = run(1);
        assert!(one.2 > 4, "{} ticks of what fires in part are shared", one.2);
        assert!(run(3) == one && run(2) == one);
    }

    #[test]
    fn longest_active_step_is_one_of_the_steps() {
        let lengths = 1 | 16 | 256;
        let found = [1, 8, 16, 48, 128, 256, 512, 768].map(|tick| longest_active_step(lengths, tick));
        assert_eq!(found, [1, 1, 16, 16, 16, 256, 256, 256]);
    }

    /// Puts a pressure on every facet.
    fn loads(gel: &DiscreteGel<3, Simplices<3>>) -> PressureLoads {
        let of = |(facet, behind): (&Facet, &ElementId)| LoadedFacet { facet: *facet, behind: *behind, mark: 1 };
        let facets = gel.surface.facets.iter().zip(&gel.behind).map(of).collect();
        PressureLoads {
            section: Section::Spatial,
            pressures: vec![PressureHistory::new(vec![(0.0, 0.0), (1e-3, 50.0)])],
            air: None,
            facets,
        }
    }

    /// Counts the partly swept blocks found after each of these communication steps; checks after each step that
    /// every part has the κ of all elements of its block.
    fn swept_in_part(mut engine: Engine<3, Simplices<3>>, steps: u32) -> usize {
        let (mut in_part, mut seen) = (0, None);
        for step in 1..=steps {
            engine.advance_to(f64::from(step) * 2e-5, &mut [ImpulseExchange::default()]).expect("the gel only swings");
            if std::mem::replace(&mut seen, engine.system.state.now) == engine.system.state.now {
                continue;
            }
            let blocks = engine.system.blocks.as_ref().expect("bins have the fast form");
            for (i, block) in blocks.all.iter().enumerate() {
                let part = &blocks.parts[block.first..][..block.nodes.len()];
                let mut whole = part.to_vec();
                blocks.lanes.sum_stiffness(
                    blocks.groups_of(i),
                    &engine.system.state.stiffness[i * SLOTS..],
                    &mut whole,
                );
                assert!(part.iter().zip(&whole).all(|(part, whole)| part[3] == whole[3]), "block {i} at step {step}");
                in_part += usize::from(block.activity == BlockActivity::Some && block.report.is_some());
            }
        }
        in_part
    }

    #[test]
    fn partly_active_block_has_the_stiffness_of_all_its_elements() {
        let mesh = test_cube::mixed();
        for is_loaded in [false, true] {
            let gel = test_cube::gel(&mesh);
            let loads = if is_loaded { loads(&gel) } else { PressureLoads::none() };
            let engine = test_cube::engine(gel.with_loads(loads));
            assert!(swept_in_part(engine, 50) > 10, "blocks are swept in part");
        }
    }
}
