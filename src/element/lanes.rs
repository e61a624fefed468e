//! Elements laid out for vector units: eight patches side by side, every quantity of the eight in one vector.
//!
//! The arithmetic is that of [`super::Simplices`] written per lane, so that every instruction set gives the same bits: products are
//! fused into sums where they are written so and nowhere else (numerics A9). AVX2 and AVX-512 have an instruction for that; a
//! processor that has neither calls a function, and is slow. What is gathered and scattered goes through rows of eight numbers per
//! node, turned four by four.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::local::{Accumulated, Local};
use super::recall::Recall;
use super::shuffle::{gather, scatter};
use super::{MAX_NODES, Section, Spent};
use crate::algebra::Number;
use crate::material::{Flowing, NeoHookean, Volumetric};
use fearless_simd::{Level, Select, Simd, SimdBase, SimdSplit, dispatch, f64x8};
use std::ops::Range;

/// Patches side by side.
pub const LANES: usize = 8;
/// Most elements of a patch.
pub const DEPTH: usize = 4;
pub(super) type Wide = [f64; LANES];

/// The k-th elements of eight patches.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Batch<const D: usize> {
    /// ∇N_a at rest for a = 1..=D, 1/m.
    pub(super) gradients: [[Wide; D]; D],
    /// w, rest volume, m³; 0 in an empty lane.
    pub(super) volume: Wide,
    /// Σ_a |∇N_a|², without the share of a ring, 1/m².
    pub(super) spread: Wide,
    /// Numbers of the nodes within the block.
    nodes: [[u16; LANES]; MAX_NODES],
}

/// What a group of patches answers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupAnswer {
    /// Σ V, J.
    pub energy: f64,
    /// Σ f·v, W.
    pub power: f64,
    /// Least J.
    pub least_jacobian: f64,
    /// Which elements have J ≤ 0: bit 8k + l for the k-th element of the patch in lane l.
    pub inverted: u32,
    /// How many elements are below the continuation.
    pub crushed: u32,
    /// Lost since the tick before of the group to plastic flow, viscosity and softening, J.
    pub lost: [f64; 3],
}

impl GroupAnswer {
    /// What it stores and has lost.
    #[must_use]
    pub fn spent(&self) -> Spent {
        let [plastic, viscous, damage] = self.lost;
        Spent { energy: self.energy, plastic, viscous, damage }
    }
}

/// The kick of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kick {
    /// Its length, s.
    pub length: f64,
    /// From the tick before of the group until now, s.
    pub elapsed: f64,
}

/// What elements in lanes are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    Elastic(NeoHookean),
    Flowing(Flowing),
}

/// Energies and forces of a material in lanes.
pub(super) trait Solid<const D: usize> {
    /// U of an element that is a patch by itself.
    fn volumetric<T: Number>(&self, j: T) -> Volumetric<T>;
    /// That of the element of a patch.
    fn own<T: Number>(&self, j: T) -> Volumetric<T>;
    /// That of the patch.
    fn shared<T: Number>(&self, mean: T) -> Volumetric<T>;
    /// Puts f_a times the length of the kick, and κ, into `kicks`; what elements remember goes on.
    fn forces<S: Simd>(
        &self,
        section: Section,
        of: (&Batch<D>, Kick, &mut [Recall<D>]),
        element: Element<'_, D, f64x8<S>>,
        kicks: &mut [[f64x8<S>; 4]; MAX_NODES],
    ) -> Sums<f64x8<S>>;
}

/// Of eight elements: what they store, but for the volumetric part, J, Σ f·v, W, and what they have lost as a [`GroupAnswer`] has it, J.
#[derive(Clone, Copy)]
pub(super) struct Sums<V> {
    pub energy: V,
    pub power: V,
    pub lost: [V; 3],
}

/// F and λ of eight elements where their nodes are at rest.
#[derive(Debug, Clone, Copy)]
struct Base<const D: usize> {
    f: [[Wide; D]; D],
    out: Wide,
}

/// Elements in lanes.
#[derive(Debug, Clone)]
pub struct Lanes<const D: usize> {
    batches: Vec<Batch<D>>,
    /// One for each batch, if there is an element that its nodes do not say at rest; else none.
    bases: Vec<Base<D>>,
    depth: usize,
    law: Law,
    section: Section,
}

