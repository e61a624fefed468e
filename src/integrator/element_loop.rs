//! The element phase: what fires, and one pure pass over it from positions to forces, shared among threads.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::blocks::{Block, Blocks, Due, Known, Report, SLOTS, are_far, groups_of};
use super::element_order::Order;
use super::partial_block::Around;
use super::pool::{Cut, share};
use super::substep::{Moment, Phase};
use super::{Pool, TickGrid};
use crate::fem::{Accumulated, At, GroupAnswer, Kick, Kicks, LANES, Lanes, Local, Power, Recall, Whereabouts};
use crate::math::Vector;
use crate::mesh::NodeId;
use crate::state::{Clock, Tick};
use fearless_simd::Level;
use prefetch_index::prefetch_index;
use std::sync::atomic::Ordering;

/// What a sweep reads.
#[derive(Clone, Copy)]
pub(super) struct Sweep<'a, const D: usize> {
    pub moment: Moment,
    pub grid: TickGrid,
    pub position: &'a [Vector<D>],
    pub velocity: &'a [Vector<D>],
    pub rest: &'a [Vector<D>],
    /// Last tick of each node.
    pub last: &'a [Tick],
    pub clocks: &'a [Clock],
    pub order: &'a Order,
}

/// What a sweep writes, from some block on.
struct Found<'a> {
    first: usize,
    blocks: &'a mut [Block],
    parts: &'a mut [Accumulated],
    stiffness: &'a mut [f64],
    answers: &'a mut [GroupAnswer],
    memory: &'a mut [Recall],
    /// Groups of a block, and numbers that its elements remember, in rows of eight.
    groups: usize,
    rows: usize,
}

impl Cut for Found<'_> {
    /// By the elements of the blocks that fire.
    fn cut(self, part: usize, of: usize) -> (Self, Self) {
        let Self { first, blocks, parts, stiffness, answers, memory, groups, rows } = self;
        let middle = split(blocks, part as f64 / of as f64);
        let (blocks, more_blocks) = blocks.split_at_mut(middle);
        let (parts, more_parts) = parts.split_at_mut(blocks.iter().map(|block| block.nodes.len()).sum());
        let (stiffness, more_stiffness) = stiffness.split_at_mut(stiffness.len().min(middle * SLOTS));
        let (answers, more_answers) = answers.split_at_mut(answers.len().min(middle * groups));
        let (memory, more_memory) = memory.split_at_mut(memory.len().min(middle * rows));
        let own = Self { first, blocks, parts, stiffness, answers, memory, groups, rows };
        let (first, blocks, parts, stiffness) = (first + middle, more_blocks, more_parts, more_stiffness);
        let (answers, memory) = (more_answers, more_memory);
        (own, Self { first, blocks, parts, stiffness, answers, memory, groups, rows })
    }
}

/// Batches of a block.
const BATCHES: usize = SLOTS / LANES;

/// Elements below which a tick is not shared: some 100 µs of work. The ticks of what contact steps more often, a tenth of
/// `sphere-block` in cells of 2.4 mm, are above it.
pub(super) const SHARED: u64 = 4_096;

impl<const D: usize> Blocks<D> {
    /// Finds out what fires; the number of elements that must be swept.
    pub fn find_due(&mut self, sweep: &Sweep<'_, D>) -> u64 {
        for (i, block) in self.all.iter_mut().enumerate() {
            block.find_due(sweep, groups_of(i, self.groups, sweep.clocks.len()));
        }
        self.all.iter().map(Block::wanted).sum()
    }

    /// Sweeps all that is due and awake.
    pub fn sweep(
        &mut self,
        sweep: &Sweep<'_, D>,
        (stiffness, answers): (&mut [f64], &mut [GroupAnswer]),
        (pool, elements): (Option<&Pool>, u64),
    ) {
        if self.never_rest {
            let at_rest = self.all.iter_mut().filter(|block| block.known == Known::Rest);
            at_rest.for_each(|block| block.known = Known::Sums);
        }
        let (pool, still) = (pool.filter(|_| elements > SHARED), self.still);
        if let Some(pool) = pool {
            self.locals.provide(pool, || Local::new(still));
        }
        let (with, locals) = ((&self.lanes, self.level, self.strained), &self.locals);
        let (most, blocks, parts) = (self.all.len(), self.all.as_mut_slice(), self.parts.as_mut_slice());
        let (memory, groups, rows) = (self.memory.as_mut_slice(), self.groups, BATCHES * self.lanes.rows());
        let all = Found { first: 0, blocks, parts, stiffness, answers, memory, groups, rows };
        share((pool, most), all, |found| {
            let (mut parts, mut memory, mut local) = (found.parts, found.memory, locals.own());
            let found_of = found.stiffness.chunks_mut(SLOTS).zip(found.answers.chunks_mut(found.groups));
            for (i, (block, (stiffness, answers))) in found.blocks.iter_mut().zip(found_of).enumerate() {
                let (part, more) = parts.split_at_mut(block.nodes.len());
                parts = more;
                let (own, more) = memory.split_at_mut(memory.len().min(rows));
                memory = more;
                let at = groups_of(found.first + i, found.groups, sweep.clocks.len());
                block.sweep(sweep, with, (at, (part, stiffness, answers, own)), &mut local);
            }
        });
    }
}

