//! What nodes are given by the blocks around them, and what these are told of them.
//!
//! Some nodes are looked up one by one; where many are active, whole stretches of them are gone through, block by block: a block and a
//! stretch have some tens of nodes in common, which stand beside each other in both, while to go from node to node is to go back and
//! forth between blocks. Each sum runs over the blocks in their order either way: the same bits.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::blocks::{Block, Blocks, are_far};
use super::node_loop::RUN;
use super::step_size;
use crate::fem::{Accumulated, LANES};
use crate::math::Vector;
use crate::mesh::NodeId;
use prefetch_index::prefetch_index;
use std::ops::Range;

/// Nodes that are gone through together, each stage for all of them: what they gather, their limits, their kicks. Not tuned: any number
/// does that fills vectors and stays in the nearest cache.
pub(super) const TOGETHER: usize = 32;
const _: () = assert!(TOGETHER.is_multiple_of(LANES), "they fill vectors");
/// Nodes of a stretch, a part of a run of them: what is gathered for it stays in the nearest cache.
pub(super) const STRETCH: usize = 256;
/// How many overlaps before it is gathered from an overlap is asked for; 1 to 12 are as good.
const AHEAD: usize = 3;
/// Said of nodes that stand [beside each other](Gathered::beside).
pub(super) const WHOLE: &str = "that many nodes go together";
/// Bytes of a line of the cache.
const LINE: usize = 64;
const _: () = assert!(RUN / STRETCH * STRETCH == RUN, "runs are made of whole stretches");

/// What says how long a step around a node may be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rule<'a> {
    /// By node, kg.
    pub mass: &'a [f64],
    pub cfl: f64,
}

/// What some nodes gather from the blocks around them, and what these are told.
pub(super) struct Gathered<const D: usize> {
    /// Σ p, N·s, and last Σ κ, N/m: component by component, each of all of them.
    pub parts: [[f64; TOGETHER]; 4],
    /// CFL · 2/√λ_a, s.
    pub limit: [f64; TOGETHER],
    /// Whether they move after their kicks.
    pub moves: [bool; TOGETHER],
    /// Whether they are known to be as many as go together, each the next of the one before.
    pub beside: bool,
}

impl<const D: usize> Gathered<D> {
    /// What these nodes are given, and their limits.
    #[inline(always)]
    pub fn new(given: &[Accumulated; TOGETHER], nodes: &[usize], rule: Rule<'_>) -> Self {
        let mut mass = [1.0; TOGETHER];
        nodes.iter().zip(&mut mass).for_each(|(node, own)| *own = rule.mass[*node]);
        Self::of(given, &mass, rule.cfl)
    }

    /// The same of nodes that stand [beside](Self::beside) each other from one on.
    #[inline(always)]
    fn beside(given: &[Accumulated; TOGETHER], first: usize, rule: Rule<'_>) -> Self {
        let mass = rule.mass[first..].first_chunk().expect(WHOLE);
        Self { beside: true, ..Self::of(given, mass, rule.cfl) }
    }

    #[inline(always)]
    fn of(given: &[Accumulated; TOGETHER], mass: &[f64; TOGETHER], cfl: f64) -> Self {
        // All four: of some of them the last ones would be taken one by one.
        let (mut parts, mut limit) = ([[0.0; TOGETHER]; 4], [0.0; TOGETHER]);
        for (i, given) in given.iter().enumerate() {
            (0..4).for_each(|k| parts[k][i] = given[k]);
        }
        // Apart from the rest: so roots and divisions go side by side.
        for i in 0..TOGETHER {
            limit[i] = cfl * step_size::limit(parts[3][i], mass[i]);
        }
        Self { parts, limit, moves: [false; TOGETHER], beside: false }
    }

    /// Σ p of the i-th, N·s.
    #[inline(always)]
    pub fn push(&self, i: usize) -> Vector<D> {
        Vector::<D>::from_fn(|axis, _| self.parts[axis][i])
    }

