//! The fast form of the elements: runs of a thousand slots that number their own nodes.
//!
//! A block is swept with its nodes in the nearest cache; what it gives to a node it leaves in its own part, and the node
//! gathers from the blocks around it in their order. So no thread writes where another one reads, and no bit depends on
//! who came first.

use super::assembly::{NODE_BATCH, TileOverlap};
use super::element_order::Order;
use super::energy_residual::StepResidual;
use super::node_loop::RUN;
use super::partial_block::GroupStar;
use super::pool::PerThread;
use super::step_size::RAISE_MARGIN;
use super::{Gel, TickGrid};
use crate::fem::{Accumulated, Lanes, Local, MAX_NODES, Potential, Recall, Spent, rounding};
use crate::mesh::{ElementId, NodeId};
use crate::state::{Clock, Tick};
use fearless_simd::Level;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Slots of a block: with 1024 tetrahedra, some 400 nodes and what is accumulated at them take 40 kB of cache, and a node is in two
/// blocks; of a quarter of that it would be in half as many again.
pub(super) const SLOTS: usize = 1024;

/// Nodes above which what belongs to them is in no cache that is near: it is asked for before it is needed then. With 175 000 nodes (a
/// million tetrahedra) that takes some 6 % off a step; with 32 000 nobody waits for it, and to ask takes 4 %. Nothing between was measured.
const CACHED_NODES: usize = 1 << 16;

/// Whether what belongs to so many nodes comes from far.
pub(super) fn exceed_cache(n_nodes: usize) -> bool {
    n_nodes > CACHED_NODES
}

/// How much of a block fires at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Due {
    /// Nothing.
    #[default]
    Nothing,
    /// Some groups.
    Some,
    /// All groups.
    All,
}

/// What is known of the part of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum SweepCache {
    /// Nothing.
    #[default]
    Empty,
    /// Σ κ, and what the last sweep gave.
    Swept,
    /// The same, and that it is that of a full sweep at rest.
    AtRest,
}

/// A run of slots.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// Its nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// Where its part begins.
    pub first: usize,
    /// Elements in it.
    pub n_elements: u64,
    /// Least and greatest step of its groups, ticks.
    pub steps: (Tick, Tick),
    /// The steps of its groups, ticks: the bits of all of them, one each in bins.
    pub lengths: Tick,
    /// How much of it fires at this tick, and how many elements.
    pub due: Due,
    pub n_active_elements: u64,
    /// What is around the groups that fire where some do, by the longest step of these.
    pub active_stars: BTreeMap<Tick, GroupStar>,
    /// The longest step of a group that fires at this tick, where some do, ticks.
    pub longest_active: Tick,
    /// What is known of its part.
    pub cache: SweepCache,
    /// Whether some node of it has moved or moves.
    pub awake: AtomicBool,
    /// Whether a node of it was active at this tick through another block.
    pub looked_at: bool,
    /// Whether a group of it may raise its step.
    pub restless: bool,
    /// Whether its elements remember what the state does not know yet.
    pub has_unsaved_history: bool,
    /// What a sweep at this tick found, if it was swept.
    pub report: Option<BlockReport>,
    /// What its groups that fired at its last sweep store, and what they have lost since the tick before of each.
    pub spent: Spent,
    /// What its groups that fire came to then.
    pub step_residual: StepResidual,
    /// The group whose answer holds the power of all that have not told theirs, if they were found in one sum.
    pub power_accumulator: Option<usize>,
}

/// What a sweep of a block finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BlockReport {
    /// Elements evaluated that are not all at rest.
    pub updates: u64,
    /// Least J.
    pub least_jacobian: f64,
    /// Whether an element of a group that fires is turned over within its step.
    pub closes: bool,
    /// The first group that has an element inverted for the second tick in a row, or an energy that is no number.
    pub failed_group: Option<usize>,
}

impl Default for BlockReport {
    fn default() -> Self {
        Self { updates: 0, least_jacobian: 1.0, closes: false, failed_group: None }
    }
}

/// Where a node is: which block, and where what that gives it stands among all parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeCopy {
    pub block: u32,
    pub at: u32,
}

/// What the nodes of a block look up and leave at a tick.
#[derive(Debug, Default)]
pub(super) struct Front {
    /// Whether what the block gives to them is in its part.
    pub gives: bool,
    /// From which limit on and below which one the steps of the block stay as they are, s, whichever node has it.
    hold_range: (f64, f64),
    /// The same of each node, no less; none where all groups are of one step and no limit was outside yet.
    node_hold_ranges: Vec<(f64, f64)>,
    /// Whether a node has found another one.
    is_check_requested: AtomicBool,
}

