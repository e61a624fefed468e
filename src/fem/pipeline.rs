//! A sweep over groups of patches, some of them abreast: each stage for all of them before the next, as every group by itself is one long
//! chain of operations, from its positions to ln J to its forces, and a processor that has only one of them waits.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, fused, on, sum, wide};
use super::history::Recall;
use super::inversion_time::closing;
use super::layout::{Asked, Found, GroupAnswer, Kick, Kicks, Law, Power, volumetric};
use super::node_cache::{Local, Rows};
use super::simd_material::{Slopes, Solid, Strains, Undeformed};
use super::transpose::{gather, scatter};
use super::{FORESEEN, Lanes, Section, Spent, TURNED, places};
use crate::constitutive::NeoHookean;
use crate::math::Number;
use fearless_simd::{Level, Simd, SimdBase, SimdSplit, f64x8};
use std::any::Any;

/// More than rounding makes of a bound.
const ROUNDING: f64 = 1.001;

/// Batches abreast: one group in patches of four places, several of others. One after the other a plain tetrahedron takes 15.2 ns in the
/// place of 14.1; with 8 or 16 it takes as long as with 4.
const ABREAST: usize = 4;

/// Groups on their way through the stages: batches of the g-th from g times those of a group on.
struct Together<const D: usize, V> {
    /// Which groups these are, and their kicks.
    groups: [(usize, Kick); ABREAST],
    n_groups: usize,
    strains: [Strains<D, V>; ABREAST],
    slopes: [Slopes<V>; ABREAST],
    /// Of each group 1 in the lanes of patches that are strained, else 0, and what a change of volume stores, J.
    strained: [V; ABREAST],
    energy: [V; ABREAST],
}

impl<const D: usize, V: Number> Together<D, V> {
    #[inline(always)]
    fn new(zero: V) -> Self {
        Self {
            groups: [(0, Kick { length: 0.0, elapsed: 0.0 }); ABREAST],
            n_groups: 0,
            strains: [Strains::at_rest(zero); ABREAST],
            slopes: [Slopes { slope: zero, curvature: zero }; ABREAST],
            strained: [zero; ABREAST],
            energy: [zero; ABREAST],
        }
    }

    /// Takes the next of these groups that are swept, of `N` batches each; the first that is left.
    #[inline(always)]
    fn take<const N: usize>(&mut self, (first, end): (usize, usize), kicks: Kicks<'_>) -> usize {
        const { assert!(N <= ABREAST, "a group goes through the stages as a whole") };
        let mut next = first;
        self.n_groups = 0;
        while next < end && self.n_groups < ABREAST / N {
            let kick = match kicks {
                Kicks::Same(kick) => Some(kick),
                Kicks::Each(kick) => kick(next),
            };
            if let Some(kick) = kick {
                self.groups[self.n_groups] = (next, kick);
                self.n_groups += 1;
            }
            next += 1;
        }
        next
    }
}

impl<const D: usize> Lanes<D> {
    /// Sweeps over those groups of a run that have a kick: accumulates Σ length · f and Σ κ at the nodes of the block, and
    /// writes κ of each slot, the answer of each group, and what its elements remember then, all from the first group on.
    ///
    /// # Panics
    /// In neither two nor three dimensions.
    pub fn sweep(&self, level: Level, asked: Asked<'_>, local: &mut Local, found: Found<'_>) {
        // Not generic, so that the kernels are compiled here and not again by all who step an engine of their own.
        let lanes: &dyn Any = self;
        if let Some(lanes) = lanes.downcast_ref() {
            sweep_plane(lanes, level, asked, local, found);
        } else {
            sweep_space(lanes.downcast_ref().expect("the gel has two or three dimensions"), level, asked, local, found);
        }
    }

    /// With patches of one or `N` places.
    #[inline(always)]
    fn sweep_laws<const N: usize>(&self, level: Level, asked: Asked<'_>, local: &mut Local, found: Found<'_>) {
        match self.law() {
            Law::Elastic(gel, rest) => self.sweep_of::<N, _>((level, gel, rest), asked, local, found),
            Law::Flowing(gel, rest) => self.sweep_of::<N, _>((level, gel, rest), asked, local, found),
            Law::Relaxing(gel, rest) => self.sweep_of::<N, _>((level, gel, rest), asked, local, found),
        }
    }

    fn sweep_of<const N: usize, G: Solid<D>>(
        &self,
        (level, gel, rest): (Level, &G, &[G::Rest]),
        asked: Asked<'_>,
        local: &mut Local,
        found: Found<'_>,
    ) {
        if self.depth() == 1 {
            on!(level, simd => self.sweep_in::<1, _, _>((simd, gel, rest), asked, local, found));
        } else {
            on!(level, simd => self.sweep_in::<N, _, _>((simd, gel, rest), asked, local, found));
        }
    }