    /// Tells the blocks around these nodes of their limits, and that they must be swept from now on where a node moves.
    pub fn tell(&self, nodes: &[usize], blocks: &Blocks<D>) {
        for (i, node) in nodes.iter().enumerate() {
            for spot in blocks.spots(*node) {
                let front = &blocks.fronts[spot.block as usize];
                if !front.calms_at(spot.at as usize - blocks.all[spot.block as usize].first, self.limit[i]) {
                    front.stir();
                }
                if self.moves[i] && !front.gives {
                    blocks.rouse(spot.block as usize);
                }
            }
        }
    }
}

/// What a block and a stretch of nodes have in common: the number, within the block, of the first such node, and how many these are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    block: u32,
    first: u16,
    n: u16,
}

impl Overlap {
    /// Those of each stretch of so many nodes in all, in the order of the blocks.
    pub fn all(blocks: &[Block], n_nodes: usize) -> Vec<Vec<Self>> {
        let mut overlaps = vec![vec![]; n_nodes.div_ceil(STRETCH)];
        for (block, own) in (0..).zip(blocks) {
            let mut first = 0;
            for nodes in own.nodes.chunk_by(|a, b| a.index() / STRETCH == b.index() / STRETCH) {
                let n = nodes.len() as u16;
                overlaps[nodes[0].index() / STRETCH].push(Self { block, first, n });
                first += n;
            }
        }
        overlaps
    }

    /// Asks for what the block has for these nodes before it is needed.
    #[inline(always)]
    fn fetch<const D: usize>(self, blocks: &Blocks<D>) {
        let block = &blocks.all[self.block as usize];
        // About once in each line of the cache.
        for number in self.numbers().step_by(LINE / size_of::<Accumulated>()) {
            prefetch_index(&blocks.parts, block.first + number);
        }
        for number in self.numbers().step_by(LINE / size_of::<NodeId>()) {
            prefetch_index(&block.nodes, number);
        }
    }

    /// The numbers of the nodes within the block.
    fn numbers(self) -> Range<usize> {
        let first = usize::from(self.first);
        first..first + usize::from(self.n)
    }
}

/// A stretch of nodes, each at its number modulo [`STRETCH`].
pub(super) struct Stretch {
    at: usize,
    /// Σ p, N·s, and Σ κ, N/m.
    parts: [Accumulated; STRETCH],
    /// Which of them are active, CFL · 2/√λ_a of these, s, and whether they move after their kicks.
    active: [bool; STRETCH],
    limit: [f64; STRETCH],
    moves: [bool; STRETCH],
    /// The least and the greatest of the limits, lane by lane, and whether all of them are numbers.
    least: [f64; LANES],
    most: [f64; LANES],
    are_numbers: bool,
}

impl Stretch {
    /// From this node on, gathered from the blocks in their order.
    #[inline(always)]
    pub fn new<const D: usize>(first: usize, blocks: &Blocks<D>) -> Self {
        let (at, mut parts) = (first / STRETCH, [[0.0; 4]; STRETCH]);
        let (overlaps, far) = (&blocks.overlaps[at], are_far(blocks.n_nodes()));
        for (i, overlap) in overlaps.iter().enumerate() {
            if far && let Some(next) = overlaps.get(i + AHEAD) {
                next.fetch(blocks);
            }
            let block = &blocks.all[overlap.block as usize];
            let nodes = &block.nodes[overlap.numbers()];
            let given = &blocks.parts[block.first..][overlap.numbers()];
            // Two loops: with a choice for each node it takes half as long again.
            if blocks.fronts[overlap.block as usize].gives {
                for (node, given) in nodes.iter().zip(given) {
                    let part = &mut parts[node.index() % STRETCH];
                    (0..4).for_each(|i| part[i] += given[i]);
                }
            } else {
                nodes.iter().zip(given).for_each(|(node, given)| parts[node.index() % STRETCH][3] += given[3]);
            }
        }
        let (active, limit, moves) = ([false; STRETCH], [0.0; STRETCH], [false; STRETCH]);
        Self { at, parts, active, limit, moves, least: [f64::INFINITY; LANES], most: [0.0; LANES], are_numbers: true }
    }