/// F, cof F, λ, 1/(3R̄), det F and J of eight elements.
#[derive(Clone, Copy)]
pub(super) struct Strains<const D: usize, V> {
    pub f: [[V; D]; D],
    pub cofactor: [[V; D]; D],
    pub out: V,
    pub hoop: V,
    pub inner: V,
    pub jacobian: V,
}

/// Eight elements: their strains and slopes, and the rows of their nodes.
pub(super) type Element<'a, const D: usize, V> = (&'a Strains<D, V>, &'a Slopes<V>, &'a [[V; 8]; MAX_NODES]);

/// U′ and max(U″, 0) of eight elements with their shares of their patches'.
#[derive(Clone, Copy)]
pub(super) struct Slopes<V> {
    pub slope: V,
    pub curvature: V,
}

impl<const D: usize> Batch<D> {
    /// Nothing in any lane.
    fn empty() -> Self {
        Self {
            gradients: [[[0.0; LANES]; D]; D],
            volume: [0.0; LANES],
            spread: [0.0; LANES],
            nodes: [[0; LANES]; MAX_NODES],
        }
    }
}

impl<const D: usize> Lanes<D> {
    /// Empty lanes for so many slots, `depth` elements to a patch.
    ///
    /// # Panics
    /// If the slots do not fill their batches, or `depth` is none of 1, 2 and 4.
    #[must_use]
    pub(super) fn empty(n_slots: usize, depth: usize, law: (Law, Section)) -> Self {
        assert!(n_slots.is_multiple_of(LANES * depth), "slots fill whole groups");
        assert!(matches!(depth, 1 | 2 | 4), "a patch has one, two or four places");
        Self { batches: vec![Batch::empty(); n_slots / LANES], bases: vec![], depth, law: law.0, section: law.1 }
    }

    /// Puts an element into a slot: ∇N_a for a = 1..=D, w, and the numbers of its nodes.
    pub(super) fn put(&mut self, slot: usize, (gradients, volume): (&[[f64; D]; D], f64), nodes: [u16; MAX_NODES]) {
        let (batch, lane) = (&mut self.batches[slot / LANES], slot % LANES);
        for (wide, gradient) in batch.gradients.iter_mut().zip(gradients) {
            for (wide, component) in wide.iter_mut().zip(gradient) {
                wide[lane] = *component;
            }
        }
        batch.volume[lane] = volume;
        let first = std::array::from_fn::<f64, D, _>(|i| gradients.iter().map(|gradient| gradient[i]).sum());
        batch.spread[lane] = gradients.iter().chain([&first]).flatten().map(|component| component * component).sum();
        for (wide, node) in batch.nodes.iter_mut().zip(nodes) {
            wide[lane] = node;
        }
    }

    /// Of an element in a slot, that F and λ are these where its nodes are at rest, and not 1; F row by row.
    pub(super) fn set_base(&mut self, slot: usize, (f, out): ([[f64; D]; D], f64)) {
        if self.bases.is_empty() {
            let one = |i: usize, j: usize| if i == j { [1.0; LANES] } else { [0.0; LANES] };
            let none = Base { f: std::array::from_fn(|i| std::array::from_fn(|j| one(i, j))), out: [1.0; LANES] };
            self.bases = vec![none; self.batches.len()];
        }
        let (base, lane) = (&mut self.bases[slot / LANES], slot % LANES);
        for (wide, row) in base.f.iter_mut().zip(&f) {
            wide.iter_mut().zip(row).for_each(|(wide, component)| wide[lane] = *component);
        }
        base.out[lane] = out;
    }

    /// Elements to a patch.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Shows the numbers, within the block, of the nodes of the elements of a group, again and again where they share them.
    pub fn nodes(&self, group: usize, mut see: impl FnMut(u16)) {
        for batch in &self.batches[group * self.depth..(group + 1) * self.depth] {
            for lane in (0..LANES).filter(|lane| batch.volume[*lane] > 0.0) {
                batch.nodes[..=D].iter().for_each(|wide| see(wide[lane]));
            }
        }
    }

