//! The node phase of the fast form: every active node drifts, learns its limit and takes its kick, by itself.

use super::blocks::Blocks;
use super::engine::Engine;
use super::kick::Taken;
use super::pace::nodal_limit;
use crate::algebra::{Vector, embed};
use crate::element::Potential;
use crate::mesh::NodeId;
use crate::state::Tick;
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// Nodes whose sums are taken together (numerics A9).
const RUN: usize = 1024;
/// Active nodes from which on all nodes are gone through, in runs that threads can share, instead of a list.
const MANY: usize = 4096;

/// Which nodes are active at a tick.
#[derive(Debug, Default)]
pub(super) struct Active {
    /// The active nodes, unless all are.
    pub list: Vec<u32>,
    /// All of them.
    pub all: bool,
    /// The last event each node was active in.
    stamp: Vec<u64>,
    event: u64,
}

impl Active {
    pub fn new(n_nodes: usize) -> Self {
        Self { list: vec![], all: false, stamp: vec![0; n_nodes], event: 0 }
    }

    /// Nobody yet.
    pub fn clear(&mut self) {
        self.list.clear();
        self.all = false;
        self.event += 1;
    }

    /// One more, if it is not there yet.
    pub fn add(&mut self, node: usize) {
        if self.stamp[node] != self.event {
            self.stamp[node] = self.event;
            self.list.push(node as u32);
        }
    }

    #[inline]
    pub fn has(&self, node: usize) -> bool {
        self.all || self.stamp[node] == self.event
    }
}

/// What changes of a node in the node phase.
pub(super) struct Node<'a, const D: usize> {
    position: &'a mut Vector<D>,
    velocity: &'a mut Vector<D>,
    last: &'a mut Tick,
    limit: &'a mut f64,
    excess: &'a mut f64,
}

/// What is summed over nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeSums {
    /// Least limit, s.
    pub limit: f64,
    /// Σ p·(v⁻ + v⁺)/2 − Σ ΔQ, J.
    pub work: f64,
    /// Greatest |v|², m²/s².
    pub fastest: f64,
    /// What held directions take up.
    pub taken: Taken,
}

impl Default for NodeSums {
    fn default() -> Self {
        Self { limit: f64::INFINITY, work: 0.0, fastest: 0.0, taken: Taken::default() }
    }
}

impl NodeSums {
    fn and(self, other: &Self) -> Self {
        Self {
            limit: self.limit.min(other.limit),
            work: self.work + other.work,
            fastest: self.fastest.max(other.fastest),
            taken: self.taken + other.taken,
        }
    }
}

