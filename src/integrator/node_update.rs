//! Update of an active node in a tick: drift, kick and damping, batch by batch.

#![allow(clippy::inline_always, reason = "only inlined code is compiled for the SIMD level of its caller")]

use super::active_set::NODE_BATCH;
use super::assembly::{FULL_BATCH, NodalSums};
use super::kick_sums::{KickSums, decay};
use super::node_chunks::NodeChunks;
use super::{DiscreteGel, TickGrid};
use crate::contact::FreeDirections;
use crate::fem::Potential;
use crate::math::{Vector, embed};
use crate::state::Tick;

/// Update of the nodes of a tick: the data common to all of them.
pub(super) struct NodeUpdate<'a, const D: usize, P> {
    pub gel: &'a DiscreteGel<D, P>,
    pub grid: TickGrid,
    pub freedom: FreeDirections,
    pub tick: Tick,
    /// Fraction of a kick that belongs to the next step.
    pub leading_share: f64,
    /// Damping coefficient α, 1/s.
    pub damping_rate: f64,
}

impl<const D: usize, P: Potential<D>> NodeUpdate<'_, D, P> {
    /// Drifts and kicks a batch of nodes by their assembled impulses, records which of them move, and adds to the
    /// sums.
    #[inline(always)]
    pub fn apply(
        &self,
        chunks: &mut NodeChunks<'_, D>,
        nodes: &[usize],
        nodal: &mut NodalSums<D>,
        sums: &mut KickSums,
    ) {
        // A local copy, which stores to nodal data cannot alias.
        let mut local = *sums;
        if self.damping_rate == 0.0 && nodal.is_contiguous {
            self.update_contiguous(chunks, nodes[0], nodal, &mut local);
        } else {
            self.update_each(chunks, nodes, nodal, &mut local);
        }
        *sums = local;
    }

    /// Updates the nodes of any batch one after the other.
    #[inline(always)]
    fn update_each(
        &self,
        chunks: &mut NodeChunks<'_, D>,
        nodes: &[usize],
        nodal: &mut NodalSums<D>,
        sums: &mut KickSums,
    ) {
        let gel = self.gel;
        for (i, a) in nodes.iter().copied().enumerate() {
            let p = nodal.impulse(i);
            let mut node = NodeState::of(chunks, a);
            let passed = node.drift(self.grid, self.tick);
            *node.limit = nodal.limit[i];
            let before = *node.velocity;
            *node.before = before;
            *node.velocity += if gel.is_free(a) { p } else { p.component_mul(&gel.free(a)) } / gel.mass[a];
            if self.damping_rate > 0.0 {
                let drag = node.damp(self.damping_rate, passed, gel.mass[a]);
                sums.damping.energy += 0.5 * drag.dot(&(*node.before + *node.velocity));
                sums.damping.add_impulse(self.freedom, node.position, &drag);
            }
            let excess = self.leading_share * p.dot(&(*node.velocity - before));
            sums.work += 0.5 * p.dot(&(before + *node.velocity)) + *node.excess - excess;
            *node.excess = excess;
            sums.max_speed_squared = sums.max_speed_squared.max(node.velocity.norm_squared());
            if !gel.is_free(a) {
                sums.reaction.add(&gel.free(a), self.freedom, embed(node.position), embed(&p));
            }
            nodal.moves[i] = *node.velocity != Vector::<D>::zeros();
        }
    }

    /// Updates a [contiguous](NodalSums::is_contiguous) batch without damping, each stage for all nodes. The stages
    /// vectorise and give the bits of [`Self::update_each`].
    #[inline(always)]
    fn update_contiguous(
        &self,
        chunks: &mut NodeChunks<'_, D>,
        first: usize,
        nodal: &mut NodalSums<D>,
        sums: &mut KickSums,
    ) {
        let at = first - chunks.first;
        let (position, velocity) = (batch_at(chunks.position, at), batch_at(chunks.velocity, at));
        let (before, last) = (batch_at(chunks.before, at), batch_at(chunks.last, at));
        let (limit, excess) = (batch_at(chunks.limit, at), batch_at(chunks.excess, at));
        let mass: &[f64; NODE_BATCH] = self.gel.mass[first..].first_chunk().expect(FULL_BATCH);
        for i in 0..NODE_BATCH {
            let passed = self.grid.time(self.tick - last[i]);
            for k in 0..D {
                position[i][k] += velocity[i][k] * passed;
            }
        }
        (*last, *limit, *before) = ([self.tick; NODE_BATCH], nodal.limit, *velocity);
        let (parts, held) = (&nodal.parts, self.gel.held_from::<NODE_BATCH>(first));
        let (mut work, mut square) = ([0.0; NODE_BATCH], [0.0; NODE_BATCH]);
        for i in 0..NODE_BATCH {
            // Written by component so that it vectorises. Each sum begins with its first term, as dot products of
            // vectors do.
            let (mut change, mut mean) = (0.0, 0.0);
            for k in 0..D {
                let (p, old) = (parts[k][i], before[i][k]);
                let free = f64::from(held[i] >> k & 1 ^ 1);
                let new = old + p * free / mass[i];
                let (own_change, own_mean, own_square) = (p * (new - old), p * (old + new), new * new);
                let sum = |sum: f64, own: f64| if k == 0 { own } else { sum + own };
                (change, mean, square[i]) = (sum(change, own_change), sum(mean, own_mean), sum(square[i], own_square));
                velocity[i][k] = new;
                nodal.moves[i] |= new != 0.0;
            }
            let residual = self.leading_share * change;
            work[i] = 0.5 * mean + excess[i] - residual;
            excess[i] = residual;
        }
        sums.work = work.iter().fold(sums.work, |sum, work| sum + work);
        sums.max_speed_squared = sums.max_speed_squared.max(greatest(square));
        if held.iter().fold(0, |all, held| all | held) != 0 {
            for (i, at) in position.iter().enumerate() {
                sums.reaction.add(&self.gel.free(first + i), self.freedom, embed(at), embed(&nodal.impulse(i)));
            }
        }
    }
}