/// In which block, from 1, a node was met last, and its number there.
#[derive(Debug, Clone, Copy, Default)]
struct VisitMark {
    block: u32,
    number: u16,
}

/// All blocks.
#[derive(Debug)]
pub(super) struct Blocks<const D: usize> {
    pub all: Vec<Block>,
    /// What the last sweep of each block gave to its nodes, and Σ κ of all its elements there.
    pub parts: Vec<Accumulated>,
    /// One of each block.
    pub fronts: Vec<Front>,
    pub lanes: Lanes<D>,
    /// What the elements remember, batch by batch; what the state holds of it is older while ticks are processed.
    pub memory: Vec<Recall>,
    /// Memories of an element there.
    pub memories: usize,
    /// κ that the last sweep found of the element behind each loaded facet, N/m, without what pressures add to it.
    pub unloaded: Vec<f64>,
    /// Groups of a block, and in all.
    pub groups: usize,
    n_groups: usize,
    start: Vec<u32>,
    spots: Vec<NodeCopy>,
    /// What blocks have in common with each stretch of nodes.
    pub overlaps: Vec<Vec<TileOverlap>>,
    /// What a sweep works with.
    pub locals: PerThread<Local>,
    /// To what positions are rounded, m.
    pub still: f64,
    pub level: Level,
    /// Whether also what is at rest is swept.
    pub never_rest: bool,
    /// Whether a node that stands where it rests can be pulled all the same: where the elements of a later mesh remember.
    pub is_prestrained: bool,
}

