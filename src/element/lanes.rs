//! Elements laid out for vector units: eight patches side by side, every quantity of the eight in one vector.
//!
//! The arithmetic is that of [`super::Simplices`] written per lane, so that every instruction set gives the same bits: products are
//! fused into sums where they are written so and nowhere else (numerics A9). AVX2 and AVX-512 have an instruction for that; a
//! processor that has neither calls a function, and is slow. What is gathered and scattered goes through rows of eight numbers per
//! node, turned four by four.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, Wide, wide};
use super::local::{Accumulated, Aligned, Local, Row};
use super::shuffle::{gather, scatter};
use super::{MAX_NODES, Section};
use crate::algebra::{Number, Vector};
use crate::material::NeoHookean;
use fearless_simd::{Level, Select, Simd, SimdBase, SimdSplit, dispatch, f64x8};
use std::ops::Range;

/// Most elements of a patch.
pub const DEPTH: usize = 4;

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

/// Elements in lanes.
#[derive(Debug, Clone)]
pub struct Lanes<const D: usize> {
    batches: Vec<Batch<D>>,
    /// Of each batch 1 in the lanes of elements that are not at rest where their nodes are; none at all if there is no such element.
    told: Vec<Wide>,
    depth: usize,
    material: NeoHookean,
    section: Section,
}

/// Whether the power of a group, Σ f·v, is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// Of each group.
    Told,
    /// Of none: the velocities of the nodes are not looked up.
    Untold,
}

/// Eight elements in their places: edges from the first node, the gradients of their determinant, and what follows.
#[derive(Clone, Copy)]
struct Shape<const D: usize, V> {
    /// e_a = x_a − x_0, m.
    edges: [[V; D]; D],
    /// ∂ det(e)/∂e_a, mᴰ⁻¹.
    areas: [[V; D]; D],
    /// λ, 1/(3R̄), det F and J; all is 1 where nodes are at rest.
    out: V,
    hoop: V,
    inner: V,
    jacobian: V,
    /// Whether the element is not at rest: 1 or 0.
    strained: V,
}

/// What eight elements do.
#[derive(Clone, Copy)]
struct Pull<const D: usize, V> {
    /// Forces on their nodes but the first, which is given the reaction, without what a ring adds, N.
    forces: [[V; D]; D],
    /// What a ring adds to all of them along r, N.
    around: V,
    /// κ, N/m.
    stiffness: V,
    /// w μ/2 (|F|² + λ² − 3), J.
    energy: V,
}

