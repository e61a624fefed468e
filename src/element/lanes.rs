//! Elements laid out for vector units: eight patches side by side, every quantity of the eight in one vector.
//!
//! The arithmetic is that of [`super::Simplices`] written per lane, so that every instruction set gives the same bits: products are
//! fused into sums where they are written so and nowhere else (numerics A9). AVX2 and AVX-512 have an instruction for that; a
//! processor that has neither calls a function, and is slow. What is gathered and scattered goes through rows of eight numbers per
//! node, turned four by four.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::local::{Accumulated, Local};
use super::shuffle::{gather, scatter};
use super::{MAX_NODES, Section};
use crate::algebra::Number;
use crate::material::NeoHookean;
use fearless_simd::{Level, Select, Simd, SimdBase, SimdSplit, dispatch, f64x8};
use std::ops::Range;

/// Patches side by side.
pub const LANES: usize = 8;
/// Most elements of a patch.
pub const DEPTH: usize = 4;
type Wide = [f64; LANES];

/// The k-th elements of eight patches.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Batch<const D: usize> {
    /// ∇N_a at rest for a = 1..=D, 1/m.
    gradients: [[Wide; D]; D],
    /// w, rest volume, m³; 0 in an empty lane.
    volume: Wide,
    /// Σ_a |∇N_a|², without the share of a ring, 1/m².
    spread: Wide,
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
    material: NeoHookean,
    section: Section,
}

/// F, cof F, λ, 1/(3R̄), det F and J of eight elements.
#[derive(Clone, Copy)]
struct Strains<const D: usize, V> {
    f: [[V; D]; D],
    cofactor: [[V; D]; D],
    out: V,
    hoop: V,
    inner: V,
    jacobian: V,
}

/// Eight elements: their strains and slopes, and the rows of their nodes.
type Element<'a, const D: usize, V> = (&'a Strains<D, V>, &'a Slopes<V>, &'a [[V; 8]; MAX_NODES]);

