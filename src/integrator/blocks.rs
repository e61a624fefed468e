//! Blocks of elements for the SIMD form: 1024 slots each, with local node numbers.
//!
//! A block is swept with its nodes in the nearest cache. It writes its contributions to its own part, and each node
//! sums the parts of the blocks around it in their order. No thread writes where another one reads, and no bit
//! depends on the order of threads.

use super::assembly::{NODE_BATCH, TileOverlap};
use super::element_order::ElementLayout;
use super::energy_residual::StepResidual;
use super::node_loop::RUN;
use super::partial_block::GroupStar;
use super::pool::PerThread;
use super::step_size::RAISE_MARGIN;
use super::{DiscreteGel, TickGrid};
use crate::fem::{Dissipation, ElementBatches, HistoryLanes, MAX_NODES, NodeAccumulator, NodeCache};
use crate::fem::{Potential, rounding};
use crate::mesh::{ElementId, NodeId};
use crate::state::{GroupClock, Tick};
use fearless_simd::Level;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Slots of a block: some 400 nodes and their sums take 40 kB of cache, and a node is in two blocks.
pub(super) const SLOTS: usize = 1024;

/// Number of nodes above which nodal data exceed the near caches and are prefetched: it saves 6 % of a step with 175 000 nodes
/// and costs 4 % with 32 000.
const CACHED_NODES: usize = 1 << 16;

/// Returns true if the data of this many nodes exceed the near caches.
pub(super) fn exceed_cache(n_nodes: usize) -> bool {
    n_nodes > CACHED_NODES
}

/// Activity of a block at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum BlockActivity {
    /// No group is active.
    #[default]
    Nothing,
    /// Some groups are active.
    Some,
    /// All groups are active.
    All,
}

/// Validity of the stored part of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum SweepCache {
    /// The part is not computed yet.
    #[default]
    Empty,
    /// The part has Σ κ of all elements and the impulses of the last sweep.
    Swept,
    /// The part is that of a full sweep at rest.
    AtRest,
}

/// Block of slots with local node numbers.
#[derive(Debug, Default)]
pub(super) struct ElementBlock {
    /// Nodes in ascending order; the index is the local number.
    pub nodes: Vec<NodeId>,
    /// Index of the first entry of its part.
    pub first: usize,
    /// Number of elements.
    pub n_elements: u64,
    /// Least and greatest step of its groups, ticks.
    pub steps: (Tick, Tick),
    /// Bitwise union of the steps of its groups, ticks: with bins each step is one bit.
    pub lengths: Tick,
    /// Activity at this tick, and the number of elements of the active groups.
    pub due: BlockActivity,
    pub n_active_elements: u64,
    /// Node stars of the active groups where some are active, keyed by the longest active step.
    pub active_stars: BTreeMap<Tick, GroupStar>,
    /// Longest step of an active group where some are active, ticks.
    pub longest_active: Tick,
    /// Validity of its part.
    pub cache: SweepCache,
    /// True if a node of the block has moved or moves.
    pub awake: AtomicBool,
    /// True if a node of the block was active at this tick through another block.
    pub looked_at: bool,
    /// True if a group of the block may raise its step.
    pub restless: bool,
    /// True if history variables in the block are newer than those of the state.
    pub has_unsaved_history: bool,
    /// Report of the sweep at this tick; `None` if the block was not swept.
    pub report: Option<BlockReport>,
    /// Energy stored by the groups active at the last sweep, and their dissipation since the previous tick of each.
    pub spent: Dissipation,
    /// Energy residual of the groups active at the last sweep.
    pub step_residual: StepResidual,
    /// Group whose response accumulates the power of all groups without their own power; `None` if each has its own.
    pub power_accumulator: Option<usize>,
}

/// Report of the sweep of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BlockReport {
    /// Number of elements evaluated that are not all at rest.
    pub updates: u64,
    /// Least J.
    pub least_jacobian: f64,
    /// True if an element of an active group inverts within its step.
    pub closes: bool,
    /// First group with an element inverted for the second tick in a row, or with an energy that is not a number.
    pub failed_group: Option<usize>,
}