/// U′ and max(U″, 0) of eight elements with their shares of their patches'.
#[derive(Clone, Copy)]
struct Slopes<V> {
    slope: V,
    curvature: V,
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
        Self { batches: vec![Batch::empty(); n_slots / LANES], told: vec![], depth, material: law.0, section: law.1 }
    }

    /// Puts an element into a slot: ∇N_a for a = 1..=D, w, and the numbers of its nodes.
    pub(super) fn put(&mut self, slot: usize, element: (&[Vector<D>], f64), nodes: [u16; MAX_NODES]) {
        let shear = self.material.shear_modulus();
        self.batches[slot / LANES].put(slot % LANES, (element, shear), nodes);
    }

    /// Of an element in a slot, that its nodes do not say what it is at rest.
    pub(super) fn tell(&mut self, slot: usize) {
        self.told.resize(self.batches.len(), [0.0; LANES]);
        self.told[slot / LANES][slot % LANES] = 1.0;
    }

    /// Elements to a patch.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Shows the numbers, within the block, of the nodes of the elements of a group, again and again where they share them.
    pub fn nodes(&self, group: usize, mut see: impl FnMut(u16)) {
        for batch in &self.batches[group * self.depth..(group + 1) * self.depth] {
            batch.filled().for_each(|lane| batch.nodes[..=D].iter().for_each(|wide| see(wide[lane])));
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
        self.batches.len() * size_of::<Batch<D>>() + self.told.len() * size_of::<Wide>()
    }

    /// Sweeps over those groups of a run for which `weight` gives the length of a kick, s: accumulates Σ weight · f and
    /// Σ κ at the nodes of the block, and writes κ of each slot and the answer of each group, both from the first group on.
    pub fn sweep(
        &self,
        level: Level,
        (groups, weight, power): (Range<usize>, impl Fn(usize) -> Option<f64>, Power),
        local: &mut Local,
        found: (&mut [f64], &mut [GroupAnswer]),
    ) {
        match self.depth {
            1 => dispatch!(level, simd => self.sweep_in::<1, _>(simd, (groups, weight, power), local, found)),
            2 => dispatch!(level, simd => self.sweep_in::<2, _>(simd, (groups, weight, power), local, found)),
            _ => dispatch!(level, simd => self.sweep_in::<4, _>(simd, (groups, weight, power), local, found)),
        }
    }

    #[inline(always)]
    fn sweep_in<const N: usize, S: Simd>(
        &self,
        simd: S,
        (groups, weight, power): (Range<usize>, impl Fn(usize) -> Option<f64>, Power),
        local: &mut Local,
        (stiffness, answers): (&mut [f64], &mut [GroupAnswer]),
    ) {
        for ((group, stiffness), answer) in groups.zip(stiffness.chunks_exact_mut(LANES * N)).zip(answers) {
            let Some(weight) = weight(group) else { continue };
            let batches: &[Batch<D>; N] = self.batches[group * N..].first_chunk().expect("a group is whole");
            let told: &[Wide] = self.told.get(group * N..(group + 1) * N).unwrap_or_default();
            *answer = self.sweep_group(simd, (batches, told, weight, power), local, stiffness);
        }
    }

    /// One group: first the shape and J of every element, then J̄ of every patch, then the forces.
    #[inline(always)]
    fn sweep_group<const N: usize, S: Simd>(
        &self,
        simd: S,
        (batches, told, weight, power): (&[Batch<D>; N], &[Wide], f64, Power),
        local: &mut Local,
        stiffness: &mut [f64],
    ) -> GroupAnswer {
        // Loops, here and below: a closure is not compiled for the vector unit that its caller is compiled for.
        let zero = f64x8::splat(simd, 0.0);
        let mut shapes = [Shape::none(zero); N];
        for k in 0..N {
            self.shape((&batches[k], told.get(k)), &local.positions, &mut shapes[k]);
        }
        // Where one element of a patch is strained the pressure of all is.
        let mut strained = shapes[0].strained;
        for k in 1..N {
            strained = strained.or_greater(shapes[k].strained);
        }
        let mut slopes = [Slopes { slope: zero, curvature: zero }; N];
        let mut energy = self.volumetric(batches, &shapes, &mut slopes);
        let mut given = zero;
        let mut answer = GroupAnswer { least_jacobian: f64::INFINITY, ..GroupAnswer::default() };
        for k in 0..N {
            let pull = self.pull(&batches[k], &shapes[k], &slopes[k]);
            energy = fused(pull.energy, strained, energy);
            if power == Power::Told {
                given = fused(pull.power(&batches[k].nodes, &local.velocities), strained, given);
            }
            let kicks = pull.kicks(strained * weight);
            scatter::<D, S>(&batches[k].nodes, &kicks, &mut local.accumulated);
            pull.stiffness.store_slice(&mut stiffness[k * LANES..(k + 1) * LANES]);
            note(&mut answer, k, shapes[k].jacobian);
        }
        answer.energy = sum(energy);
        answer.power = sum(given);
        answer
    }

    /// Edges, areas and J = λ scale det(e). Where all nodes are at rest J is 1, not what rounding makes of it; so it is in empty lanes.
    #[inline(always)]
    fn shape<S: Simd>(
        &self,
        (batch, told): (&Batch<D>, Option<&Wide>),
        positions: &Aligned<Row>,
        s: &mut Shape<D, f64x8<S>>,
    ) {
        let simd = s.inner.simd;
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let rows = gather::<D, S>(simd, &batch.nodes, positions);
        let mut moved = rows[0][3].or_greater(rows[1][3]).or_greater(rows[2][3].or_greater(rows[3][3]));
        if let Some(told) = told {
            moved = moved.or_greater(wide(simd, told));
        }
        let strained = (moved * wide(simd, &batch.volume)).simd_gt(zero);
        s.strained = strained.select(one, zero);
        for a in 0..D {
            for i in 0..D {
                s.edges[a][i] = rows[a + 1][i] - rows[0][i];
            }
        }
        let determinant = areas(&s.edges, &mut s.areas);
        s.inner = strained.select(determinant * wide(simd, &batch.scale), one);
        s.jacobian = s.inner;
        if self.section == Section::Axisymmetric {
            s.hoop = batch.hoop(simd);
            s.out = strained.select((rows[0][0] + rows[1][0] + rows[2][0]) * s.hoop, one);
            s.jacobian = s.inner * s.out;
        }
    }

    /// Volumetric energy, J, and slope and curvature of each element: U(J) of an element that is a patch by itself; else
    /// U_s(J) of each and U_v(J̄) of the patch (numerics 5).
    #[inline(always)]
    fn volumetric<const N: usize, S: Simd>(
        &self,
        batches: &[Batch<D>; N],
        shapes: &[Shape<D, f64x8<S>>; N],
        slopes: &mut [Slopes<f64x8<S>>; N],
    ) -> f64x8<S> {
        let simd = shapes[0].jacobian.simd;
        if N == 1 {
            let u = self.material.volumetric(shapes[0].jacobian);
            slopes[0] = Slopes { slope: u.slope, curvature: u.curvature.at_least(0.0) };
            return wide(simd, &batches[0].volume) * u.energy;
        }
        let mut volume = wide(simd, &batches[0].volume);
        let mut now = volume * shapes[0].jacobian;
        for k in 1..N {
            let own = wide(simd, &batches[k].volume);
            (volume, now) = (volume + own, now + own * shapes[k].jacobian);
        }
        // An empty lane has no volume; the smallest number keeps it from 0/0.
        let shared = self.material.shared(now / volume.at_least(f64::MIN_POSITIVE));
        let mut energy = volume * shared.energy;
        for k in 0..N {
            let own = self.material.own(shapes[k].jacobian);
            energy += wide(simd, &batches[k].volume) * own.energy;
            slopes[k].slope = own.slope + shared.slope;
            slopes[k].curvature = own.curvature.at_least(0.0) + shared.curvature.at_least(0.0);
        }
        energy
    }

    /// f_a = −Σ_b w μ ∇N_a·∇N_b e_b − w U′ ∂J/∂x_a, w μ/2 (|F|² + λ² − 3), and κ as [`super::Simplices`] has it.
    #[inline(always)]
    fn pull<S: Simd>(&self, batch: &Batch<D>, s: &Shape<D, f64x8<S>>, u: &Slopes<f64x8<S>>) -> Pull<D, f64x8<S>> {
        let (simd, mu) = (s.inner.simd, self.material.shear_modulus());
        let zero = f64x8::splat(simd, 0.0);
        let (volume, scale) = (wide(simd, &batch.volume), wide(simd, &batch.scale));
        let squeeze = if D == 2 { scale * s.out } else { scale };
        let (pressure, shape) = (-(volume * u.slope), volume * mu);
        let (push, beside) = (pressure * squeeze, s.inner * s.hoop);
        let around = fused(pressure, s.inner, -(shape * s.out)) * s.hoop;
        let (mut square, mut volumetric) = (zero, zero);
        let mut forces = [[zero; D]; D];
        for i in 0..D {
            let ring = if i == 0 { beside } else { zero };
            let mut first = zero;
            for a in 0..D {
                let mut shear = s.edges[0][i] * wide(simd, batch.metric(a, 0));
                for b in 1..D {
                    shear = fused(s.edges[b][i], wide(simd, batch.metric(a, b)), shear);
                }
                square = fused(s.edges[a][i], shear, square);
                forces[a][i] = fused(push, s.areas[a][i], -shear);
                first -= s.areas[a][i];
                let b = if D == 2 { fused(s.areas[a][i], squeeze, ring) } else { s.areas[a][i] };
                volumetric = fused(b, b, volumetric);
            }
            let b = if D == 2 { fused(first, squeeze, ring) } else { first };
            volumetric = fused(b, b, volumetric);
        }
        let volumetric = if D == 2 { volumetric } else { volumetric * (squeeze * squeeze) };
        let turn = match self.section {
            Section::Planar { .. } => zero + 1.0,
            Section::Spatial => (square * scale * (12.0 / mu)).root(),
            Section::Axisymmetric => {
                let strain = square * (s.hoop * scale) * (3.0 / (std::f64::consts::PI * mu));
                two_largest(strain, s.inner, s.out)
            }
        };
        let spread = wide(simd, &batch.spread);
        let spread = if D == 2 { fused(volume * 3.0, s.hoop * s.hoop, spread) } else { spread };
        let turning = fused(u.slope.absolute(), turn, zero + mu);
        let stiffness = fused(volume * u.curvature, volumetric, turning * spread);
        let square = if D == 2 { fused(shape * s.out, s.out, square) } else { square };
        let energy = (square - shape * 3.0) * 0.5;
        Pull { forces, around, stiffness, energy }
    }
}