/// What a block writes: its part, κ by slot, the answers of its groups, what its elements remember.
type Given<'a> = (&'a mut [Accumulated], &'a mut [f64], &'a mut [GroupAnswer], &'a mut [Recall]);
/// Elements, the vector units for them, and whether what stands at rest can be pulled.
type With<'a, const D: usize> = (&'a Lanes<D>, Level, bool);

/// The number of blocks that have about this part of the work that is due.
pub(super) fn split(blocks: &[Block], part: f64) -> usize {
    let wanted = blocks.iter().map(Block::wanted).sum::<u64>() as f64 * part;
    let mut so_far = 0;
    let reached = |block: &Block| {
        so_far += block.wanted();
        so_far as f64 >= wanted
    };
    blocks.iter().position(reached).map_or(blocks.len(), |at| at + 1)
}

/// The longest of these steps that fires at a tick, if the least does: each is a power of two, and one bit of `lengths`.
fn longest(lengths: Tick, tick: Tick) -> Tick {
    // The lowest bit of the tick and those below it.
    let fires = lengths & (tick ^ (tick - 1));
    1 << fires.ilog2()
}

impl Block {
    fn find_due<const D: usize>(&mut self, sweep: &Sweep<'_, D>, groups: std::ops::Range<usize>) {
        self.looked_at = false;
        let fires = |step: Tick| sweep.moment.fires(step);
        self.due = match (fires(self.steps.0), fires(self.steps.1)) {
            (false, _) => Due::Nothing,
            (true, true) => Due::All,
            (true, false) => Due::Some,
        };
        self.n_due = if self.due == Due::All { self.n_elements } else { 0 };
        if self.due == Due::Some {
            let due = groups.filter(|group| fires(sweep.clocks[*group].step));
            self.longest = longest(self.lengths, sweep.moment.tick);
            let around = self.firing.entry(self.longest).or_insert_with(|| Around::of(sweep.order, due));
            self.n_due = around.n_elements;
        }
    }

    /// Finds what is around the groups that fire where some do, unless it is known from an earlier tick.
    fn find_around<const D: usize>(&mut self, lanes: &Lanes<D>, groups: std::ops::Range<usize>) {
        if let Some(around) = self.firing.get_mut(&self.longest).filter(|around| around.nodes.is_empty()) {
            around.find(lanes, groups);
        }
    }