impl Default for BlockReport {
    fn default() -> Self {
        Self { updates: 0, least_jacobian: 1.0, closes: false, failed_group: None }
    }
}

/// Copy of a shared node in a block: the block, and the index of the entry of the node among all parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeCopy {
    pub block: u32,
    pub at: u32,
}

/// Monitor of the stable limits in a block: it tells which limits of nodes can change a step.
#[derive(Debug, Default)]
pub(super) struct StepMonitor {
    /// True if the part of the block contributes impulses at this tick.
    pub gives: bool,
    /// Limits of any node that change no step of the block, s: from the first on and below the second.
    hold_range: (f64, f64),
    /// Limits of each node that change no step, s, at least as wide; empty where all groups have one step and no
    /// limit has left the range of the block.
    node_hold_ranges: Vec<(f64, f64)>,
    /// True if a node has found a limit that may change a step.
    is_check_requested: AtomicBool,
}

/// Mark of the last visit to a node: the block, counted from 1, and the local number there.
#[derive(Debug, Clone, Copy, Default)]
struct VisitMark {
    block: u32,
    number: u16,
}

/// All blocks of a gel.
#[derive(Debug)]
pub(super) struct ElementBlocks<const D: usize> {
    pub all: Vec<ElementBlock>,
    /// Contributions of each block to its nodes: impulses of its last sweep and Σ κ of all its elements.
    pub parts: Vec<NodeAccumulator>,
    /// Step monitor of each block.
    pub fronts: Vec<StepMonitor>,
    pub lanes: ElementBatches<D>,
    /// History variables, batch by batch; those of the state lag behind while ticks are processed.
    pub memory: Vec<HistoryLanes>,
    /// History variables per element.
    pub memories: usize,
    /// κ of the element behind each loaded facet at the last sweep, without the stiffness of the pressure, N/m.
    pub unloaded: Vec<f64>,
    /// Groups per block, and in all.
    pub groups: usize,
    n_groups: usize,
    /// Copies of all nodes, node by node, with the begin of each node's copies in `start`.
    start: Vec<u32>,
    spots: Vec<NodeCopy>,
    /// Overlaps of the blocks with each tile of nodes.
    pub overlaps: Vec<Vec<TileOverlap>>,
    /// Node caches of the sweeps, one per thread.
    pub locals: PerThread<NodeCache>,
    /// Rounding error of positions, m.
    pub still: f64,
    pub level: Level,
    /// True if blocks at rest are swept as well.
    pub never_rest: bool,
    /// True if a node at its rest position can be pulled, because elements of a later mesh carry history.
    pub is_prestrained: bool,
}