/// Returns the greatest of these numbers, ignoring NaN, by pairwise reduction, which vectorises.
#[inline(always)]
fn greatest(mut all: [f64; NODE_BATCH]) -> f64 {
    let mut n = NODE_BATCH;
    while n > 1 {
        n /= 2;
        for i in 0..n {
            all[i] = all[i].max(all[i + n]);
        }
    }
    all[0]
}

/// Returns the batch of entries from a first one on.
#[inline(always)]
fn batch_at<T>(all: &mut [T], first: usize) -> &mut [T; NODE_BATCH] {
    all[first..].first_chunk_mut().expect(FULL_BATCH)
}

/// Mutable data of one node.
struct NodeState<'a, const D: usize> {
    position: &'a mut Vector<D>,
    velocity: &'a mut Vector<D>,
    before: &'a mut Vector<D>,
    last: &'a mut Tick,
    limit: &'a mut f64,
    excess: &'a mut f64,
    decay: &'a mut f64,
}

impl<'a, const D: usize> NodeState<'a, D> {
    /// Borrows the data of a node.
    #[inline(always)]
    fn of(chunks: &'a mut NodeChunks<'_, D>, node: usize) -> Self {
        let i = node - chunks.first;
        let NodeChunks { position, velocity, before, last, limit, excess, decay, .. } = chunks;
        let (position, velocity, before) = (&mut position[i], &mut velocity[i], &mut before[i]);
        let (last, limit, excess, decay) = (&mut last[i], &mut limit[i], &mut excess[i], &mut decay[i]);
        Self { position, velocity, before, last, limit, excess, decay }
    }

    /// Drifts the node to a tick; returns the time passed, s.
    #[inline(always)]
    fn drift(&mut self, grid: TickGrid, tick: Tick) -> f64 {
        let passed = grid.time(tick - *self.last);
        *self.position += *self.velocity * passed;
        *self.last = tick;
        passed
    }

    /// Damps the velocity over the time passed, s; returns the damping impulse on the mass, kg, of the node, N·s.
    fn damp(&mut self, rate: f64, passed: f64, mass: f64) -> Vector<D> {
        *self.decay = decay(rate, passed);
        *self.velocity += *self.before * *self.decay;
        *self.before * (mass * *self.decay)
    }
}