    /// The groups that fire, of all of the block.
    fn firing(&self, all: std::ops::Range<usize>) -> impl Iterator<Item = usize> + '_ {
        let all = if self.due == Due::All { all } else { 0..0 };
        let some = if self.due == Due::Some { self.around().groups.as_slice() } else { &[] };
        all.chain(some.iter().map(|group| *group as usize))
    }

    /// Loads the nodes as they are at this tick, and sweeps unless all are at rest and were swept so before.
    fn sweep<const D: usize>(
        &mut self,
        sweep: &Sweep<'_, D>,
        (lanes, level, strained): With<'_, D>,
        (groups, (part, stiffness, answers, memory)): (std::ops::Range<usize>, Given<'_>),
        local: &mut Local,
    ) {
        (self.report, self.holder) = (None, None);
        if self.due == Due::Some {
            self.find_around(lanes, groups.clone());
        }
        if !self.is_wanted() {
            if self.known == Known::Nothing {
                lanes.sum_stiffness(groups, stiffness, part);
                self.known = Known::Sums;
            }
            return;
        }
        let moves = self.load(sweep, level, local);
        // Of a block that fires in part the other nodes may move.
        let moves = moves || strained || (self.due == Due::Some && self.is_awake());
        self.awake.store(moves, Ordering::Relaxed);
        if !moves && self.known == Known::Rest {
            return;
        }
        let kick = |group: usize| sweep.kick(sweep.clocks[group].step);
        self.is_ahead |= !memory.is_empty();
        let steady = self.steady(&sweep.moment);
        let power = if steady.is_some() { Power::Untold } else { Power::Told };
        let same = steady.and_then(|step| sweep.kick(step));
        let kicks = same.map_or(Kicks::Each(&kick), Kicks::Same);
        lanes.sweep(level, (groups.clone(), kicks, power), local, (&mut *stiffness, &mut *answers, memory));
        self.spent = local.spent();
        if let Some(step) = steady {
            answers[0].power = local.work(self.nodes.len()) / sweep.grid.time(step);
        }
        let given = local.accumulated(self.nodes.len());
        if self.due == Due::All {
            part.copy_from_slice(given);
        } else {
            self.put_some(given, stiffness, part);
            if self.known == Known::Nothing {
                lanes.sum_stiffness(groups.clone(), stiffness, part);
            }
        }
        self.known = if !moves && self.due == Due::All { Known::Rest } else { Known::Sums };
        self.inspect(sweep, (groups.clone(), answers), moves);
        self.holder = steady.map(|_| groups.start);
    }

    /// Puts what a sweep of some groups gave into the part, where nothing comes from the others but their κ.
    fn put_some(&self, given: &[Accumulated], stiffness: &[f64], part: &mut [Accumulated]) {
        let Around { nodes, slots, ends, .. } = self.around();
        for part in part.iter_mut() {
            part[..3].fill(0.0);
        }
        let mut first = 0;
        for (number, end) in nodes.iter().zip(ends) {
            let all = &slots[first..usize::from(*end)];
            let sum = all.iter().fold(0.0, |sum, slot| sum + stiffness[usize::from(*slot)]);
            let [x, y, z, _] = given[usize::from(*number)];
            part[usize::from(*number)] = [x, y, z, sum];
            first = usize::from(*end);
        }
    }

    /// The step of all its groups, ticks, if they fire together after one that was whole: then the powers of all are found at the
    /// nodes, in one sum.
    fn steady(&self, moment: &Moment) -> Option<Tick> {
        let (least, most) = self.steps;
        let whole = moment.phase == Phase::Between && most > 0 && moment.behind(most) == most;
        (self.due == Due::All && least == most && whole).then_some(most)
    }

    /// Whether a node has moved or moves.
    fn load<const D: usize>(&self, sweep: &Sweep<'_, D>, level: Level, local: &mut Local) -> bool {
        local.begin();
        let nodes = self.nodes.as_slice();
        if self.due == Due::All {
            return local.load(level, sweep, nodes.iter().copied().enumerate());
        }
        let some = self.around().nodes.iter().map(|number| usize::from(*number));
        local.load(level, sweep, some.map(|number| (number, nodes[number])))
    }

    /// Notes what the groups that fire answered.
    fn inspect<const D: usize>(
        &mut self,
        sweep: &Sweep<'_, D>,
        (groups, answers): (std::ops::Range<usize>, &[GroupAnswer]),
        moves: bool,
    ) {
        let updates = if moves { self.wanted() } else { 0 };
        let mut report = Report { updates, ..Report::default() };
        // Clocks are not read where nobody need: they come from far.
        for group in self.firing(groups.clone()) {
            let answer = &answers[group - groups.start];
            report.least_jacobian = report.least_jacobian.min(answer.least_jacobian);
            report.closes |= answer.closing > 0.0 && closes(answer, sweep.grid.time(sweep.clocks[group].step));
            if report.failed.is_none() && fails(&sweep.clocks[group], answer) {
                report.failed = Some(group);
            }
        }
        self.report = Some(report);
    }
}

/// Whether an element of a group would be turned over within a step, s.
pub(super) fn closes(answer: &GroupAnswer, step: f64) -> bool {
    answer.closing * step > 1.0
}

/// Whether an answer ends the run: an element inverted for the second tick in a row, or an energy that is no number.
pub(super) fn fails(clock: &Clock, answer: &GroupAnswer) -> bool {
    is_suspect(answer) && (!answer.energy.is_finite() || answer.inverted & clock.inverted != 0)
}

/// Whether an answer may end the run, whatever was before.
fn is_suspect(answer: &GroupAnswer) -> bool {
    !answer.energy.is_finite() || answer.inverted != 0
}

impl<const D: usize> Sweep<'_, D> {
    /// The kick of a group that fires; of no length at the start, when no step is known yet.
    #[inline(always)]
    fn kick(&self, step: Tick) -> Option<Kick> {
        let kick = || Kick {
            length: self.grid.length(self.moment.taken(step)),
            elapsed: self.grid.time(self.moment.elapsed(step)),
        };
        self.moment.fires(step).then(kick)
    }
}