impl<const D: usize> ElementBlocks<D> {
    /// Builds the blocks; `None` for a potential without SIMD layout.
    pub fn new<P: Potential<D>>(gel: &DiscreteGel<D, P>, order: &ElementLayout) -> Option<Self> {
        let slots: Vec<Option<ElementId>> = (0..order.n_slots()).map(|slot| order.element(slot)).collect();
        let mut local = vec![[0; MAX_NODES]; slots.len()];
        let block_slots = slots.chunks(SLOTS).zip(local.chunks_mut(SLOTS));
        let mut marks = vec![VisitMark::default(); gel.mass.len()];
        let mut blocks: Vec<ElementBlock> = block_slots
            .zip(1..)
            .map(|((slots, local), block)| ElementBlock::new(gel, slots, local, block, &mut marks))
            .collect();
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
        let (groups, n_groups, locals) =
            (SLOTS / order.width(), order.n_groups(), PerThread::new(NodeCache::new(still)));
        let fronts = blocks.iter().map(|_| StepMonitor::default()).collect();
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

    /// Returns the copies of a node, in the order of the blocks.
    #[inline]
    pub fn node_copies(&self, node: usize) -> &[NodeCopy] {
        &self.spots[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// Returns true if a node belongs to an active group.
    pub fn fires(&self, node: usize) -> bool {
        self.node_copies(node).iter().any(|copy| {
            let block = &self.all[copy.block as usize];
            let number = || (copy.at as usize - block.first) as u16;
            match block.due {
                BlockActivity::Nothing => false,
                BlockActivity::Some => block.active_star().nodes.binary_search(&number()).is_ok(),
                BlockActivity::All => true,
            }
        })
    }

    /// Returns the number of nodes of all blocks.
    pub fn n_nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// Returns the groups of a block.
    pub fn groups_of(&self, block: usize) -> Range<usize> {
        group_range(block, self.groups, self.n_groups)
    }

    /// Updates the step range of a block and the limits that change no step.
    pub fn update_steps(&mut self, block: usize, clocks: &[GroupClock], grid: TickGrid) {
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

    /// Sums the impulses Σ p, N·s, and stiffnesses Σ κ, N/m, of the blocks at these nodes, in the order of the blocks.
    pub fn sum_parts(&self, nodes: &[usize]) -> [NodeAccumulator; NODE_BATCH] {
        let mut parts = [[0.0; 4]; NODE_BATCH];
        for (node, sum) in nodes.iter().zip(&mut parts) {
            for copy in self.node_copies(*node) {
                let part = &self.parts[copy.at as usize];
                let from = if self.fronts[copy.block as usize].gives { 0 } else { 3 };
                (from..4).for_each(|i| sum[i] += part[i]);
            }
        }
        parts
    }

    /// Activates the blocks around a moving node: they are swept from now on.
    pub fn activate_around(&self, node: usize) {
        for copy in self.node_copies(node) {
            self.activate(copy.block as usize);
        }
    }

    /// Requests a check of the steps around a node at their next tick.
    pub fn request_check_around(&mut self, node: usize) {
        for at in self.start[node]..self.start[node + 1] {
            self.all[self.spots[at as usize].block as usize].restless = true;
        }
    }

    /// Activates a block: it is swept from now on.
    pub fn activate(&self, block: usize) {
        let awake = &self.all[block].awake;
        // Threads share this flag, so it is written only once.
        if !awake.load(Ordering::Relaxed) {
            awake.store(true, Ordering::Relaxed);
        }
    }

    /// Resets steps, moving blocks and the validity of all parts.
    pub fn reset(&mut self, clocks: &[GroupClock], grid: TickGrid, moves: impl Fn(usize) -> bool) {
        let is_prestrained = self.is_prestrained;
        for i in 0..self.all.len() {
            self.update_steps(i, clocks, grid);
            let block = &mut self.all[i];
            block.cache = SweepCache::Empty;
            block.restless = true;
            *block.awake.get_mut() = is_prestrained || block.nodes.iter().any(|node| moves(node.index()));
        }
    }

    /// Returns the memory held, bytes.
    pub fn bytes(&self) -> usize {
        let of = |block: &ElementBlock| {
            let own = 4 * block.nodes.capacity();
            size_of::<ElementBlock>() + own + block.active_stars.values().map(GroupStar::bytes).sum::<usize>()
        };
        let fronts = self
            .fronts
            .iter()
            .map(|front| size_of::<StepMonitor>() + 16 * front.node_hold_ranges.capacity())
            .sum::<usize>();
        let parts = size_of::<NodeAccumulator>() * self.parts.len() + fronts;
        self.lanes.bytes()
            + size_of_val(self.memory.as_slice())
            + parts
            + self.all.iter().map(of).sum::<usize>()
            + 4 * self.start.len()
            + 8 * self.spots.len()
            + self.overlaps.iter().map(|overlaps| size_of_val(overlaps.as_slice())).sum::<usize>()
    }
}

/// Returns the groups of a block, from the groups per block and in all.
pub(super) fn group_range(block: usize, groups: usize, all: usize) -> Range<usize> {
    block * groups..all.min((block + 1) * groups)
}

impl StepMonitor {
    /// Finds the limits, s, of each node that leave the steps of these groups unchanged; unknown `limits` are
    /// infinite.
    ///
    /// A limit below a step shortens the step, at any node. No step is raised while one node of the group has a
    /// limit below [`RAISE_MARGIN`] steps. If such a limit is known, only the node with the least one is watched;
    /// otherwise all are.
    pub fn watch<const D: usize>(
        &mut self,
        (n_nodes, groups, lanes): (usize, Range<usize>, &ElementBatches<D>),
        (clocks, grid): (&[GroupClock], TickGrid),
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

    /// Prepares the monitor at the start of the node loop of a tick.
    pub fn prepare(&mut self, block: &ElementBlock) {
        self.gives = block.contributes();
        *self.is_check_requested.get_mut() = !block.may_hold_steps();
    }

    /// Returns true if limits in this range, s, at any nodes leave all steps unchanged.
    #[inline]
    pub fn holds_for_all(&self, least: f64, most: f64) -> bool {
        self.hold_range.0 <= least && most < self.hold_range.1
    }

    /// Returns true if this limit, s, of a node, by its local number, leaves all steps unchanged.
    #[inline]
    pub fn holds_at(&self, number: usize, limit: f64) -> bool {
        // The range of the block is the narrower one and is tried first.
        self.holds_for_all(limit, limit)
            || self.node_hold_ranges.get(number).is_some_and(|own| own.0 <= limit && limit < own.1)
    }

    /// Requests a check of the steps of the block.
    pub fn request_check(&self) {
        self.is_check_requested.store(true, Ordering::Relaxed);
    }

    /// Returns true if no limit may change a step.
    pub fn holds_steps(&mut self) -> bool {
        !*self.is_check_requested.get_mut()
    }
}

impl ElementBlock {
    fn new<const D: usize, P: Potential<D>>(
        gel: &DiscreteGel<D, P>,
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

    /// Returns the chunks of nodes that contain its nodes.
    pub fn runs(&self) -> Vec<u32> {
        let mut runs: Vec<u32> = self.nodes.iter().map(|node| (node.index() / RUN) as u32).collect();
        runs.dedup();
        runs
    }

    /// Returns true if a node of the block has moved or moves.
    pub fn is_moving(&self) -> bool {
        self.awake.load(Ordering::Relaxed)
    }

    /// Returns true if the block must be swept at this tick; a block at rest need not after one full sweep at rest.
    pub fn needs_sweep(&self) -> bool {
        self.due != BlockActivity::Nothing && (self.is_moving() || self.cache != SweepCache::AtRest)
    }

    /// Returns the number of elements to sweep at this tick.
    pub fn elements_to_sweep(&self) -> u64 {
        if self.needs_sweep() { self.n_active_elements } else { 0 }
    }

    /// Returns true if its part contributes impulses at this tick.
    pub fn contributes(&self) -> bool {
        self.due != BlockActivity::Nothing && self.is_moving()
    }

    /// Returns true if all steps hold unless a node finds a new limit: all groups have begun, and no step is about to rise.
    fn may_hold_steps(&self) -> bool {
        self.contributes() && !self.restless && self.steps.0 > 0
    }

    /// Returns the node star of the active groups where some are active.
    ///
    /// # Panics
    /// Where none or all are active, or before the active groups are found and swept.
    pub fn active_star(&self) -> &GroupStar {
        let around = self.active_stars.get(&self.longest_active).expect("active groups are found first");
        debug_assert!(!around.nodes.is_empty(), "a sweep comes first");
        around
    }

    /// Returns the local numbers of its active nodes.
    pub fn active_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.due == BlockActivity::All { 0..self.nodes.len() } else { 0..0 };
        let some = if self.due == BlockActivity::Some { self.active_star().nodes.as_slice() } else { &[] };
        all.chain(some.iter().map(|number| usize::from(*number)))
    }
}
