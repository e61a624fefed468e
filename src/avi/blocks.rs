//! The fast form of the elements: runs of a thousand slots that number their own nodes.
//!
//! A block is swept with its nodes in the nearest cache; what it gives to a node it leaves in its own part, and the node
//! gathers from the blocks around it in their order. So no thread writes where another one reads, and no bit depends on
//! who came first.

use super::Gel;
use super::order::Order;
use crate::algebra::Vector;
use crate::element::{Accumulated, Lanes, Local, MAX_NODES, Potential};
use crate::mesh::{ElementId, NodeId};
use crate::state::{Clock, Tick};
use fearless_simd::Level;
use std::sync::atomic::{AtomicBool, Ordering};

/// Slots of a block: with 1024 tetrahedra, 330 nodes and what is accumulated at them take 32 kB of cache, and a node is in 1.7
/// blocks; a quarter of that makes it 2.5.
pub(super) const SLOTS: usize = 1024;

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

/// A run of slots.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// Its nodes, ascending.
    pub nodes: Vec<NodeId>,
    /// The nodes of the surface among them: number here and there.
    pub surface: Vec<(u16, u32)>,
    /// What its last sweep gave to its nodes, and Σ κ of all its elements there.
    pub part: Vec<Accumulated>,
    /// Elements in it.
    pub n_elements: u64,
    /// Least and greatest step of its groups, ticks.
    pub steps: (Tick, Tick),
    /// How much of it fires at this tick.
    pub due: Due,
    /// The nodes of the groups that fire, if not all do.
    pub touched: Vec<u16>,
    /// Whether `part` is that of a full sweep of the block at rest.
    pub still: bool,
    /// Whether some node of it has moved or moves.
    pub awake: AtomicBool,
    /// Whether a node of it was active at this tick through another block.
    pub looked_at: AtomicBool,
    /// Whether a group of it may raise its step.
    pub restless: bool,
    /// Whether it was swept at this tick.
    pub was_swept: bool,
    /// What the last sweep found.
    pub report: Report,
}

/// What a sweep of a block finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Report {
    /// Elements evaluated that are not all at rest.
    pub updates: u64,
    /// Least J.
    pub least_jacobian: f64,
    /// The first group that has an element inverted for the second tick in a row, or an energy that is no number.
    pub failed: Option<usize>,
}

impl Default for Report {
    fn default() -> Self {
        Self { updates: 0, least_jacobian: 1.0, failed: None }
    }
}

/// Where a node is: which block, and its number there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    pub block: u32,
    pub number: u32,
}

/// All blocks.
#[derive(Debug)]
pub(super) struct Blocks<const D: usize> {
    pub all: Vec<Block>,
    pub lanes: Lanes<D>,
    /// Groups of a block.
    pub groups: usize,
    start: Vec<u32>,
    spots: Vec<Spot>,
    /// One for each thread.
    pub locals: Vec<Local>,
    pub level: Level,
    /// Whether also what is at rest is swept.
    pub never_rest: bool,
}

impl<const D: usize> Blocks<D> {
    /// The blocks of a potential that has lanes.
    pub fn new<P: Potential<D>>(gel: &Gel<D, P>, order: &Order) -> Option<Self> {
        let slots: Vec<Option<ElementId>> = (0..order.n_slots()).map(|slot| order.element(slot)).collect();
        let mut local = vec![[0; MAX_NODES]; slots.len()];
        let runs = slots.chunks(SLOTS).zip(local.chunks_mut(SLOTS));
        let blocks: Vec<Block> = runs.map(|(slots, local)| Block::new(gel, slots, local)).collect();
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
        let mut spots = vec![Spot { block: 0, number: 0 }; start[n_nodes] as usize];
        for (i, block) in blocks.iter().enumerate() {
            for (number, node) in block.nodes.iter().enumerate() {
                let at = &mut fill[node.index()];
                spots[*at as usize] = Spot { block: i as u32, number: number as u32 };
                *at += 1;
            }
        }
        let (groups, locals) = (SLOTS / order.width(), vec![Local::new()]);
        Some(Self { all: blocks, lanes, groups, start, spots, locals, level: Level::new(), never_rest: false })
    }