    /// What some nodes of the stretch are given, and their limits.
    #[inline(always)]
    pub fn gathered<const D: usize>(&self, nodes: &[usize], rule: Rule<'_>) -> Gathered<D> {
        let (n, first) = (nodes.len(), nodes[0]);
        // They are ascending.
        if n == TOGETHER && nodes[n - 1] - first == n - 1 {
            let given = self.parts[first % STRETCH..].first_chunk().expect(WHOLE);
            return Gathered::beside(given, first, rule);
        }
        let mut given = [[0.0; 4]; TOGETHER];
        nodes.iter().zip(&mut given).for_each(|(node, given)| *given = self.parts[node % STRETCH]);
        Gathered::new(&given, nodes, rule)
    }

    /// Notes the limits of these nodes, which are active, and whether they move.
    #[inline(always)]
    pub fn note<const D: usize>(&mut self, nodes: &[usize], gathered: &Gathered<D>) {
        self.note_limits(&gathered.limit, nodes.len());
        if gathered.beside {
            let at = nodes[0] % STRETCH;
            let all = at..at + TOGETHER;
            self.active[all.clone()].fill(true);
            self.limit[all.clone()].copy_from_slice(&gathered.limit);
            return self.moves[all].copy_from_slice(&gathered.moves);
        }
        for (i, node) in nodes.iter().enumerate() {
            let at = node % STRETCH;
            (self.active[at], self.limit[at], self.moves[at]) = (true, gathered.limit[i], gathered.moves[i]);
        }
    }

    /// Notes the first of these limits.
    #[inline(always)]
    fn note_limits(&mut self, limits: &[f64; TOGETHER], n: usize) {
        let (mut limits, first) = (*limits, limits[0]);
        limits[n..].fill(first);
        // Eight side by side: one after the other each would wait for the one before.
        for eight in limits.as_chunks::<LANES>().0 {
            for (i, limit) in eight.iter().enumerate() {
                self.least[i] = if *limit < self.least[i] { *limit } else { self.least[i] };
                self.most[i] = if *limit > self.most[i] { *limit } else { self.most[i] };
                self.are_numbers &= !limit.is_nan();
            }
        }
    }

    /// Tells the blocks around of the limits, and that they must be swept from now on where a node moves.
    #[inline(always)]
    pub fn tell<const D: usize>(&self, blocks: &Blocks<D>) {
        let limits = self.limits();
        for overlap in &blocks.overlaps[self.at] {
            let (block, front) = (&blocks.all[overlap.block as usize], &blocks.fronts[overlap.block as usize]);
            let nodes = &block.nodes[overlap.numbers()];
            if front.gives {
                let calms = |(node, number): (&NodeId, usize)| {
                    let at = node.index() % STRETCH;
                    !self.active[at] || front.calms_at(number, self.limit[at])
                };
                if !front.calms_all(limits) && !nodes.iter().zip(overlap.numbers()).all(calms) {
                    front.stir();
                }
            } else if !block.is_awake() && nodes.iter().any(|node| self.moves[node.index() % STRETCH]) {
                blocks.rouse(overlap.block as usize);
            }
        }
    }