#[cfg(test)]
mod tests {
    use super::super::assembly::StepRule;
    use super::super::kick_sums::ConstraintReaction;
    use super::super::test_cube;
    use super::*;
    use crate::fem::NodeAccumulator;

    /// Result of an update of a batch.
    #[derive(Debug, Clone, PartialEq)]
    struct After {
        vectors: [Vec<Vector<3>>; 3],
        last: Vec<Tick>,
        numbers: [Vec<u64>; 2],
        moves: [bool; NODE_BATCH],
        sums: [u64; 2],
        taken: ConstraintReaction,
    }

    /// Returns test numbers on a wider range.
    fn any(i: usize) -> f64 {
        43.758_545_3 * test_cube::any(i)
    }

    /// Updates a batch in which all nodes have impulses, or `only` one, so that its contribution is not lost in the
    /// sums.
    fn after(beside: bool, only: Option<usize>) -> After {
        let contributes = |i: usize| only.is_none_or(|only| only == i);
        let mut mesh = test_cube::mesh(&[0.0, 0.3, 0.5, 1.0]);
        // Some nodes are held, in one direction, in two or in all.
        mesh.held
            .iter_mut()
            .enumerate()
            .skip(10)
            .step_by(7)
            .for_each(|(i, held)| *held = [true, i % 2 == 0, i % 3 == 0]);
        let (gel, n) = (test_cube::gel(&mesh), mesh.rest.len());
        let grid = TickGrid::new(&[1e-5]);
        let update = NodeUpdate {
            gel: &gel,
            grid,
            freedom: FreeDirections::SPATIAL,
            tick: 4096,
            leading_share: 0.5,
            damping_rate: 0.0,
        };
        let vectors = |of: usize| (0..n).map(|i| Vector::<3>::from_fn(|k, _| any(of + 3 * i + k))).collect::<Vec<_>>();
        // One node is at rest without an impulse.
        let (still, first) = (5, 3);
        let mut velocity = vectors(100);
        velocity[still] = Vector::<3>::zeros();
        let (mut position, mut before, mut sums) = (vectors(0), vectors(200), KickSums::default());
        let mut last: Vec<Tick> = (0..n as Tick).map(|i| 4000 + i % 7).collect();
        let (mut limit, mut excess, mut decay) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        (0..NODE_BATCH).filter(|i| contributes(*i)).for_each(|i| excess[first + i] = 1e-2 * any(300 + i));
        let given: [NodeAccumulator; NODE_BATCH] = std::array::from_fn(|i| {
            let p = |k: usize| if first + i != still && contributes(i) { 1e-3 * any(400 + 3 * i + k) } else { 0.0 };
            [p(0), p(1), p(2), 1e3 * (1.0 + any(500 + i).abs())]
        });
        let nodes: Vec<usize> = (first..first + NODE_BATCH).collect();
        let mut nodal = NodalSums::new(&given, &nodes, StepRule { mass: &gel.mass, cfl: 0.8 });
        nodal.is_contiguous = beside;
        let mut chunks = NodeChunks {
            first: 2,
            position: &mut position[2..],
            velocity: &mut velocity[2..],
            before: &mut before[2..],
            last: &mut last[2..],
            limit: &mut limit[2..],
            excess: &mut excess[2..],
            decay: &mut decay[2..],
            speeds: &mut [],
            sums: &mut [],
        };
        update.apply(&mut chunks, &nodes, &mut nodal, &mut sums);
        assert!(!nodal.moves[still - first] && nodal.moves[0]);
        let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect();
        After {
            vectors: [position, velocity, before],
            last,
            numbers: [bits(limit), bits(excess)],
            moves: nodal.moves,
            sums: [sums.work, sums.max_speed_squared].map(f64::to_bits),
            taken: sums.reaction,
        }
    }

    #[test]
    fn contiguous_and_single_updates_agree_bit_for_bit() {
        for only in (0..NODE_BATCH).map(Some).chain([None]) {
            assert_eq!(after(true, only), after(false, only), "{only:?}");
        }
        assert_ne!(after(true, None).taken, ConstraintReaction::default(), "who is held is pushed");
    }
}
