//! What a tick does to a node that is active: it drifts, is kicked by what it was given, and is damped; some nodes at a time.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::assembly::{Gathered, TOGETHER, WHOLE};
use super::damping::{Damped, fade};
use super::node_loop::{NodeSums, Runs};
use super::{Gel, TickGrid};
use crate::contact::Freedom;
use crate::fem::Potential;
use crate::math::{Vector, embed};
use crate::state::Tick;

/// What is the same for all nodes of a tick.
pub(super) struct Advance<'a, const D: usize, P> {
    pub gel: &'a Gel<D, P>,
    pub grid: TickGrid,
    pub freedom: Freedom,
    pub tick: Tick,
    /// The part of a kick that belongs to the step ahead.
    pub share: f64,
    /// α of the damping, 1/s.
    pub rate: f64,
}

impl<const D: usize, P: Potential<D>> Advance<'_, D, P> {
    /// Drifts and kicks these nodes by what they have gathered, notes whether they move then, and adds what they do to the sums.
    #[inline(always)]
    pub fn go(&self, runs: &mut Runs<'_, D>, nodes: &[usize], gathered: &mut Gathered<D>, sums: &mut NodeSums) {
        // Its own: what nodes are given can't change it.
        let mut found = *sums;
        if self.rate == 0.0 && gathered.beside {
            self.side_by_side(runs, nodes[0], gathered, &mut found);
        } else {
            self.one_by_one(runs, nodes, gathered, &mut found);
        }
        *sums = found;
    }

    /// Whatever nodes these are.
    #[inline(always)]
    fn one_by_one(&self, runs: &mut Runs<'_, D>, nodes: &[usize], gathered: &mut Gathered<D>, sums: &mut NodeSums) {
        let gel = self.gel;
        for (i, a) in nodes.iter().copied().enumerate() {
            let p = gathered.push(i);
            let mut node = Node::of(runs, a);
            let passed = node.drift(self.grid, self.tick);
            *node.limit = gathered.limit[i];
            let before = *node.velocity;
            *node.before = before;
            *node.velocity += if gel.is_free(a) { p } else { p.component_mul(&gel.free(a)) } / gel.mass[a];
            if self.rate > 0.0 {
                node.damp((self.rate, passed), gel.mass[a], (&mut sums.damped, self.freedom));
            }
            let excess = self.share * p.dot(&(*node.velocity - before));
            sums.work += 0.5 * p.dot(&(before + *node.velocity)) + *node.excess - excess;
            *node.excess = excess;
            sums.fastest = sums.fastest.max(node.velocity.norm_squared());
            if !gel.is_free(a) {
                sums.taken.add(&gel.free(a), self.freedom, (embed(node.position), embed(&p)));
            }
            gathered.moves[i] = *node.velocity != Vector::<D>::zeros();
        }
    }

    /// Nodes that stand [beside each other](Gathered::beside) from one on, none of them damped: each stage for all of them, so that they
    /// go side by side through the vector units, with the bits of one by one.
    #[inline(always)]
    fn side_by_side(&self, runs: &mut Runs<'_, D>, first: usize, gathered: &mut Gathered<D>, sums: &mut NodeSums) {
        let at = first - runs.first;
        let (position, velocity) = (whole(runs.position, at), whole(runs.velocity, at));
        let (before, last) = (whole(runs.before, at), whole(runs.last, at));
        let (limit, excess) = (whole(runs.limit, at), whole(runs.excess, at));
        let mass: &[f64; TOGETHER] = self.gel.mass[first..].first_chunk().expect(WHOLE);
        for i in 0..TOGETHER {
            let passed = self.grid.time(self.tick - last[i]);
            for k in 0..D {
                position[i][k] += velocity[i][k] * passed;
            }
        }
        (*last, *limit, *before) = ([self.tick; TOGETHER], gathered.limit, *velocity);
        let (parts, held) = (&gathered.parts, self.gel.held_from::<TOGETHER>(first));
        let (mut work, mut square) = ([0.0; TOGETHER], [0.0; TOGETHER]);
        for i in 0..TOGETHER {
            // Component by component: so they are found to go side by side. Sums begin with what is first, as products of vectors do.
            let (mut change, mut mean) = (0.0, 0.0);
            for k in 0..D {
                let (p, old) = (parts[k][i], before[i][k]);
                let free = f64::from(held[i] >> k & 1 ^ 1);
                let new = old + p * free / mass[i];
                let (own_change, own_mean, own_square) = (p * (new - old), p * (old + new), new * new);
                let sum = |sum: f64, own: f64| if k == 0 { own } else { sum + own };
                (change, mean, square[i]) = (sum(change, own_change), sum(mean, own_mean), sum(square[i], own_square));
                velocity[i][k] = new;
                gathered.moves[i] |= new != 0.0;
            }
            let left = self.share * change;
            work[i] = 0.5 * mean + excess[i] - left;
            excess[i] = left;
        }
        sums.work = work.iter().fold(sums.work, |sum, work| sum + work);
        sums.fastest = sums.fastest.max(greatest(square));
        if held.iter().fold(0, |all, held| all | held) != 0 {
            for (i, at) in position.iter().enumerate() {
                sums.taken.add(&self.gel.free(first + i), self.freedom, (embed(at), embed(&gathered.push(i))));
            }
        }
    }
}

/// The greatest of these that are numbers, two by two: so they go side by side.
#[inline(always)]
fn greatest(mut all: [f64; TOGETHER]) -> f64 {
    let mut n = TOGETHER;
    while n > 1 {
        n /= 2;
        for i in 0..n {
            all[i] = all[i].max(all[i + n]);
        }
    }
    all[0]
}

