//! The fast form of the elements: runs of a thousand slots that number their own nodes.
//!
//! A block is swept with its nodes in the nearest cache; what it gives to a node it leaves in its own part, and the node
//! gathers from the blocks around it in their order. So no thread writes where another one reads, and no bit depends on
//! who came first.

use super::assembly::{Overlap, TOGETHER};
use super::element_order::Order;
use super::energy_residual::Settled;
use super::node_loop::RUN;
use super::partial_block::Around;
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
const NEAR: usize = 1 << 16;

/// Whether what belongs to so many nodes comes from far.
pub(super) fn are_far(n_nodes: usize) -> bool {
    n_nodes > NEAR
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
pub(super) enum Known {
    /// Nothing.
    #[default]
    Nothing,
    /// Σ κ, and what the last sweep gave.
    Sums,
    /// The same, and that it is that of a full sweep at rest.
    Rest,
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
    pub n_due: u64,
    /// What is around the groups that fire where some do, by the longest step of these.
    pub firing: BTreeMap<Tick, Around>,
    /// The longest step of a group that fires at this tick, where some do, ticks.
    pub longest: Tick,
    /// What is known of its part.
    pub known: Known,
    /// Whether some node of it has moved or moves.
    pub awake: AtomicBool,
    /// Whether a node of it was active at this tick through another block.
    pub looked_at: bool,
    /// Whether a group of it may raise its step.
    pub restless: bool,
    /// Whether its elements remember what the state does not know yet.
    pub is_ahead: bool,
    /// What a sweep at this tick found, if it was swept.
    pub report: Option<Report>,
    /// What its groups that fired at its last sweep store, and what they have lost since the tick before of each.
    pub spent: Spent,
    /// What its groups that fire came to then.
    pub settled: Settled,
    /// The group whose answer holds the power of all that have not told theirs, if they were found in one sum.
    pub holder: Option<usize>,
}

/// What a sweep of a block finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Report {
    /// Elements evaluated that are not all at rest.
    pub updates: u64,
    /// Least J.
    pub least_jacobian: f64,
    /// Whether an element of a group that fires is turned over within its step.
    pub closes: bool,
    /// The first group that has an element inverted for the second tick in a row, or an energy that is no number.
    pub failed: Option<usize>,
}

impl Default for Report {
    fn default() -> Self {
        Self { updates: 0, least_jacobian: 1.0, closes: false, failed: None }
    }
}

/// Where a node is: which block, and where what that gives it stands among all parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub block: u32,
    pub at: u32,
}

/// What the nodes of a block look up and leave at a tick.
#[derive(Debug, Default)]
pub(super) struct Front {
    /// Whether what the block gives to them is in its part.
    pub gives: bool,
    /// From which limit on and below which one the steps of the block stay as they are, s, whichever node has it.
    calm: (f64, f64),
    /// The same of each node, no less; none where all groups are of one step and no limit was outside yet.
    calms: Vec<(f64, f64)>,
    /// Whether a node has found another one.
    stirred: AtomicBool,
}

/// In which block, from 1, a node was met last, and its number there.
#[derive(Debug, Clone, Copy, Default)]
struct Mark {
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
    spots: Vec<Spot>,
    /// What blocks have in common with each stretch of nodes.
    pub overlaps: Vec<Vec<Overlap>>,
    /// What a sweep works with.
    pub locals: PerThread<Local>,
    /// To what positions are rounded, m.
    pub still: f64,
    pub level: Level,
    /// Whether also what is at rest is swept.
    pub never_rest: bool,
    /// Whether a node that stands where it rests can be pulled all the same: where the elements of a later mesh remember.
    pub strained: bool,
}