    /// The least limit of the active ones that is a number, s.
    #[inline(always)]
    pub fn least(&self) -> f64 {
        self.least.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The least and the greatest limit of the active ones, s; no numbers if one is none.
    #[inline(always)]
    fn limits(&self) -> (f64, f64) {
        let least = self.least();
        let most = self.most.into_iter().fold(0.0, f64::max);
        if self.are_numbers { (least, most) } else { (f64::NAN, f64::NAN) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::blocks::Front;
    use super::super::node_loop::Active;
    use super::super::test_cube;
    use super::*;
    use crate::contact::Exchange;
    use crate::fem::Potential;

    /// Two of three blocks give something.
    fn open(blocks: &mut Blocks<3>) {
        for (i, (block, front)) in blocks.all.iter_mut().zip(&mut blocks.fronts).enumerate() {
            *block.awake.get_mut() = i % 3 > 0;
            front.open(block);
            front.gives = i % 3 > 0;
        }
    }

    fn move_some(nodes: &[usize], gathered: &mut Gathered<3>) {
        nodes.iter().zip(&mut gathered.moves).for_each(|(node, moves)| *moves = node % 50 == 0);
    }

    fn by_stretch(nodes: &[usize], rule: Rule<'_>, blocks: &Blocks<3>) {
        let n_nodes = rule.mass.len();
        let mut active = Active::new(n_nodes);
        let first = nodes[0] / STRETCH * STRETCH;
        let mut all = first..n_nodes.min(first + STRETCH);
        for node in nodes {
            active.add(*node);
        }
        active.all = nodes.len() == all.len();
        let (mut stretch, mut limits) = (Stretch::new(first, blocks), vec![]);
        while let Some((n, some)) = active.take(&mut all) {
            let nodes = &some[..n];
            let mut gathered = stretch.gathered(nodes, rule);
            limits.extend_from_slice(&gathered.limit[..n]);
            let is_next = |pair: &[usize]| pair[0] + 1 == pair[1];
            assert_eq!(gathered.beside, n == TOGETHER && nodes.windows(2).all(is_next));
            assert_eq!(gathered.parts, Gathered::<3>::new(&blocks.given(nodes), nodes, rule).parts);
            move_some(nodes, &mut gathered);
            stretch.note(nodes, &gathered);
        }
        let least = limits.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!(stretch.limits(), (least, limits.iter().copied().fold(0.0, f64::max)));
        stretch.tell(blocks);
    }

    fn by_node(nodes: &[usize], rule: Rule<'_>, blocks: &Blocks<3>) {
        for nodes in nodes.chunks(TOGETHER) {
            let mut gathered = Gathered::new(&blocks.given(nodes), nodes, rule);
            move_some(nodes, &mut gathered);
            gathered.tell(nodes, blocks);
        }
    }

    #[test]
    fn the_same_is_given_and_told_stretch_by_stretch_and_node_by_node() {
        let mut engine = test_cube::engine(test_cube::gel(&test_cube::mixed()));
        engine.advance_to(1e-3, &mut [Exchange::default()]).expect("the gel only swings");
        let (n_nodes, mass) = (engine.gel().potential.rest().len(), engine.gel().mass.clone());
        let mut blocks = engine.blocks.take().expect("bins have the fast form");
        assert!(n_nodes > 3 * STRETCH && blocks.all.iter().any(|block| block.steps.0 < block.steps.1));
        let some: Vec<usize> = (0..n_nodes).filter(|node| node % 7 != 3 || node % STRETCH > 100).collect();
        let every: Vec<usize> = (0..n_nodes).collect();
        let mut all = vec![];
        for (cfl, active) in [0.1, 0.4, 0.8, 1.6, 6.4].into_iter().flat_map(|cfl| [(cfl, &some), (cfl, &every)]) {
            let rule = Rule { mass: &mass, cfl };
            let told = [by_stretch, by_node].map(|tell| {
                open(&mut blocks);
                active.chunk_by(|a, b| a / STRETCH == b / STRETCH).for_each(|nodes| tell(nodes, rule, &blocks));
                let calm: Vec<bool> = blocks.fronts.iter_mut().map(Front::is_calm).collect();
                (calm, blocks.all.iter().map(Block::is_awake).collect::<Vec<bool>>())
            });
            assert_eq!(told[0], told[1], "at a CFL of {cfl}");
            all.push(told[0].clone());
        }
        let has = |calm: bool| all.iter().any(|(of_blocks, _)| of_blocks.contains(&calm));
        assert!(has(true) && has(false), "some blocks are calm and some are not");
        assert!(all.iter().all(|(_, awake)| awake[0]), "who moves wakes a block that slept");
    }
}