impl<const D: usize> Whereabouts<D> for Sweep<'_, D> {
    #[inline(always)]
    fn of(&self, node: NodeId) -> At<'_, D> {
        let a = node.index();
        let passed = self.grid.time(self.moment.tick - self.last[a]);
        At { position: &self.position[a], velocity: &self.velocity[a], rest: &self.rest[a], passed }
    }

    #[inline(always)]
    fn fetch(&self, node: NodeId) {
        if are_far(self.position.len()) {
            prefetch_index(self.position, node.index());
            prefetch_index(self.velocity, node.index());
            prefetch_index(self.rest, node.index());
            prefetch_index(self.last, node.index());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_cube;
    use super::super::{Engine, Gel, Loaded, Loads, Pressure};
    use super::*;
    use crate::contact::Exchange;
    use crate::fem::{Section, Simplices};
    use crate::mesh::{ElementId, Facet, graded};

    #[test]
    fn what_fires_in_part_is_shared_with_the_same_bits() {
        let mesh = test_cube::mesh(&graded(1.0, 0.025, (0.3, 1.3, 0.2)));
        let run = |threads| {
            let mut engine = test_cube::engine(test_cube::gel(&mesh)).with_pool(Pool::new(threads));
            let (mut in_part, mut tick) = (0, 0);
            for _ in 0..32 {
                engine.advance_to(engine.grid.time(tick), &mut [Exchange::default()]).expect("the gel only swings");
                tick += engine.steps.0;
                let all = &engine.blocks.as_ref().expect("bins have the fast form").all;
                let some = all.iter().any(|block| block.due == Due::Some);
                in_part += usize::from(some && all.iter().map(Block::wanted).sum::<u64>() > SHARED);
            }
            (engine.state.position, engine.state.velocity, in_part)
        };
        let one = run(1);
        assert!(one.2 > 4, "{} ticks of what fires in part are shared", one.2);
        assert!(run(3) == one && run(2) == one);
    }

    #[test]
    fn the_longest_step_that_fires_is_one_that_there_is() {
        let lengths = 1 | 16 | 256;
        let found = [1, 8, 16, 48, 128, 256, 512, 768].map(|tick| longest(lengths, tick));
        assert_eq!(found, [1, 1, 16, 16, 16, 256, 256, 256]);
    }

    /// A pressure on every facet.
    fn loads(gel: &Gel<3, Simplices<3>>) -> Loads {
        let of = |(facet, behind): (&Facet, &ElementId)| Loaded { facet: *facet, behind: *behind, mark: 1 };
        let facets = gel.surface.facets.iter().zip(&gel.behind).map(of).collect();
        Loads { section: Section::Spatial, pressures: vec![Pressure::new(vec![(0.0, 0.0), (1e-3, 50.0)])], facets }
    }

    /// How many times a block was found to be swept in part after one of so many communication steps; after each, every part has κ as
    /// all elements of its block have it.
    fn swept_in_part(mut engine: Engine<3, Simplices<3>>, steps: u32) -> usize {
        let (mut in_part, mut seen) = (0, None);
        for step in 1..=steps {
            engine.advance_to(f64::from(step) * 2e-5, &mut [Exchange::default()]).expect("the gel only swings");
            if std::mem::replace(&mut seen, engine.state.now) == engine.state.now {
                continue;
            }
            let blocks = engine.blocks.as_ref().expect("bins have the fast form");
            for (i, block) in blocks.all.iter().enumerate() {
                let part = &blocks.parts[block.first..][..block.nodes.len()];
                let mut whole = part.to_vec();
                blocks.lanes.sum_stiffness(blocks.groups_of(i), &engine.state.stiffness[i * SLOTS..], &mut whole);
                assert!(part.iter().zip(&whole).all(|(part, whole)| part[3] == whole[3]), "block {i} at step {step}");
                in_part += usize::from(block.due == Due::Some && block.report.is_some());
            }
        }
        in_part
    }

    #[test]
    fn a_block_that_fires_in_part_has_the_stiffness_of_all_its_elements() {
        let mesh = test_cube::mixed();
        for is_loaded in [false, true] {
            let gel = test_cube::gel(&mesh);
            let loads = if is_loaded { loads(&gel) } else { Loads::none() };
            let engine = test_cube::engine(gel.with_loads(loads));
            assert!(swept_in_part(engine, 50) > 10, "blocks are swept in part");
        }
    }
}