    #[inline(always)]
    fn sweep_in<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (simd, gel, rest): (S, &G, &[G::Rest]),
        (groups, kicks, power): Asked<'_>,
        local: &mut Local,
        (stiffness, answers, memory): Found<'_>,
    ) {
        // Loops, here and below: a closure is not compiled for the vector unit that its caller is compiled for.
        let (mut next, rows, fastest) = (groups.start, N * gel.rows(), local.fastest);
        let (motion, accumulated) = local.at_work();
        // Their own: what is written elsewhere can't change them.
        let (gel, mut spent) = (&{ *gel }, Spent::default());
        let mut all = Together::new(f64x8::splat(simd, 0.0));
        while next < groups.end {
            next = all.take::<N>((next, groups.end), kicks);
            self.fetch::<N, G>(rest, next);
            self.strain_all::<N, G, S>(rest, motion[0], &mut all);
            self.press_all::<N, G, S>(gel, &mut all);
            for g in 0..all.n_groups {
                let at = all.groups[g].0 - groups.start;
                let (stiffness, memory) =
                    (&mut stiffness[at * LANES * N..][..LANES * N], &mut memory[at * rows..][..rows]);
                let (answer, its) = self.pull_group::<N, G, S>(
                    (gel, rest, power),
                    (&all, g),
                    ((motion, fastest), &mut *accumulated),
                    (stiffness, memory),
                );
                answers[at] = answer;
                spent += its;
            }
        }
        local.spent = spent;
    }

    /// Asks for as many of the groups from this one on as go abreast, while those before them are on their way; also for what is of
    /// another run.
    #[inline(always)]
    fn fetch<const N: usize, G: Solid<D>>(&self, rest: &[G::Rest], first: usize) {
        let rest = rest.get(first * N..).unwrap_or_default();
        for (batch, rest) in self.batches_from(first * N).iter().zip(rest).take(ABREAST) {
            batch.fetch();
            rest.fetch();
        }
    }

    /// The strains and J of every element.
    #[inline(always)]
    fn strain_all<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        rest: &[G::Rest],
        positions: &Rows,
        all: &mut Together<D, f64x8<S>>,
    ) {
        for g in 0..all.n_groups {
            let group = all.groups[g].0;
            let of_group = (group, self.batches_of::<N>(group), own::<N, _>(rest, group));
            all.strained[g] = self.strain_group::<N, G, S>(of_group, positions, &mut all.strains[g * N..][..N]);
        }
    }

    /// J̄ of every patch, and the pressures that follow from it.
    #[inline(always)]
    fn press_all<const N: usize, G: Solid<D>, S: Simd>(&self, gel: &G, all: &mut Together<D, f64x8<S>>) {
        for g in 0..all.n_groups {
            let (batches, at) = (self.batches_of::<N>(all.groups[g].0), g * N..(g + 1) * N);
            all.energy[g] = volumetric::<D, N, S>(gel, batches, &all.strains[at.clone()], &mut all.slopes[at]);
        }
    }

    /// The forces of a group, and what it stores and has lost.
    #[inline(always)]
    fn pull_group<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (gel, rest, power): (&G, &[G::Rest], Power),
        (all, g): (&Together<D, f64x8<S>>, usize),
        ((motion, fastest), accumulated): (([&Rows; 2], f64), &mut Rows),
        (stiffness, memory): (&mut [f64], &mut [Recall]),
    ) -> (GroupAnswer, Spent) {
        let ((group, kick), strained, mut energy) = (all.groups[g], all.strained[g], all.energy[g]);
        let (batches, rest) = (self.batches_of::<N>(group), own::<N, _>(rest, group));
        let (simd, rows) = (energy.simd, gel.rows());
        let zero = f64x8::splat(simd, 0.0);
        let (mut given, mut lost) = (zero, [zero; 3]);
        let mut answer = GroupAnswer { least_jacobian: f64::INFINITY, ..GroupAnswer::default() };
        for k in 0..N {
            let (strains, slopes) = (&all.strains[g * N + k], &all.slopes[g * N + k]);
            let own = &mut memory[k * rows..(k + 1) * rows];
            let pull = gel.pull(self.section(), (&batches[k], &rest[k], kick, own), (strains, slopes));
            let (jacobian, resists) = (strains.jacobian(), wide(simd, &batches[k].volume) * slopes.curvature);
            if may_close::<D, S>((pull.stiffness, resists), jacobian, (kick.elapsed, fastest)) {
                answer.closing = answer.closing.max(greatest(self.closing(jacobian, &batches[k], motion)));
            }
            energy = fused(pull.energy, strained, energy);
            for i in 0..3 {
                lost[i] += pull.lost[i];
            }
            if power == Power::Told {
                given = fused(pull.power(&batches[k].nodes, motion[1]), strained, given);
            }
            scatter::<D, S>(&batches[k].nodes, &pull.kicks(strained * kick.length), accumulated);
            pull.stiffness.store_slice(&mut stiffness[k * LANES..(k + 1) * LANES]);
            note(&mut answer, k, jacobian);
        }
        (answer.energy, answer.power) = (sum(energy), sum(given));
        let [plastic, viscous, damage] = [sum(lost[0]), sum(lost[1]), sum(lost[2])];
        (answer, Spent { energy: answer.energy, plastic, viscous, damage })
    }

    /// How fast eight elements of these J close, 1/s.
    #[inline(always)]
    fn closing<S: Simd>(&self, jacobian: f64x8<S>, batch: &Batch, [positions, velocities]: [&Rows; 2]) -> f64x8<S> {
        let simd = jacobian.simd;
        let x = gather::<D, S>(simd, &batch.nodes, positions);
        let v = gather::<D, S>(simd, &batch.nodes, velocities);
        let zero = f64x8::splat(simd, 0.0);
        let (mut edges, mut rates) = ([[zero; D]; D], [[zero; D]; D]);
        for i in 0..D {
            for a in 0..D {
                (edges[i][a], rates[i][a]) = (x[a + 1][i] - x[0][i], v[a + 1][i] - v[0][i]);
            }
        }
        let radial = (x[0][0] + x[1][0] + x[2][0], v[0][0] + v[1][0] + v[2][0]);
        let ring = if self.section() == Section::Axisymmetric { Some(radial) } else { None };
        closing(jacobian, (&edges, &rates), ring)
    }
}

