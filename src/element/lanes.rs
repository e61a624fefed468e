//! Elements laid out for vector units: eight patches side by side, every quantity of the eight in one vector.
//!
//! The arithmetic is that of [`super::Simplices`] written per lane, so that every instruction set gives the same bits: products are
//! fused into sums where they are written so and nowhere else (numerics A9). AVX2 and AVX-512 have an instruction for that; a
//! processor that has neither calls a function, and is slow. What is gathered and scattered goes through rows of four numbers per
//! node, turned four by four.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, Wide, cofactor, fused, on, sum, wide};
use super::closing::closing;
use super::eight::{References, put_in};
use super::elastic::Metric;
use super::local::{Accumulated, Aligned, Local, Row};
use super::placed::Gradients;
use super::recall::{Recall, Remembering};
use super::relax::MOST_MEMORIES;
use super::shuffle::{gather, scatter};
use super::solid::{Slopes, Solid, Strains, Undeformed};
use super::{FORESEEN, MAX_NODES, Memory, Section, Spent, TURNED};
use crate::algebra::Number;
use crate::material::{Flowing, Material, NeoHookean, Viscoelastic, Volume};
use fearless_simd::{Level, Select, Simd, SimdBase, SimdSplit, f64x8};
use std::any::Any;
use std::ops::Range;

/// More than rounding makes of a bound.
const ROUNDING: f64 = 1.001;

/// Most elements of a patch.
pub const DEPTH: usize = places(3);

/// Places of a patch of more than one element: pairs in the plane, fours in space.
#[must_use]
pub const fn places(dimensions: usize) -> usize {
    2 * (dimensions - 1)
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
    /// How fast its elements close at most, 1/s; where none is turned over within [`FORESEEN`] steps, anything less.
    pub closing: f64,
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

/// Whether the power of a group, Σ f·v, is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// Of each group.
    Told,
    /// Of none: the velocities of the nodes are not looked up.
    Untold,
}

/// Where a sweep leaves κ of each slot, the answer of each group, and what its elements remember.
pub type Found<'a> = (&'a mut [f64], &'a mut [GroupAnswer], &'a mut [Recall]);

/// A run of groups, the kick of each that is swept, and whether its power is asked for.
pub type Asked<'a> = (Range<usize>, &'a dyn Fn(usize) -> Option<Kick>, Power);

/// What elements in lanes are made of, and what that knows of each at rest, batch by batch.
#[derive(Debug, Clone)]
pub(super) enum Law<const D: usize> {
    Elastic(NeoHookean, Vec<Metric<D>>),
    Flowing(Flowing, Vec<Gradients<D>>),
    Relaxing(Viscoelastic, Vec<Gradients<D>>),
}

impl<const D: usize> Law<D> {
    fn gel(&self) -> &dyn Remembering<D> {
        match self {
            Self::Elastic(gel, _) => gel,
            Self::Flowing(gel, _) => gel,
            Self::Relaxing(gel, _) => gel,
        }
    }
}

/// Elements in lanes.
#[derive(Debug, Clone)]
pub struct Lanes<const D: usize> {
    batches: Vec<Batch>,
    /// Of each batch 1 in the lanes of elements that are not at rest where their nodes are; none at all if there is no such element.
    told: Vec<Wide>,
    depth: usize,
    law: Law<D>,
    section: Section,
}

impl<const D: usize> Lanes<D> {
    /// Empty lanes for so many slots, `depth` elements to a patch; none of a material that has no such form.
    ///
    /// # Panics
    /// If the slots do not fill their batches, or `depth` is neither 1 nor [`places`].
    pub(super) fn empty(n_slots: usize, depth: usize, (material, section): (&Material, Section)) -> Option<Self> {
        assert!(n_slots.is_multiple_of(LANES * depth), "slots fill whole groups");
        assert!(depth == 1 || depth == places(D), "a patch has one place, or two in the plane and four in space");
        let n = n_slots / LANES;
        let law = match material {
            Material::NeoHookean(gel) => Law::Elastic(*gel, vec![Metric::default(); n]),
            Material::Flowing(gel) => Law::Flowing(*gel, vec![Gradients::default(); n]),
            Material::Viscoelastic(gel) => Law::Relaxing(*gel, vec![Gradients::default(); n]),
            Material::MooneyRivlin(_) | Material::Ogden(_) => return None,
        };
        Some(Self { batches: vec![Batch::default(); n], told: vec![], depth, law, section })
    }