    /// Σ κ at the nodes of a block, in the order of a sweep over all its groups: the same bits.
    pub fn sum_stiffness(&self, groups: Range<usize>, stiffness: &[f64], part: &mut [Accumulated]) {
        for sum in part.iter_mut() {
            sum[3] = 0.0;
        }
        let batches = &self.batches[groups.start * self.depth..groups.end * self.depth];
        for (batch, stiffness) in batches.iter().zip(stiffness.chunks_exact(LANES)) {
            // Loops: as a chain of iterators this takes six times as long.
            let mut add = |a: usize, lane: usize| part[usize::from(batch.nodes[a][lane])][3] += stiffness[lane];
            for a in 0..=D {
                (0..LANES).for_each(|lane| add(a, lane));
            }
        }
    }

    /// Bytes held.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.batches.len() * size_of::<Batch<D>>() + self.bases.len() * size_of::<Base<D>>()
    }

    /// What fresh elements remember, batch by batch; nothing of those that remember nothing.
    #[must_use]
    pub fn memory(&self) -> Vec<Recall<D>> {
        let n = if matches!(self.law, Law::Flowing(_)) { self.batches.len() } else { 0 };
        vec![Recall::default(); n]
    }

    /// Sweeps over those groups of a run for which there is a `kick`: accumulates Σ length · f and Σ κ at the nodes of the block, and
    /// writes κ of each slot, the answer of each group, and what its elements remember then, all from the first group on.
    pub fn sweep(
        &self,
        level: Level,
        (groups, kick): (Range<usize>, impl Fn(usize) -> Option<Kick>),
        local: &mut Local,
        found: (&mut [f64], &mut [GroupAnswer], &mut [Recall<D>]),
    ) {
        match &self.law {
            Law::Elastic(gel) => self.sweep_of(gel, level, (groups, kick), local, found),
            Law::Flowing(gel) => self.sweep_of(gel, level, (groups, kick), local, found),
        }
    }

    fn sweep_of(
        &self,
        gel: &impl Solid<D>,
        level: Level,
        (groups, kick): (Range<usize>, impl Fn(usize) -> Option<Kick>),
        local: &mut Local,
        found: (&mut [f64], &mut [GroupAnswer], &mut [Recall<D>]),
    ) {
        match self.depth {
            1 => dispatch!(level, simd => self.sweep_in::<1, _, _>((simd, gel), (groups, kick), local, found)),
            2 => dispatch!(level, simd => self.sweep_in::<2, _, _>((simd, gel), (groups, kick), local, found)),
            _ => dispatch!(level, simd => self.sweep_in::<4, _, _>((simd, gel), (groups, kick), local, found)),
        }
    }

    #[inline(always)]
    fn sweep_in<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        with: (S, &G),
        (groups, kick): (Range<usize>, impl Fn(usize) -> Option<Kick>),
        local: &mut Local,
        (stiffness, answers, memory): (&mut [f64], &mut [GroupAnswer], &mut [Recall<D>]),
    ) {
        let first = groups.start;
        for ((group, stiffness), answer) in groups.zip(stiffness.chunks_exact_mut(LANES * N)).zip(answers) {
            let Some(kick) = kick(group) else { continue };
            let batches: &[Batch<D>; N] = self.batches[group * N..].first_chunk().expect("a group is whole");
            let bases: &[Base<D>] = self.bases.get(group * N..(group + 1) * N).unwrap_or_default();
            let own = (group - first) * N..(group - first + 1) * N;
            let memory = memory.get_mut(own).unwrap_or_default();
            *answer = self.sweep_group(with, (batches, bases, kick), local, (stiffness, memory));
        }
    }

    /// One group: first F and J of every element, then J̄ of every patch, then the forces.
    #[inline(always)]
    fn sweep_group<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (simd, gel): (S, &G),
        (batches, bases, kick): (&[Batch<D>; N], &[Base<D>], Kick),
        local: &mut Local,
        (stiffness, memory): (&mut [f64], &mut [Recall<D>]),
    ) -> GroupAnswer {
        // Loops, here and below: a closure is not compiled for the vector unit that its caller is compiled for.
        let zero = f64x8::splat(simd, 0.0);
        let mut rows = [gather::<D, S>(simd, &batches[0].nodes, &local.rows); N];
        let mut strains = [Strains::at_rest(zero); N];
        for k in 0..N {
            if k > 0 {
                rows[k] = gather::<D, S>(simd, &batches[k].nodes, &local.rows);
            }
            self.strain((&batches[k], bases.get(k)), &rows[k], &mut strains[k]);
        }
        let mut slopes = [Slopes { slope: zero, curvature: zero }; N];
        let energy = volumetric(gel, batches, &strains, &mut slopes);
        let mut total = Sums { energy, power: zero, lost: [zero; 3] };
        let mut answer = GroupAnswer { least_jacobian: f64::INFINITY, ..GroupAnswer::default() };
        for k in 0..N {
            let mut kicks = [[zero; 4]; MAX_NODES];
            let element = (&strains[k], &slopes[k], &rows[k]);
            let own = memory.get_mut(k..=k).unwrap_or_default();
            let sums = gel.forces(self.section, (&batches[k], kick, own), element, &mut kicks);
            (total.energy, total.power) = (total.energy + sums.energy, total.power + sums.power);
            for i in 0..3 {
                total.lost[i] += sums.lost[i];
            }
            scatter::<D, S>(&batches[k].nodes, &kicks, &mut local.accumulated);
            kicks[0][3].store_slice(&mut stiffness[k * LANES..(k + 1) * LANES]);
            note(&mut answer, k, strains[k].jacobian);
        }
        (answer.energy, answer.power) = (sum(total.energy), sum(total.power));
        for i in 0..3 {
            answer.lost[i] = sum(total.lost[i]);
        }
        answer
    }

    /// F = 1 + Σ (u_a − u_0) ⊗ ∇N_a and what follows from it.
    #[inline(always)]
    fn strain<S: Simd>(
        &self,
        (batch, base): (&Batch<D>, Option<&Base<D>>),
        rows: &[[f64x8<S>; 8]; MAX_NODES],
        s: &mut Strains<D, f64x8<S>>,
    ) {
        let simd = rows[0][0].simd;
        let mut edges = [[rows[0][0]; D]; D];
        for a in 0..D {
            for i in 0..D {
                edges[a][i] = rows[a + 1][i] - rows[0][i];
            }
        }
        for i in 0..D {
            for j in 0..D {
                let gradient = |a: usize| wide(simd, &batch.gradients[a][j]);
                let mut f = edges[0][i] * gradient(0);
                for a in 1..D {
                    f = fused(edges[a][i], gradient(a), f);
                }
                s.f[i][j] = match base {
                    Some(base) => f + wide(simd, &base.f[i][j]),
                    None if i == j => f + 1.0,
                    None => f,
                };
            }
        }
        s.inner = cofactor(&s.f, &mut s.cofactor);
        s.jacobian = s.inner;
        if self.section == Section::Axisymmetric {
            s.hoop = ring(simd, batch);
            let more = (rows[0][0] + rows[1][0] + rows[2][0]) * s.hoop;
            s.out = match base {
                Some(base) => more + wide(simd, &base.out),
                None => more + 1.0,
            };
            s.jacobian = s.inner * s.out;
        }
    }
}