impl<const D: usize, S: Simd> Pull<D, f64x8<S>> {
    /// weight · f and κ at every node.
    #[inline(always)]
    fn kicks(&self, weight: f64x8<S>) -> [[f64x8<S>; 4]; MAX_NODES] {
        let zero = f64x8::splat(weight.simd, 0.0);
        let mut kicks = [[zero, zero, zero, self.stiffness]; MAX_NODES];
        for i in 0..D {
            for a in 0..D {
                kicks[a + 1][i] = self.forces[a][i] * weight;
                kicks[0][i] -= kicks[a + 1][i];
            }
        }
        if D == 2 {
            let around = self.around * weight;
            for a in 0..=D {
                kicks[a][0] += around;
            }
        }
        kicks
    }

    /// Σ f·v, W.
    #[inline(always)]
    fn power(&self, nodes: &[[u16; LANES]; MAX_NODES], velocities: &Aligned<Row>) -> f64x8<S> {
        let simd = self.around.simd;
        let v = gather::<D, S>(simd, nodes, velocities);
        let mut power = if D == 2 { self.around * (v[0][0] + v[1][0] + v[2][0]) } else { f64x8::splat(simd, 0.0) };
        for i in 0..D {
            for a in 0..D {
                power = fused(self.forces[a][i], v[a + 1][i] - v[0][i], power);
            }
        }
        power
    }
}