    /// Puts eight elements, as they are at rest, into a batch, with the numbers of their nodes.
    pub(super) fn put(&mut self, at: usize, rest: &References<D>, nodes: &[[u16; MAX_NODES]; LANES]) {
        let (batch, section) = (&mut self.batches[at], self.section);
        for (lane, nodes) in nodes.iter().enumerate() {
            batch.nodes.iter_mut().zip(nodes).for_each(|(wide, node)| wide[lane] = *node);
        }
        match &mut self.law {
            Law::Elastic(gel, law) => {
                on!(Level::new(), simd => put_in((simd, gel), (batch, &mut law[at]), (rest, section)));
            }
            Law::Flowing(gel, law) => {
                on!(Level::new(), simd => put_in((simd, gel), (batch, &mut law[at]), (rest, section)));
            }
            Law::Relaxing(gel, law) => {
                on!(Level::new(), simd => put_in((simd, gel), (batch, &mut law[at]), (rest, section)));
            }
        }
    }

    /// Of an element in a slot, that its nodes do not say what it is at rest.
    pub(super) fn tell(&mut self, slot: usize) {
        self.told.resize(self.batches.len(), [0.0; LANES]);
        self.told[slot / LANES][slot % LANES] = 1.0;
    }

    /// Takes all elements for what their nodes say.
    pub(super) fn forget(&mut self) {
        self.told.clear();
    }

    pub(super) fn law(&self) -> &Law<D> {
        &self.law
    }

    pub(super) fn section(&self) -> Section {
        self.section
    }

    pub(super) fn first_group<const N: usize>(&self) -> &[Batch; N] {
        self.batches.first_chunk().expect("a group is whole")
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
        let of_law = match &self.law {
            Law::Elastic(_, rest) => size_of_val(rest.as_slice()),
            Law::Flowing(_, rest) | Law::Relaxing(_, rest) => size_of_val(rest.as_slice()),
        };
        of_law + size_of_val(self.batches.as_slice()) + size_of_val(self.told.as_slice())
    }