impl<const D: usize, V: Number> Strains<D, V> {
    #[inline(always)]
    fn at_rest(zero: V) -> Self {
        let (none, one) = ([[zero; D]; D], zero + 1.0);
        Self { f: none, cofactor: none, out: one, hoop: zero, inner: one, jacobian: one }
    }
}

/// Volumetric energy, J, and slope and curvature of each element: U(J) of an element that is a patch by itself; else
/// U_s(J) of each and U_v(J̄) of the patch (numerics 5).
#[inline(always)]
fn volumetric<const D: usize, const N: usize, S: Simd>(
    gel: &impl Solid<D>,
    batches: &[Batch<D>; N],
    strains: &[Strains<D, f64x8<S>>; N],
    slopes: &mut [Slopes<f64x8<S>>; N],
) -> f64x8<S> {
    let simd = strains[0].jacobian.simd;
    if N == 1 {
        let u = gel.volumetric(strains[0].jacobian);
        slopes[0] = Slopes { slope: u.slope, curvature: u.curvature.at_least(0.0) };
        return wide(simd, &batches[0].volume) * u.energy;
    }
    let mut volume = wide(simd, &batches[0].volume);
    let mut now = volume * strains[0].jacobian;
    for k in 1..N {
        let own = wide(simd, &batches[k].volume);
        (volume, now) = (volume + own, now + own * strains[k].jacobian);
    }
    // An empty lane has no volume; the smallest number keeps it from 0/0.
    let shared = gel.shared(now / volume.at_least(f64::MIN_POSITIVE));
    let mut energy = volume * shared.energy;
    for k in 0..N {
        let own = gel.own(strains[k].jacobian);
        energy += wide(simd, &batches[k].volume) * own.energy;
        slopes[k].slope = own.slope + shared.slope;
        slopes[k].curvature = own.curvature.at_least(0.0) + shared.curvature.at_least(0.0);
    }
    energy
}