/// Those that go together from one on.
#[inline(always)]
fn whole<T>(all: &mut [T], first: usize) -> &mut [T; TOGETHER] {
    all[first..].first_chunk_mut().expect(WHOLE)
}

/// What changes of a node.
struct Node<'a, const D: usize> {
    position: &'a mut Vector<D>,
    velocity: &'a mut Vector<D>,
    before: &'a mut Vector<D>,
    last: &'a mut Tick,
    limit: &'a mut f64,
    excess: &'a mut f64,
    fade: &'a mut f64,
}

impl<'a, const D: usize> Node<'a, D> {
    #[inline(always)]
    fn of(runs: &'a mut Runs<'_, D>, node: usize) -> Self {
        let i = node - runs.first;
        let Runs { position, velocity, before, last, limit, excess, fade, .. } = runs;
        let (position, velocity, before) = (&mut position[i], &mut velocity[i], &mut before[i]);
        let (last, limit, excess, fade) = (&mut last[i], &mut limit[i], &mut excess[i], &mut fade[i]);
        Self { position, velocity, before, last, limit, excess, fade }
    }

    /// To a tick; how long it took, s.
    #[inline(always)]
    fn drift(&mut self, grid: TickGrid, tick: Tick) -> f64 {
        let passed = grid.time(tick - *self.last);
        *self.position += *self.velocity * passed;
        *self.last = tick;
        passed
    }

    /// Takes from its speed what damping takes in this time, s, of a mass, kg.
    fn damp(&mut self, (rate, passed): (f64, f64), mass: f64, (damped, freedom): (&mut Damped, Freedom)) {
        *self.fade = fade(rate, passed);
        *self.velocity += *self.before * *self.fade;
        let drag = *self.before * (mass * *self.fade);
        damped.energy += 0.5 * drag.dot(&(*self.before + *self.velocity));
        damped.add(freedom, (self.position, &drag));
    }
}

#[cfg(test)]
mod tests {
    use super::super::assembly::Rule;
    use super::super::kick::Taken;
    use super::super::test_cube;
    use super::*;
    use crate::fem::Accumulated;

    /// What becomes of the nodes of a run.
    #[derive(Debug, Clone, PartialEq)]
    struct After {
        vectors: [Vec<Vector<3>>; 3],
        last: Vec<Tick>,
        numbers: [Vec<u64>; 2],
        moves: [bool; TOGETHER],
        sums: [u64; 2],
        taken: Taken,
    }

    /// The same, and farther apart.
    fn any(i: usize) -> f64 {
        43.758_545_3 * test_cube::any(i)
    }

    /// All of them have something to give, or only one, so that what it does is not lost in the sums.
    fn after(beside: bool, only: Option<usize>) -> After {
        let gives = |i: usize| only.is_none_or(|only| only == i);
        let mut mesh = test_cube::mesh(&[0.0, 0.3, 0.5, 1.0]);
        // Some are held, in one direction, in two or in all.
        mesh.held
            .iter_mut()
            .enumerate()
            .skip(10)
            .step_by(7)
            .for_each(|(i, held)| *held = [true, i % 2 == 0, i % 3 == 0]);
        let (gel, n) = (test_cube::gel(&mesh), mesh.rest.len());
        let grid = TickGrid::new(&[1e-5]);
        let advance = Advance { gel: &gel, grid, freedom: Freedom::SPATIAL, tick: 4096, share: 0.5, rate: 0.0 };
        let vectors = |of: usize| (0..n).map(|i| Vector::<3>::from_fn(|k, _| any(of + 3 * i + k))).collect::<Vec<_>>();
        // One stands still, and is given nothing.
        let (still, first) = (5, 3);
        let mut velocity = vectors(100);
        velocity[still] = Vector::<3>::zeros();
        let (mut position, mut before) = (vectors(0), vectors(200));
        let mut last: Vec<Tick> = (0..n as Tick).map(|i| 4000 + i % 7).collect();
        let (mut limit, mut excess) = (vec![0.0; n], vec![0.0; n]);
        (0..TOGETHER).filter(|i| gives(*i)).for_each(|i| excess[first + i] = 1e-2 * any(300 + i));
        let (mut fade, mut sums) = (vec![0.0; n], NodeSums::default());
        let given: [Accumulated; TOGETHER] = std::array::from_fn(|i| {
            let p = |k: usize| if first + i != still && gives(i) { 1e-3 * any(400 + 3 * i + k) } else { 0.0 };
            [p(0), p(1), p(2), 1e3 * (1.0 + any(500 + i).abs())]
        });
        let nodes: Vec<usize> = (first..first + TOGETHER).collect();
        let mut gathered = Gathered::new(&given, &nodes, Rule { mass: &gel.mass, cfl: 0.8 });
        gathered.beside = beside;
        let mut runs = Runs {
            first: 2,
            position: &mut position[2..],
            velocity: &mut velocity[2..],
            before: &mut before[2..],
            last: &mut last[2..],
            limit: &mut limit[2..],
            excess: &mut excess[2..],
            fade: &mut fade[2..],
            sums: &mut [],
        };
        advance.go(&mut runs, &nodes, &mut gathered, &mut sums);
        assert!(!gathered.moves[still - first] && gathered.moves[0]);
        let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect();
        After {
            vectors: [position, velocity, before],
            last,
            numbers: [bits(limit), bits(excess)],
            moves: gathered.moves,
            sums: [sums.work, sums.fastest].map(f64::to_bits),
            taken: sums.taken,
        }
    }

    #[test]
    fn side_by_side_nodes_come_to_the_bits_of_one_by_one() {
        for only in (0..TOGETHER).map(Some).chain([None]) {
            assert_eq!(after(true, only), after(false, only), "{only:?}");
        }
        assert_ne!(after(true, None).taken, Taken::default(), "who is held is pushed");
    }
}