    /// Numbers that an element remembers, each a row of its batch.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.law.gel().rows()
    }

    /// What fresh elements remember, batch by batch; nothing of those that remember nothing.
    #[must_use]
    pub fn memory(&self) -> Vec<Recall> {
        let mut batch = vec![Recall::default(); self.rows()];
        (0..LANES).for_each(|lane| self.remember(&mut batch, lane, &[Memory::default(); MOST_MEMORIES]));
        batch.repeat(self.batches.len())
    }

    /// Puts what an element remembers into a lane of the rows of its batch.
    pub fn remember(&self, batch: &mut [Recall], lane: usize, memory: &[Memory<D>]) {
        self.law.gel().put_memory(batch, lane, memory);
    }

    /// Takes it from there.
    pub fn recall(&self, batch: &[Recall], lane: usize, memory: &mut [Memory<D>]) {
        self.law.gel().take_memory(batch, lane, memory);
    }

    /// What viscosity added to U′ of the element in a lane at its last own tick, Pa.
    #[must_use]
    pub fn viscous(&self, batch: &[Recall], lane: usize) -> f64 {
        self.law.gel().viscous(batch, lane)
    }

    /// Sweeps over those groups of a run for which there is a `kick`: accumulates Σ length · f and Σ κ at the nodes of the block, and
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
        match &self.law {
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
        if self.depth == 1 {
            on!(level, simd => self.sweep_in::<1, _, _>((simd, gel, rest), asked, local, found));
        } else {
            on!(level, simd => self.sweep_in::<N, _, _>((simd, gel, rest), asked, local, found));
        }
    }

    #[inline(always)]
    fn sweep_in<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (simd, gel, rest): (S, &G, &[G::Rest]),
        (groups, kick, power): Asked<'_>,
        local: &mut Local,
        (stiffness, answers, memory): Found<'_>,
    ) {
        let (first, rows) = (groups.start, N * gel.rows());
        for ((group, stiffness), answer) in groups.zip(stiffness.chunks_exact_mut(LANES * N)).zip(answers) {
            let Some(kick) = kick(group) else { continue };
            let rest: &[G::Rest; N] = rest[group * N..].first_chunk().expect("a group is whole");
            let memory = &mut memory[(group - first) * rows..(group - first + 1) * rows];
            *answer = self.sweep_group((simd, gel, rest), (group, kick, power), local, (stiffness, memory));
        }
    }

    /// One group: first the strains and J of every element, then J̄ of every patch, then the forces.
    #[inline(always)]
    fn sweep_group<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (simd, gel, rest): (S, &G, &[G::Rest; N]),
        (group, kick, power): (usize, Kick, Power),
        local: &mut Local,
        (stiffness, memory): (&mut [f64], &mut [Recall]),
    ) -> GroupAnswer {
        // Loops, here and below: a closure is not compiled for the vector unit that its caller is compiled for.
        let batches: &[Batch; N] = self.batches[group * N..].first_chunk().expect("a group is whole");
        let zero = f64x8::splat(simd, 0.0);
        let mut strains = [Strains::at_rest(zero); N];
        let strained = self.strain_group::<N, G, S>((group, batches, rest), &local.positions, &mut strains);
        let mut slopes = [Slopes { slope: zero, curvature: zero }; N];
        let mut energy = volumetric(gel, batches, &strains, &mut slopes);
        let (mut given, mut lost, rows) = (zero, [zero; 3], gel.rows());
        let mut answer = GroupAnswer { least_jacobian: f64::INFINITY, ..GroupAnswer::default() };
        for k in 0..N {
            let own = &mut memory[k * rows..(k + 1) * rows];
            let pull = gel.pull(self.section, (&batches[k], &rest[k], kick, own), (&strains[k], &slopes[k]));
            let resists = wide(simd, &batches[k].volume) * slopes[k].curvature;
            if may_close::<D, S>((pull.stiffness, resists), strains[k].jacobian, (kick.elapsed, local.fastest)) {
                answer.closing = answer.closing.max(greatest(self.closing(strains[k].jacobian, &batches[k], local)));
            }
            energy = fused(pull.energy, strained, energy);
            for i in 0..3 {
                lost[i] += pull.lost[i];
            }
            if power == Power::Told {
                given = fused(pull.power(&batches[k].nodes, &local.velocities), strained, given);
            }
            scatter::<D, S>(&batches[k].nodes, &pull.kicks(strained * kick.length), &mut local.accumulated);
            pull.stiffness.store_slice(&mut stiffness[k * LANES..(k + 1) * LANES]);
            note(&mut answer, k, strains[k].jacobian);
        }
        (answer.energy, answer.power) = (sum(energy), sum(given));
        for i in 0..3 {
            answer.lost[i] = sum(lost[i]);
        }
        answer
    }

    /// How fast eight elements of these J close, 1/s.
    #[inline(always)]
    fn closing<S: Simd>(&self, jacobian: f64x8<S>, batch: &Batch, local: &Local) -> f64x8<S> {
        let simd = jacobian.simd;
        let (x, v) = (
            gather::<D, S>(simd, &batch.nodes, &local.positions),
            gather::<D, S>(simd, &batch.nodes, &local.velocities),
        );
        let zero = f64x8::splat(simd, 0.0);
        let (mut edges, mut rates) = ([[zero; D]; D], [[zero; D]; D]);
        for i in 0..D {
            for a in 0..D {
                (edges[i][a], rates[i][a]) = (x[a + 1][i] - x[0][i], v[a + 1][i] - v[0][i]);
            }
        }
        let radial = (x[0][0] + x[1][0] + x[2][0], v[0][0] + v[1][0] + v[2][0]);
        let ring = if self.section == Section::Axisymmetric { Some(radial) } else { None };
        closing(jacobian, (&edges, &rates), ring)
    }

    /// The strains of all elements of a group; 1 in the lanes of patches of which one is strained, as the pressure of all is then, else 0.
    #[inline(always)]
    pub(super) fn strain_group<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (group, batches, rest): (usize, &[Batch; N], &[G::Rest; N]),
        positions: &Aligned<Row>,
        strains: &mut [Strains<D, f64x8<S>>; N],
    ) -> f64x8<S> {
        let told: &[Wide] = self.told.get(group * N..(group + 1) * N).unwrap_or_default();
        for k in 0..N {
            self.strain::<G, S>((&batches[k], told.get(k), &rest[k]), positions, &mut strains[k]);
        }
        let mut strained = strains[0].strained;
        for k in 1..N {
            strained = strained.or_greater(strains[k].strained);
        }
        strained
    }

    /// F from the edges x_a − x_0, and what follows from it. Where all nodes are at rest J is 1, not what rounding makes of it; so it is in
    /// empty lanes.
    #[inline(always)]
    fn strain<G: Solid<D>, S: Simd>(
        &self,
        (batch, told, rest): (&Batch, Option<&Wide>, &G::Rest),
        positions: &Aligned<Row>,
        s: &mut Strains<D, f64x8<S>>,
    ) {
        let simd = s.inner.simd;
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let rows = gather::<D, S>(simd, &batch.nodes, positions);
        let mut moved = rows[0][3].or_greater(rows[1][3]).or_greater(rows[2][3].or_greater(rows[3][3]));
        if let Some(told) = told {
            moved = moved.or_greater(wide(simd, told));
        }
        let away = (moved * wide(simd, &batch.volume)).simd_gt(zero);
        let strained = away.select(one, zero);
        for a in 0..D {
            for i in 0..D {
                s.f[i][a] = rows[a + 1][i] - rows[0][i];
            }
        }
        let unit = rest.deform((strained, wide(simd, &batch.scale)), &mut s.f);
        s.inner = away.select(cofactor(&s.f, &mut s.cofactor) * unit, one);
        s.jacobian = s.inner;
        if self.section == Section::Axisymmetric {
            s.hoop = batch.hoop(simd);
            s.out = away.select((rows[0][0] + rows[1][0] + rows[2][0]) * s.hoop, one);
            s.jacobian = s.inner * s.out;
        }
        s.strained = if G::REMEMBERS { one } else { strained };
    }
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

/// Volumetric energy, J, and slope and curvature of each element: U(J) of an element that is a patch by itself; else
/// U_s(J) of each and U_v(J̄) of the patch (numerics 5).
#[inline(always)]
pub(super) fn volumetric<const D: usize, const N: usize, S: Simd>(
    gel: &impl Solid<D>,
    batches: &[Batch; N],
    strains: &[Strains<D, f64x8<S>>; N],
    slopes: &mut [Slopes<f64x8<S>>; N],
) -> f64x8<S> {
    let simd = strains[0].jacobian.simd;
    if N == 1 {
        let u = gel.volume().volumetric(strains[0].jacobian);
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
    let shared = gel.volume().shared(now / volume.at_least(f64::MIN_POSITIVE));
    let mut energy = volume * shared.energy;
    for k in 0..N {
        let own = gel.volume().own(strains[k].jacobian);
        energy += wide(simd, &batches[k].volume) * own.energy;
        slopes[k].slope = own.slope + shared.slope;
        slopes[k].curvature = own.curvature.at_least(0.0) + shared.curvature.at_least(0.0);
    }
    energy
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
