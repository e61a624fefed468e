//! Blocks of elements for the SIMD form: 1024 slots each, with local node numbers.
//!
//! A block is swept with its nodes in the nearest cache. It writes its contributions to its own part, and each node
//! sums the parts of the blocks around it in their order. No thread writes where another one reads, and no bit
//! depends on the order of threads.

use super::active_set::NODE_BATCH;
use super::element_block::{BlockActivity, ElementBlock, SweepCache, VisitMark};
use super::element_order::{ElementLayout, SLOTS};
use super::partial_block::GroupStar;
use super::pool::PerThread;
use super::step_monitor::StepMonitor;
use super::tile_overlap::TileOverlap;
use super::{DiscreteGel, TickGrid};
use crate::fem::{ElementBatches, HistoryLanes, MAX_NODES, NodeAccumulator, NodeCache};
use crate::fem::{Potential, rounding};
use crate::mesh::ElementId;
use crate::state::{GroupClock, Tick};
use fearless_simd::Level;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Number of elements below which a tick is not shared among threads: some 100 µs of work. Ticks of elements that
/// contact steps more often, a tenth of `sphere-block` in cells of 2.4 mm, are above it.
pub(super) const MIN_SHARED_ELEMENTS: u64 = 4_096;

/// Copy of a shared node in a block: the block, and the index of the entry of the node among all parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeCopy {
    pub block: u32,
    pub at: u32,
}

/// All blocks of a gel.
#[derive(Debug)]
pub(super) struct ElementBlocks<const D: usize> {
    pub all: Vec<ElementBlock>,
    /// Contributions of each block to its nodes: impulses of its last sweep and Σ κ of all its elements.
    pub parts: Vec<NodeAccumulator>,
    /// Step monitor of each block.
    pub monitors: Vec<StepMonitor>,
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
        let monitors = blocks.iter().map(|_| StepMonitor::default()).collect();
        let parts = vec![[0.0; 4]; n_parts];
        let memory = lanes.memory();
        Some(Self {
            all: blocks,
            parts,
            monitors,
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
    pub fn is_active(&self, node: usize) -> bool {
        self.node_copies(node).iter().any(|copy| {
            let block = &self.all[copy.block as usize];
            let number = || (copy.at as usize - block.first) as u16;
            match block.activity {
                BlockActivity::Nothing => false,
                BlockActivity::Some => block.active_star().nodes.binary_search(&number()).is_ok(),
                BlockActivity::All => true,
            }
        })
    }

    /// Returns true if the moving blocks have enough elements to share a full tick among threads.
    pub fn are_worth_sharing(&self) -> bool {
        let moving = self.all.iter().filter(|block| block.is_moving());
        moving.map(|block| block.n_elements).sum::<u64>() > MIN_SHARED_ELEMENTS
    }

    /// Returns true if no block moves and no step of one may be raised.
    pub fn are_still(&self) -> bool {
        self.all.iter().all(|block| !block.is_moving() && !block.may_raise_step)
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
        let (all, monitor) = (&mut self.all[block], &mut self.monitors[block]);
        all.steps = (least, most);
        all.lengths = steps.fold(0, |all, step| all | step);
        all.active_stars.clear();
        monitor.hold(grid.time(least), grid.time(most));
        if least < most {
            monitor.watch(all.nodes.len(), groups, &self.lanes, clocks, grid, &[]);
        }
    }

    /// Sums the impulses Σ p, N·s, and stiffnesses Σ κ, N/m, of the blocks at these nodes, in the order of the blocks.
    pub fn sum_parts(&self, nodes: &[usize]) -> [NodeAccumulator; NODE_BATCH] {
        let mut parts = [[0.0; 4]; NODE_BATCH];
        for (node, sum) in nodes.iter().zip(&mut parts) {
            for copy in self.node_copies(*node) {
                let part = &self.parts[copy.at as usize];
                let from = if self.monitors[copy.block as usize].contributes { 0 } else { 3 };
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
            self.all[self.spots[at as usize].block as usize].may_raise_step = true;
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
            block.may_raise_step = true;
            *block.awake.get_mut() = is_prestrained || block.nodes.iter().any(|node| moves(node.index()));
        }
    }

    /// Returns the memory held, bytes.
    pub fn bytes(&self) -> usize {
        let of = |block: &ElementBlock| {
            let own = 4 * block.nodes.capacity();
            size_of::<ElementBlock>() + own + block.active_stars.values().map(GroupStar::bytes).sum::<usize>()
        };
        let monitors = self.monitors.iter().map(StepMonitor::bytes).sum::<usize>();
        let parts = size_of::<NodeAccumulator>() * self.parts.len() + monitors;
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