    /// Where a node is, in the order of the blocks.
    #[inline]
    pub fn spots(&self, node: usize) -> &[Spot] {
        &self.spots[self.start[node] as usize..self.start[node + 1] as usize]
    }

    /// Adds to what a block gives to a node of it.
    pub fn add(&mut self, block: usize, node: NodeId, impulse: &Vector<D>) {
        let at = self.spots(node.index()).iter().find(|spot| spot.block as usize == block);
        let number = at.expect("a node of the block").number as usize;
        let part = &mut self.all[block].part[number];
        (0..D).for_each(|i| part[i] += impulse[i]);
    }

    /// Takes the steps of its groups into a block.
    pub fn pace(&mut self, block: usize, clocks: &[Clock]) {
        let groups = block * self.groups..clocks.len().min((block + 1) * self.groups);
        let steps = clocks[groups].iter().map(|clock| clock.step);
        self.all[block].steps = steps.fold((Tick::MAX, 0), |(least, most), step| (least.min(step), most.max(step)));
    }

    /// All steps and stiffnesses, who moves, and nothing known of what is still.
    pub fn restart(&mut self, (clocks, stiffness): (&[Clock], &[f64]), moves: impl Fn(usize) -> bool) {
        for i in 0..self.all.len() {
            self.pace(i, clocks);
            let block = &mut self.all[i];
            let groups = i * self.groups..clocks.len().min((i + 1) * self.groups);
            self.lanes.sum_stiffness(groups, &stiffness[i * SLOTS..], &mut block.part);
            block.still = false;
            block.restless = true;
            *block.awake.get_mut() = block.nodes.iter().any(|node| moves(node.index()));
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |block: &Block| {
            size_of::<Block>() + 4 * block.nodes.capacity() + 8 * block.surface.capacity() + 32 * block.part.capacity()
        };
        self.lanes.bytes() + self.all.iter().map(of).sum::<usize>() + 4 * self.start.len() + 8 * self.spots.len()
    }
}

impl Block {
    fn new<const D: usize, P: Potential<D>>(
        gel: &Gel<D, P>,
        slots: &[Option<ElementId>],
        local: &mut [[u16; MAX_NODES]],
    ) -> Self {
        let elements = || slots.iter().flatten();
        let mut nodes: Vec<NodeId> = elements().flat_map(|element| gel.potential.nodes(*element)).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.shrink_to_fit();
        let number = |node: &NodeId| nodes.binary_search(node).expect("a node of the block") as u16;
        for (slot, local) in slots.iter().zip(local) {
            let own = slot.map(|element| gel.potential.nodes(element)).unwrap_or_default();
            for (local, node) in local.iter_mut().zip(own) {
                *local = number(node);
            }
        }
        let on_surface = |(i, node): (usize, &NodeId)| Some((i as u16, gel.surface.of[node.index()]?));
        let surface = nodes.iter().enumerate().filter_map(on_surface).collect();
        let (part, n_elements) = (vec![[0.0; 4]; nodes.len()], elements().count() as u64);
        Self { surface, part, n_elements, awake: AtomicBool::new(true), restless: true, nodes, ..Self::default() }
    }

    /// Whether some node of it has moved or moves.
    pub fn is_awake(&self) -> bool {
        self.awake.load(Ordering::Relaxed)
    }

    /// Whether it must be swept at this tick: at rest, what it would answer is known once it was swept so as a whole.
    pub fn is_wanted(&self) -> bool {
        self.due != Due::Nothing && (self.is_awake() || !self.still)
    }

    /// Whether what it gives to its nodes at this tick is in its part.
    pub fn gives(&self) -> bool {
        self.due != Due::Nothing && self.is_awake()
    }

    /// The numbers of its nodes that fire.
    pub fn active(&self) -> impl Iterator<Item = usize> + '_ {
        let all = if self.due == Due::All { 0..self.nodes.len() } else { 0..0 };
        let some = if self.due == Due::Some { self.touched.as_slice() } else { &[] };
        all.chain(some.iter().map(|number| usize::from(*number)))
    }
}