/// Those of a group.
#[inline(always)]
fn own<const N: usize, R>(rest: &[R], group: usize) -> &[R; N] {
    rest[group * N..].first_chunk().expect("a group is whole")
}

#[inline(never)]
fn sweep_plane(lanes: &Lanes<2>, level: Level, asked: Asked<'_>, local: &mut Local, found: Found<'_>) {
    lanes.sweep_laws::<{ places(2) }>(level, asked, local, found);
}

#[inline(never)]
fn sweep_space(lanes: &Lanes<3>, level: Level, asked: Asked<'_>, local: &mut Local, found: Found<'_>) {
    lanes.sweep_laws::<{ places(3) }>(level, asked, local, found);
}

/// Whether one of eight elements with these κ and w U″, N/m and J, can be [`TURNED`] within [`FORESEEN`] of these steps, s, where no node
/// has a greater |v|², m²/s²: |J′| ≤ (Σ |∂J/∂x_a|² Σ |v_a|²)^½, and κ ≥ w U″ Σ |∂J/∂x_a|². Of a mesh that begins no step is known.
#[inline(always)]
fn may_close<const D: usize, S: Simd>(
    (stiffness, resists): (f64x8<S>, f64x8<S>),
    jacobian: f64x8<S>,
    (step, fastest): (f64, f64),
) -> bool {
    let within = FORESEEN * step;
    let most = (D + 1) as f64 * fastest * within * within * ROUNDING;
    let from = jacobian + TURNED;
    step == 0.0 || (stiffness * most - resists * from * from).any_positive()
}

/// The greatest of eight.
#[inline(always)]
fn greatest<S: Simd>(eight: f64x8<S>) -> f64 {
    let (low, high) = eight.split();
    let (low, high) = low.max(high).split();
    let [a, b] = low.max(high).into();
    if a > b { a } else { b }
}

/// Enters J of the k-th elements.
#[inline(always)]
fn note<S: Simd>(answer: &mut GroupAnswer, k: usize, jacobian: f64x8<S>) {
    let simd = jacobian.simd;
    let inverted = simd.to_bitmask_mask64x8(jacobian.simd_le(f64x8::splat(simd, 0.0))) as u32;
    let crushed = simd.to_bitmask_mask64x8(jacobian.simd_lt(f64x8::splat(simd, NeoHookean::FLOOR)));
    let least = -greatest(-jacobian);
    answer.least_jacobian = if least < answer.least_jacobian { least } else { answer.least_jacobian };
    answer.inverted |= inverted << (k * LANES);
    answer.crushed += crushed.count_ones();
}