impl<const D: usize> Blocks<D> {
    /// The blocks of a potential that has lanes.
    pub fn new<P: Potential<D>>(gel: &Gel<D, P>, order: &Order) -> Option<Self> {
        let slots: Vec<Option<ElementId>> = (0..order.n_slots()).map(|slot| order.element(slot)).collect();
        let mut local = vec![[0; MAX_NODES]; slots.len()];
        let runs = slots.chunks(SLOTS).zip(local.chunks_mut(SLOTS));
        let mut marks = vec![Mark::default(); gel.mass.len()];
        let mut blocks: Vec<Block> =
            runs.zip(1..).map(|((slots, local), block)| Block::new(gel, slots, local, (block, &mut marks))).collect();
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
        let mut spots = vec![Spot { block: 0, at: 0 }; n_parts];
        for (i, block) in blocks.iter().enumerate() {
            for (number, node) in block.nodes.iter().enumerate() {
                let at = &mut fill[node.index()];
                spots[*at as usize] = Spot { block: i as u32, at: (block.first + number) as u32 };
                *at += 1;
            }
        }
        let overlaps = Overlap::all(&blocks, n_nodes);
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
            strained: false,
        })
    }

    /// Where a node is, in the order of the blocks.
    #[inline]
    pub fn spots(&self, node: usize) -> &[Spot] {
        &self.spots[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// Whether a node is one of what fires.
    pub fn fires(&self, node: usize) -> bool {
        self.spots(node).iter().any(|spot| {
            let block = &self.all[spot.block as usize];
            let number = || (spot.at as usize - block.first) as u16;
            match block.due {
                Due::Nothing => false,
                Due::Some => block.around().nodes.binary_search(&number()).is_ok(),
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
        groups_of(block, self.groups, self.n_groups)
    }

    /// Takes the steps of its groups into a block: within which limits a node of them leaves them as they are.
    pub fn pace(&mut self, block: usize, (clocks, grid): (&[Clock], TickGrid)) {
        let groups = self.groups_of(block);
        let steps = clocks[groups.clone()].iter().map(|clock| clock.step);
        let (least, most) = steps.clone().fold((Tick::MAX, 0), |(least, most), step| (least.min(step), most.max(step)));
        let (all, front) = (&mut self.all[block], &mut self.fronts[block]);
        all.steps = (least, most);
        all.lengths = steps.fold(0, |all, step| all | step);
        all.firing.clear();
        front.calm = (grid.time(most), RAISE_MARGIN * grid.time(least));
        front.calms.clear();
        if least < most {
            front.watch((all.nodes.len(), groups, &self.lanes), (clocks, grid), &[]);
        }
    }

    /// Σ p, N·s, and Σ κ, N/m, that the blocks give to these nodes, in their order.
    pub fn given(&self, nodes: &[usize]) -> [Accumulated; TOGETHER] {
        let mut parts = [[0.0; 4]; TOGETHER];
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
    pub fn wake(&self, node: usize) {
        for spot in self.spots(node) {
            self.rouse(spot.block as usize);
        }
    }

    /// The steps around a node must be looked at as soon as they end.
    pub fn stir(&mut self, node: usize) {
        for at in self.start[node]..self.start[node + 1] {
            self.all[self.spots[at as usize].block as usize].restless = true;
        }
    }

    /// A block must be swept from now on.
    pub fn rouse(&self, block: usize) {
        let awake = &self.all[block].awake;
        // Threads share what is written: not again and again.
        if !awake.load(Ordering::Relaxed) {
            awake.store(true, Ordering::Relaxed);
        }
    }

    /// All steps, who moves, and nothing known of what blocks give.
    pub fn restart(&mut self, (clocks, grid): (&[Clock], TickGrid), moves: impl Fn(usize) -> bool) {
        let strained = self.strained;
        for i in 0..self.all.len() {
            self.pace(i, (clocks, grid));
            let block = &mut self.all[i];
            block.known = Known::Nothing;
            block.restless = true;
            *block.awake.get_mut() = strained || block.nodes.iter().any(|node| moves(node.index()));
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |block: &Block| {
            let own = 4 * block.nodes.capacity();
            size_of::<Block>() + own + block.firing.values().map(Around::bytes).sum::<usize>()
        };
        let fronts = self.fronts.iter().map(|front| size_of::<Front>() + 16 * front.calms.capacity()).sum::<usize>();
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
pub(super) fn groups_of(block: usize, groups: usize, all: usize) -> Range<usize> {
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
        self.calms.clear();
        self.calms.resize(n_nodes, (0.0, f64::INFINITY));
        for group in groups {
            let step = grid.time(clocks[group].step);
            let (mut least, raised) = ((f64::INFINITY, 0), RAISE_MARGIN * step);
            lanes.nodes(group, |number| {
                let number = usize::from(number);
                self.calms[number].0 = self.calms[number].0.max(step);
                let limit = limits.get(number).copied().unwrap_or(f64::INFINITY);
                least = if limit < least.0 { (limit, number) } else { least };
            });
            let mut bound = |number: usize| self.calms[number].1 = self.calms[number].1.min(raised);
            if least.0 < raised { bound(least.1) } else { lanes.nodes(group, |number| bound(usize::from(number))) }
        }
    }

    /// At the start of the node phase of a tick.
    pub fn open(&mut self, block: &Block) {
        self.gives = block.gives();
        *self.stirred.get_mut() = !block.may_be_calm();
    }

    /// Whether limits between these, s, leave all steps as they are, whichever nodes have them.
    #[inline]
    pub fn calms_all(&self, (least, most): (f64, f64)) -> bool {
        self.calm.0 <= least && most < self.calm.1
    }

    /// Whether this limit, s, of a node, by its number within the block, does.
    #[inline]
    pub fn calms_at(&self, number: usize, limit: f64) -> bool {
        // What no node of the block finds anything in needs no look at its own.
        self.calms_all((limit, limit)) || self.calms.get(number).is_some_and(|own| own.0 <= limit && limit < own.1)
    }

    /// A node has found another one.
    pub fn stir(&self) {
        self.stirred.store(true, Ordering::Relaxed);
    }

    /// Whether no limit may change a step.
    pub fn is_calm(&mut self) -> bool {
        !*self.stirred.get_mut()
    }
}

impl Block {
    fn new<const D: usize, P: Potential<D>>(
        gel: &Gel<D, P>,
        slots: &[Option<ElementId>],
        local: &mut [[u16; MAX_NODES]],
        (block, marks): (u32, &mut [Mark]),
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
    pub fn is_wanted(&self) -> bool {
        self.due != Due::Nothing && (self.is_awake() || self.known != Known::Rest)
    }

    /// Its elements that must be swept at this tick.
    pub fn wanted(&self) -> u64 {
        if self.is_wanted() { self.n_due } else { 0 }
    }

    /// Whether what it gives to its nodes at this tick is in its part.
    pub fn gives(&self) -> bool {
        self.due != Due::Nothing && self.is_awake()
    }

    /// Whether all its steps stay as they are unless a node finds a limit that changes one: all have begun, and none is about to
    /// be raised.
    fn may_be_calm(&self) -> bool {
        self.gives() && !self.restless && self.steps.0 > 0
    }

    /// What is around the groups that fire, where some do.
    ///
    /// # Panics
    /// Where none or all do, or before what fires is found out and swept.
    pub fn around(&self) -> &Around {
        let around = self.firing.get(&self.longest).expect("it is found out first what fires");
        debug_assert!(!around.nodes.is_empty(), "a sweep comes before what is around");
        around
    }

    /// The numbers of its nodes that fire.
    pub fn active(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.due == Due::All { 0..self.nodes.len() } else { 0..0 };
        let some = if self.due == Due::Some { self.around().nodes.as_slice() } else { &[] };
        all.chain(some.iter().map(|number| usize::from(*number)))
    }
}