/// U′ and max(U″, 0) of eight elements with their shares of their patches'.
#[derive(Clone, Copy)]
struct Slopes<V> {
    slope: V,
    curvature: V,
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
    pub(super) fn empty(n_slots: usize, depth: usize, law: (NeoHookean, Section)) -> Self {
        assert!(n_slots.is_multiple_of(LANES * depth), "slots fill whole groups");
        assert!(matches!(depth, 1 | 2 | 4), "a patch has one, two or four places");
        Self { batches: vec![Batch::empty(); n_slots / LANES], bases: vec![], depth, material: law.0, section: law.1 }
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

    /// Sweeps over those groups of a run for which `weight` gives the length of a kick, s: accumulates Σ weight · f and
    /// Σ κ at the nodes of the block, and writes κ of each slot and the answer of each group, both from the first group on.
    pub fn sweep(
        &self,
        level: Level,
        (groups, weight): (Range<usize>, impl Fn(usize) -> Option<f64>),
        local: &mut Local,
        found: (&mut [f64], &mut [GroupAnswer]),
    ) {
        match self.depth {
            1 => dispatch!(level, simd => self.sweep_in::<1, _>(simd, (groups, weight), local, found)),
            2 => dispatch!(level, simd => self.sweep_in::<2, _>(simd, (groups, weight), local, found)),
            _ => dispatch!(level, simd => self.sweep_in::<4, _>(simd, (groups, weight), local, found)),
        }
    }

    #[inline(always)]
    fn sweep_in<const N: usize, S: Simd>(
        &self,
        simd: S,
        (groups, weight): (Range<usize>, impl Fn(usize) -> Option<f64>),
        local: &mut Local,
        (stiffness, answers): (&mut [f64], &mut [GroupAnswer]),
    ) {
        for ((group, stiffness), answer) in groups.zip(stiffness.chunks_exact_mut(LANES * N)).zip(answers) {
            let Some(weight) = weight(group) else { continue };
            let batches: &[Batch<D>; N] = self.batches[group * N..].first_chunk().expect("a group is whole");
            let bases: &[Base<D>] = self.bases.get(group * N..(group + 1) * N).unwrap_or_default();
            *answer = self.sweep_group(simd, (batches, bases, weight), local, stiffness);
        }
    }

    /// One group: first F and J of every element, then J̄ of every patch, then the forces.
    #[inline(always)]
    fn sweep_group<const N: usize, S: Simd>(
        &self,
        simd: S,
        (batches, bases, weight): (&[Batch<D>; N], &[Base<D>], f64),
        local: &mut Local,
        stiffness: &mut [f64],
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
        let mut energy = self.volumetric(batches, &strains, &mut slopes);
        let mut power = zero;
        let mut answer = GroupAnswer { least_jacobian: f64::INFINITY, ..GroupAnswer::default() };
        for k in 0..N {
            let mut kicks = [[zero; 4]; MAX_NODES];
            let element = (&strains[k], &slopes[k], &rows[k]);
            let sums = self.forces((&batches[k], weight), element, &mut kicks);
            (energy, power) = (energy + sums.0, power + sums.1);
            scatter::<D, S>(&batches[k].nodes, &kicks, &mut local.accumulated);
            kicks[0][3].store_slice(&mut stiffness[k * LANES..(k + 1) * LANES]);
            note(&mut answer, k, strains[k].jacobian);
        }
        answer.energy = sum(energy);
        answer.power = sum(power);
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

    /// Volumetric energy, J, and slope and curvature of each element: U(J) of an element that is a patch by itself; else
    /// U_s(J) of each and U_v(J̄) of the patch (numerics 5).
    #[inline(always)]
    fn volumetric<const N: usize, S: Simd>(
        &self,
        batches: &[Batch<D>; N],
        strains: &[Strains<D, f64x8<S>>; N],
        slopes: &mut [Slopes<f64x8<S>>; N],
    ) -> f64x8<S> {
        let simd = strains[0].jacobian.simd;
        if N == 1 {
            let u = self.material.volumetric(strains[0].jacobian);
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
        let shared = self.material.shared(now / volume.at_least(f64::MIN_POSITIVE));
        let mut energy = volume * shared.energy;
        for k in 0..N {
            let own = self.material.own(strains[k].jacobian);
            energy += wide(simd, &batches[k].volume) * own.energy;
            slopes[k].slope = own.slope + shared.slope;
            slopes[k].curvature = own.curvature.at_least(0.0) + shared.curvature.at_least(0.0);
        }
        energy
    }

    /// weight · f_a and κ, as [`super::Simplices`] has them; w μ/2 (|F|² + λ² − 3), J, and Σ f·v, W.
    #[inline(always)]
    fn forces<S: Simd>(
        &self,
        (batch, weight): (&Batch<D>, f64),
        (s, u, rows): Element<'_, D, f64x8<S>>,
        kicks: &mut [[f64x8<S>; 4]; MAX_NODES],
    ) -> (f64x8<S>, f64x8<S>) {
        let (simd, mu) = (s.inner.simd, self.material.shear_modulus());
        let zero = f64x8::splat(simd, 0.0);
        let volume = wide(simd, &batch.volume);
        let (shape, pressure) = (volume * -mu, -(volume * u.slope));
        let (mut square, mut volumetric, mut power) = (zero, zero, zero);
        // What the ring adds to every node along r: to its force and to ∂J/∂x_a.
        let around = fused(pressure, s.inner, shape * s.out) * s.hoop;
        let beside = s.inner * s.hoop;
        for i in 0..D {
            let ring = D == 2 && i == 0;
            // −w P and λ cof F. At rest w μ and −w μ cancel: the sum comes before any product that would be rounded.
            let (mut stress, mut area) = ([zero; D], [zero; D]);
            for j in 0..D {
                area[j] = if D == 2 { s.cofactor[i][j] * s.out } else { s.cofactor[i][j] };
                stress[j] = fused(pressure, area[j], shape * s.f[i][j]);
                square = fused(s.f[i][j], s.f[i][j], square);
            }
            let (mut push, mut turned) = (zero, zero);
            for a in 0..D {
                let (mut force, mut b) =
                    (stress[0] * wide(simd, &batch.gradients[a][0]), area[0] * wide(simd, &batch.gradients[a][0]));
                for j in 1..D {
                    force = fused(stress[j], wide(simd, &batch.gradients[a][j]), force);
                    b = fused(area[j], wide(simd, &batch.gradients[a][j]), b);
                }
                (push, turned) = (push - force, turned - b);
                let (force, b) = if ring { (force + around, b + beside) } else { (force, b) };
                volumetric = fused(b, b, volumetric);
                power = fused(force, rows[a + 1][4 + i], power);
                kicks[a + 1][i] = force * weight;
            }
            let (force, b) = if ring { (push + around, turned + beside) } else { (push, turned) };
            volumetric = fused(b, b, volumetric);
            power = fused(force, rows[0][4 + i], power);
            kicks[0][i] = force * weight;
        }
        let turn = match self.section {
            Section::Planar { .. } => zero + 1.0,
            Section::Spatial => (square + square).root(),
            Section::Axisymmetric => two_largest(square, s.inner, s.out),
        };
        let spread = wide(simd, &batch.spread);
        let spread = if D == 2 { fused(s.hoop * s.hoop, zero + 3.0, spread) } else { spread };
        let turning = fused(u.slope.absolute(), turn, zero + mu);
        let stiffness = volume * fused(u.curvature, volumetric, turning * spread);
        for a in 0..=D {
            kicks[a][3] = stiffness;
        }
        let square = if D == 2 { fused(s.out, s.out, square) } else { square };
        (volume * (square - 3.0) * (0.5 * mu), power)
    }
}

impl<const D: usize, V: Number> Strains<D, V> {
    #[inline(always)]
    fn at_rest(zero: V) -> Self {
        let (none, one) = ([[zero; D]; D], zero + 1.0);
        Self { f: none, cofactor: none, out: one, hoop: zero, inner: one, jacobian: one }
    }
}

#[inline(always)]
fn wide<S: Simd>(simd: S, eight: &Wide) -> f64x8<S> {
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

/// Sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
fn two_largest<V: Number>(square: V, inner: V, out: V) -> V {
    let area = inner.absolute() * 2.0;
    let (sum, difference) = ((square + area).root(), (square - area).at_least(0.0).root());
    sum.or_greater((sum + difference) * 0.5 + out.absolute())
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
fn fused<S: Simd>(a: f64x8<S>, b: f64x8<S>, c: f64x8<S>) -> f64x8<S> {
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