impl<const D: usize, V: Number> Shape<D, V> {
    #[inline(always)]
    fn none(zero: V) -> Self {
        let (none, one) = ([[zero; D]; D], zero + 1.0);
        Self { edges: none, areas: none, out: one, hoop: zero, inner: one, jacobian: one, strained: zero }
    }
}

/// Sum of the two largest of the singular values s₁ ≥ s₂ of the plane part and |λ|, from Σ s², s₁s₂ and λ.
#[inline(always)]
fn two_largest<V: Number>(square: V, inner: V, out: V) -> V {
    let area = inner.absolute() * 2.0;
    let (sum, difference) = ((square + area).root(), (square - area).at_least(0.0).root());
    sum.or_greater((sum + difference) * 0.5 + out.absolute())
}

/// ∂ det(e)/∂e_a of the edges e_a; returns det(e).
#[inline(always)]
fn areas<const D: usize, S: Simd>(e: &[[f64x8<S>; D]; D], b: &mut [[f64x8<S>; D]; D]) -> f64x8<S> {
    if D == 2 {
        (b[0][0], b[0][1], b[1][0], b[1][1]) = (e[1][1], -e[1][0], -e[0][1], e[0][0]);
        return fused(e[0][0], e[1][1], -(e[0][1] * e[1][0]));
    }
    for a in 0..D {
        for i in 0..D {
            let (c, d, k, l) = ((a + 1) % D, (a + 2) % D, (i + 1) % D, (i + 2) % D);
            b[a][i] = fused(e[c][k], e[d][l], -(e[c][l] * e[d][k]));
        }
    }
    fused(e[0][0], b[0][0], fused(e[0][1], b[0][1], e[0][2 % D] * b[0][2 % D]))
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