/// A run of nodes, and what is summed over it.
type Run<'a, const D: usize> =
    (((((&'a mut [Vector<D>], &'a mut [Vector<D>]), &'a mut [Tick]), &'a mut [f64]), &'a mut [f64]), &'a mut NodeSums);

/// The part of a kick that belongs to the step ahead: half, and all of it at the start.
pub(super) fn share_ahead(tick: Tick) -> f64 {
    if tick == 0 { 1.0 } else { 0.5 }
}

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Collects the nodes of what fires and is not known to be still.
    pub(super) fn find_active(&mut self) {
        let Some(blocks) = &mut self.blocks else { return };
        let active = &mut self.scratch.active;
        active.clear();
        active.all = blocks.blocks.iter().all(|block| block.is_summed() && block.is_awake());
        if active.all {
            return;
        }
        for block in blocks.blocks.iter().filter(|block| block.gives()) {
            block.active().for_each(|number| active.add(block.nodes[number].index()));
        }
        for block in blocks.blocks.iter_mut().filter(|block| !block.gives()) {
            let seen = block.nodes.iter().any(|node| active.has(node.index()));
            *block.looked_at.get_mut() = seen;
        }
    }

    /// Drifts the active nodes and gathers their limits afresh; the least of those, s.
    pub(super) fn drift_and_limit(&mut self, tick: Tick) -> f64 {
        let (gel, grid, cfl) = (self.gel.clone(), self.grid, self.rules.cfl);
        let (stiffness, order) = (std::mem::take(&mut self.state.stiffness), self.order.clone());
        let sums = self.over_nodes(|a, node, blocks, sums| {
            *node.position += *node.velocity * grid.time(tick - *node.last);
            *node.last = tick;
            let spots = blocks.spots(a);
            let summed = spots.iter().all(|spot| blocks.blocks[spot.block as usize].is_summed());
            *node.limit = if summed {
                let part =
                    |spot: &super::blocks::Spot| blocks.blocks[spot.block as usize].part[spot.number as usize][3];
                cfl * super::pace::limit(spots.iter().map(part).sum(), gel.mass[a])
            } else {
                cfl * nodal_limit(&*gel, (&stiffness, &order), NodeId(a as u32))
            };
            sums.limit = sums.limit.min(*node.limit);
        });
        self.state.stiffness = stiffness;
        sums.limit
    }

    /// v += p/m in the free directions, p gathered from the blocks that gave in their order; held directions take up the rest.
    pub(super) fn kick_nodes(&mut self, tick: Tick) -> NodeSums {
        let (gel, freedom) = (self.gel.clone(), self.freedom());
        let share = share_ahead(tick);
        self.over_nodes(|a, node, blocks, sums| {
            let mut p = Vector::<D>::zeros();
            let spots = blocks.spots(a);
            for spot in spots {
                let block = &blocks.blocks[spot.block as usize];
                if block.gives() {
                    let part = &block.part[spot.number as usize];
                    (0..D).for_each(|i| p[i] += part[i]);
                }
            }
            let (before, free) = (*node.velocity, &gel.free[a]);
            *node.velocity += p.component_mul(free) / gel.mass[a];
            let excess = share * p.dot(&(*node.velocity - before));
            sums.work += 0.5 * p.dot(&(before + *node.velocity)) + *node.excess - excess;
            *node.excess = excess;
            sums.fastest = sums.fastest.max(node.velocity.norm_squared());
            if free.min() == 0.0 {
                sums.taken.add(free, freedom, (embed(node.position), embed(&p)));
            }
            if *node.velocity != Vector::<D>::zeros() {
                wake(blocks, a);
            }
        })
    }

    /// Does something to every active node; the sums do not depend on the threads.
    fn over_nodes(&mut self, work: impl Fn(usize, Node<'_, D>, &Blocks<D>, &mut NodeSums) + Sync) -> NodeSums {
        let blocks = self.blocks.take().expect("the fast form has blocks");
        let (state, scratch) = (&mut self.state, &mut self.scratch);
        let (position, velocity) = (&mut state.position, &mut state.velocity);
        let (last, limit, active) = (&mut self.last, &mut scratch.limit, &scratch.active);
        let excess = &mut state.excess;
        let mut total = NodeSums::default();
        if active.all || active.list.len() >= MANY {
            scratch.sums.resize(position.len().div_ceil(RUN), NodeSums::default());
            let go = |(run, (((((x, v), last), limit), excess), sums)): (usize, Run<'_, D>)| {
                *sums = NodeSums::default();
                for i in 0..x.len() {
                    let a = run * RUN + i;
                    if active.has(a) {
                        let (position, velocity, last) = (&mut x[i], &mut v[i], &mut last[i]);
                        let node = Node { position, velocity, last, limit: &mut limit[i], excess: &mut excess[i] };
                        work(a, node, &blocks, sums);
                    }
                }
            };
            match &self.pool {
                Some(pool) => pool.run(|| {
                    let runs = position.par_chunks_mut(RUN).zip(velocity.par_chunks_mut(RUN));
                    let runs = runs.zip(last.par_chunks_mut(RUN)).zip(limit.par_chunks_mut(RUN));
                    let runs = runs.zip(excess.par_chunks_mut(RUN));
                    runs.zip(scratch.sums.par_iter_mut()).enumerate().for_each(go);
                }),
                None => {
                    let runs = position.chunks_mut(RUN).zip(velocity.chunks_mut(RUN));
                    let runs = runs.zip(last.chunks_mut(RUN)).zip(limit.chunks_mut(RUN));
                    let runs = runs.zip(excess.chunks_mut(RUN));
                    runs.zip(scratch.sums.iter_mut()).enumerate().for_each(go);
                }
            }
            total = scratch.sums.iter().fold(total, NodeSums::and);
        } else {
            for a in active.list.iter().map(|a| *a as usize) {
                let node = Node {
                    position: &mut position[a],
                    velocity: &mut velocity[a],
                    last: &mut last[a],
                    limit: &mut limit[a],
                    excess: &mut excess[a],
                };
                work(a, node, &blocks, &mut total);
            }
        }
        self.blocks = Some(blocks);
        total
    }
}

/// The blocks around a node that moves must be swept from now on.
pub(super) fn wake<const D: usize>(blocks: &Blocks<D>, node: usize) {
    for spot in blocks.spots(node) {
        let awake = &blocks.blocks[spot.block as usize].awake;
        if !awake.load(Ordering::Relaxed) {
            awake.store(true, Ordering::Relaxed);
        }
    }
}