impl<const D: usize> Blocks<D> {
    /// The blocks of a potential that has lanes.
    pub fn new<P: Potential<D>>(gel: &Gel<D, P>, order: &Order) -> Option<Self> {
        let slots: Vec<Option<ElementId>> = (0..order.n_slots()).map(|slot| order.element(slot)).collect();
        let mut local = vec![[0; MAX_NODES]; slots.len()];
        let runs = slots.chunks(SLOTS).zip(local.chunks_mut(SLOTS));
        let mut marks = vec![VisitMark::default(); gel.mass.len()];
        let mut blocks: Vec<Block> =
            runs.zip(1..).map(|((slots, local), block)| Block::new(gel, slots, local, block, &mut marks)).collect();
        let mut n_parts = 0;
        for block in &mut blocks {
            block.first = n_parts;
            n_parts += block.nodes.len();
        }
        let lanes = gel.potential.lanes(&slots, order.depth(), &local)?;
        let n_nodes = gel.mass.len();
        let mut start = vec![0; n_nodes + 1];
        for node in blocks.iter().flat_map(|block| &block.nodes) {
            start[node.index() + 1] += 1;
        }
        for i in 0..n_nodes {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut spots = vec![NodeCopy { block: 0, at: 0 }; n_parts];
        for (i, block) in blocks.iter().enumerate() {
            for (number, node) in block.nodes.iter().enumerate() {
                let at = &mut fill[node.index()];
                spots[*at as usize] = NodeCopy { block: i as u32, at: (block.first + number) as u32 };
                *at += 1;
            }
        }
        let overlaps = TileOverlap::find_all(&blocks, n_nodes);
        let still = rounding(gel.potential.rest());
        let (groups, n_groups, locals) = (SLOTS / order.width(), order.n_groups(), PerThread::new(Local::new(still)));
        let fronts = blocks.iter().map(|_| Front::default()).collect();
        let parts = vec![[0.0; 4]; n_parts];
        let memory = lanes.memory();
        Some(Self {
            all: blocks,
            parts,
            fronts,
            lanes,
            memory,
            memories: gel.potential.memories(),
            unloaded: vec![f64::NAN; gel.loads.facets.len()],
            groups,
            n_groups,
            start,
            spots,
            overlaps,
            still,
            locals,
            level: Level::new(),
            never_rest: false,
            is_prestrained: false,
        })
    }

    /// Where a node is, in the order of the blocks.
    #[inline]
    pub fn spots(&self, node: usize) -> &[NodeCopy] {
        &self.spots[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// Whether a node is one of what fires.
    pub fn fires(&self, node: usize) -> bool {
        self.spots(node).iter().any(|spot| {
            let block = &self.all[spot.block as usize];
            let number = || (spot.at as usize - block.first) as u16;
            match block.due {
                Due::Nothing => false,
                Due::Some => block.active_star().nodes.binary_search(&number()).is_ok(),
                Due::All => true,
            }
        })
    }

    /// Nodes of all blocks.
    pub fn n_nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// The groups of a block.
    pub fn groups_of(&self, block: usize) -> Range<usize> {
        group_range(block, self.groups, self.n_groups)
    }

    /// Takes the steps of its groups into a block: within which limits a node of them leaves them as they are.
    pub fn update_steps(&mut self, block: usize, clocks: &[Clock], grid: TickGrid) {
        let groups = self.groups_of(block);
        let steps = clocks[groups.clone()].iter().map(|clock| clock.step);
        let (least, most) = steps.clone().fold((Tick::MAX, 0), |(least, most), step| (least.min(step), most.max(step)));
        let (all, front) = (&mut self.all[block], &mut self.fronts[block]);
        all.steps = (least, most);
        all.lengths = steps.fold(0, |all, step| all | step);
        all.active_stars.clear();
        front.hold_range = (grid.time(most), RAISE_MARGIN * grid.time(least));
        front.node_hold_ranges.clear();
        if least < most {
            front.watch((all.nodes.len(), groups, &self.lanes), (clocks, grid), &[]);
        }
    }

    /// Σ p, N·s, and Σ κ, N/m, that the blocks give to these nodes, in their order.
    pub fn sum_parts(&self, nodes: &[usize]) -> [Accumulated; NODE_BATCH] {
        let mut parts = [[0.0; 4]; NODE_BATCH];
        for (node, sum) in nodes.iter().zip(&mut parts) {
            for spot in self.spots(*node) {
                let part = &self.parts[spot.at as usize];
                let from = if self.fronts[spot.block as usize].gives { 0 } else { 3 };
                (from..4).for_each(|i| sum[i] += part[i]);
            }
        }
        parts
    }

    /// The blocks around a node that moves must be swept from now on.
    pub fn activate_around(&self, node: usize) {
        for spot in self.spots(node) {
            self.activate(spot.block as usize);
        }
    }

    /// The steps around a node must be looked at as soon as they end.
    pub fn stir(&mut self, node: usize) {
        for at in self.start[node]..self.start[node + 1] {
            self.all[self.spots[at as usize].block as usize].restless = true;
        }
    }

    /// A block must be swept from now on.
    pub fn activate(&self, block: usize) {
        let awake = &self.all[block].awake;
        // Threads share what is written: not again and again.
        if !awake.load(Ordering::Relaxed) {
            awake.store(true, Ordering::Relaxed);
        }
    }

    /// All steps, who moves, and nothing known of what blocks give.
    pub fn reset(&mut self, clocks: &[Clock], grid: TickGrid, moves: impl Fn(usize) -> bool) {
        let strained = self.is_prestrained;
        for i in 0..self.all.len() {
            self.update_steps(i, clocks, grid);
            let block = &mut self.all[i];
            block.cache = SweepCache::Empty;
            block.restless = true;
            *block.awake.get_mut() = strained || block.nodes.iter().any(|node| moves(node.index()));
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |block: &Block| {
            let own = 4 * block.nodes.capacity();
            size_of::<Block>() + own + block.active_stars.values().map(GroupStar::bytes).sum::<usize>()
        };
        let fronts =
            self.fronts.iter().map(|front| size_of::<Front>() + 16 * front.node_hold_ranges.capacity()).sum::<usize>();
        let parts = size_of::<Accumulated>() * self.parts.len() + fronts;
        self.lanes.bytes()
            + size_of_val(self.memory.as_slice())
            + parts
            + self.all.iter().map(of).sum::<usize>()
            + 4 * self.start.len()
            + 8 * self.spots.len()
            + self.overlaps.iter().map(|overlaps| size_of_val(overlaps.as_slice())).sum::<usize>()
    }
}

/// The groups of a block, of so many to a block and in all.
pub(super) fn group_range(block: usize, groups: usize, all: usize) -> Range<usize> {
    block * groups..all.min((block + 1) * groups)
}

impl Front {
    /// Finds within which limits each of so many nodes leaves the steps of these groups as they are, s, of limits that are known, s,
    /// or infinite. A limit below a step shortens it, whichever node has it. No step is raised as long as one node of the group has a
    /// limit below [`RAISE_MARGIN`] steps: of those known the least is watched for it, and the others need not be; if there is none,
    /// all are.
    pub fn watch<const D: usize>(
        &mut self,
        (n_nodes, groups, lanes): (usize, Range<usize>, &Lanes<D>),
        (clocks, grid): (&[Clock], TickGrid),
        limits: &[f64],
    ) {
        self.node_hold_ranges.clear();
        self.node_hold_ranges.resize(n_nodes, (0.0, f64::INFINITY));
        for group in groups {
            let step = grid.time(clocks[group].step);
            let (mut least, raised) = ((f64::INFINITY, 0), RAISE_MARGIN * step);
            lanes.nodes(group, |number| {
                let number = usize::from(number);
                self.node_hold_ranges[number].0 = self.node_hold_ranges[number].0.max(step);
                let limit = limits.get(number).copied().unwrap_or(f64::INFINITY);
                least = if limit < least.0 { (limit, number) } else { least };
            });
            let mut bound =
                |number: usize| self.node_hold_ranges[number].1 = self.node_hold_ranges[number].1.min(raised);
            if least.0 < raised { bound(least.1) } else { lanes.nodes(group, |number| bound(usize::from(number))) }
        }
    }

    /// At the start of the node phase of a tick.
    pub fn prepare(&mut self, block: &Block) {
        self.gives = block.contributes();
        *self.is_check_requested.get_mut() = !block.may_hold_steps();
    }

    /// Whether limits between these, s, leave all steps as they are, whichever nodes have them.
    #[inline]
    pub fn holds_for_all(&self, least: f64, most: f64) -> bool {
        self.hold_range.0 <= least && most < self.hold_range.1
    }

    /// Whether this limit, s, of a node, by its number within the block, does.
    #[inline]
    pub fn holds_at(&self, number: usize, limit: f64) -> bool {
        // What no node of the block finds anything in needs no look at its own.
        self.holds_for_all(limit, limit)
            || self.node_hold_ranges.get(number).is_some_and(|own| own.0 <= limit && limit < own.1)
    }

    /// A node has found another one.
    pub fn request_check(&self) {
        self.is_check_requested.store(true, Ordering::Relaxed);
    }

    /// Whether no limit may change a step.
    pub fn is_calm(&mut self) -> bool {
        !*self.is_check_requested.get_mut()
    }
}

impl Block {
    fn new<const D: usize, P: Potential<D>>(
        gel: &Gel<D, P>,
        slots: &[Option<ElementId>],
        local: &mut [[u16; MAX_NODES]],
        block: u32,
        marks: &mut [VisitMark],
    ) -> Self {
        let elements = || slots.iter().flatten();
        let mut nodes: Vec<NodeId> = vec![];
        for node in elements().flat_map(|element| gel.potential.nodes(*element)) {
            if std::mem::replace(&mut marks[node.index()].block, block) != block {
                nodes.push(*node);
            }
        }
        nodes.sort_unstable();
        nodes.shrink_to_fit();
        nodes.iter().zip(0..).for_each(|(node, number)| marks[node.index()].number = number);
        for (slot, local) in slots.iter().zip(local) {
            let own = slot.map(|element| gel.potential.nodes(element)).unwrap_or_default();
            for (local, node) in local.iter_mut().zip(own) {
                *local = marks[node.index()].number;
            }
        }
        let n_elements = elements().count() as u64;
        Self { n_elements, awake: AtomicBool::new(true), restless: true, nodes, ..Self::default() }
    }

    /// The runs in which its nodes are.
    pub fn runs(&self) -> Vec<u32> {
        let mut runs: Vec<u32> = self.nodes.iter().map(|node| (node.index() / RUN) as u32).collect();
        runs.dedup();
        runs
    }

    /// Whether some node of it has moved or moves.
    pub fn is_awake(&self) -> bool {
        self.awake.load(Ordering::Relaxed)
    }

    /// Whether it must be swept at this tick: at rest, what it would answer is known once it was swept so as a whole.
    pub fn needs_sweep(&self) -> bool {
        self.due != Due::Nothing && (self.is_awake() || self.cache != SweepCache::AtRest)
    }

    /// Its elements that must be swept at this tick.
    pub fn elements_to_sweep(&self) -> u64 {
        if self.needs_sweep() { self.n_active_elements } else { 0 }
    }

    /// Whether what it gives to its nodes at this tick is in its part.
    pub fn contributes(&self) -> bool {
        self.due != Due::Nothing && self.is_awake()
    }

    /// Whether all its steps stay as they are unless a node finds a limit that changes one: all have begun, and none is about to
    /// be raised.
    fn may_hold_steps(&self) -> bool {
        self.contributes() && !self.restless && self.steps.0 > 0
    }

    /// What is around the groups that fire, where some do.
    ///
    /// # Panics
    /// Where none or all do, or before what fires is found out and swept.
    pub fn active_star(&self) -> &GroupStar {
        let around = self.active_stars.get(&self.longest_active).expect("it is found out first what fires");
        debug_assert!(!around.nodes.is_empty(), "a sweep comes before what is around");
        around
    }

    /// The numbers of its nodes that fire.
    pub fn active(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.due == Due::All { 0..self.nodes.len() } else { 0..0 };
        let some = if self.due == Due::Some { self.active_star().nodes.as_slice() } else { &[] };
        all.chain(some.iter().map(|number| usize::from(*number)))
    }
}