#[inline(always)]
pub(super) fn wide<S: Simd>(simd: S, eight: &Wide) -> f64x8<S> {
    f64x8::from_slice(simd, eight)
}

/// 1/(3R̄) from w = 2πR̄A and det(∇N_1, ∇N_2) = 1/(2A), 1/m; 0 in an empty lane.
#[inline(always)]
fn ring<const D: usize, S: Simd>(simd: S, batch: &Batch<D>) -> f64x8<S> {
    let g = |a: usize, i: usize| wide(simd, &batch.gradients[a][i]);
    let across = g(0, 0) * g(1 % D, 1) - g(0, 1) * g(1 % D, 0);
    let volume = wide(simd, &batch.volume) * across * 3.0;
    let filled = volume.simd_gt(f64x8::splat(simd, 0.0));
    let ring = f64x8::splat(simd, std::f64::consts::PI) / volume;
    filled.select(ring, f64x8::splat(simd, 0.0))
}

/// cof F; returns det F.
#[inline(always)]
fn cofactor<const D: usize, S: Simd>(f: &[[f64x8<S>; D]; D], c: &mut [[f64x8<S>; D]; D]) -> f64x8<S> {
    if D == 2 {
        (c[0][0], c[0][1], c[1][0], c[1][1]) = (f[1][1], -f[1][0], -f[0][1], f[0][0]);
        return fused(f[0][0], f[1][1], -(f[0][1] * f[1][0]));
    }
    for i in 0..D {
        for j in 0..D {
            let (k, l, m, n) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
            c[i][j] = fused(f[k][m], f[l][n], -(f[k][n] * f[l][m]));
        }
    }
    fused(f[0][0], c[0][0], fused(f[0][1], c[0][1], f[0][2 % D] * c[0][2 % D]))
}

/// a b + c, rounded once.
#[inline(always)]
pub(super) fn fused<S: Simd>(a: f64x8<S>, b: f64x8<S>, c: f64x8<S>) -> f64x8<S> {
    a.simd.mul_add_precise_f64x8(a, b, c)
}

/// Enters J of the k-th elements.
#[inline(always)]
fn note<S: Simd>(answer: &mut GroupAnswer, k: usize, jacobian: f64x8<S>) {
    let simd = jacobian.simd;
    let inverted = simd.to_bitmask_mask64x8(jacobian.simd_le(f64x8::splat(simd, 0.0))) as u32;
    let crushed = simd.to_bitmask_mask64x8(jacobian.simd_lt(f64x8::splat(simd, NeoHookean::FLOOR)));
    let (low, high) = jacobian.split();
    let (low, high) = low.min(high).split();
    let [a, b] = low.min(high).into();
    let least = if a < b { a } else { b };
    answer.least_jacobian = if least < answer.least_jacobian { least } else { answer.least_jacobian };
    answer.inverted |= inverted << (k * LANES);
    answer.crushed += crushed.count_ones();
}

/// Σ over the lanes: halves first.
#[inline(always)]
fn sum<S: Simd>(eight: f64x8<S>) -> f64 {
    let (low, high) = eight.split();
    let (low, high) = (low + high).split();
    let [a, b] = (low + high).into();
    a + b
}
