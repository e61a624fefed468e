//! Elements laid out for vector units: eight patches side by side, every quantity of the eight in one vector.
//!
//! The arithmetic is that of [`super::Simplices`] written per lane, so that every instruction set gives the same bits: products are
//! fused into sums where they are written so and nowhere else (numerics A9). AVX2 and AVX-512 have an instruction for that; a
//! processor that has neither calls a function, and is slow. What is gathered and scattered goes through rows of four numbers per
//! node, turned four by four.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{Batch, LANES, Wide, determinant, on, wide};
use super::history::{Recall, Remembering};
use super::hyperelastic_simd::Metric;
use super::kinematics::Gradients;
use super::node_cache::{Accumulated, Rows, number_of, row_of};
use super::rest_geometry::{References, put_in};
use super::simd_material::{Slopes, Solid, Strains, Undeformed};
use super::transpose::gather;
use super::viscoelastic::MOST_MEMORIES;
use super::{MAX_NODES, Memory, Section};
use crate::constitutive::{Flowing, Material, NeoHookean, Viscoelastic, Volume};
use crate::math::Number;
use fearless_simd::{Level, Select, Simd, SimdBase, f64x8};
use std::ops::Range;

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
    /// How fast its elements close at most, 1/s; where none is turned over within [`super::FORESEEN`] steps, anything less.
    pub closing: f64,
    /// Which elements have J ≤ 0: bit 8k + l for the k-th element of the patch in lane l.
    pub inverted: u32,
    /// How many elements are below the continuation.
    pub crushed: u32,
}

/// A corner of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The slot of the element, from that of the first group on.
    pub slot: u16,
    /// The number of the node within the block.
    pub node: u16,
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

/// The kicks of the groups of a run.
#[derive(Clone, Copy)]
pub enum Kicks<'a> {
    /// One for all of them.
    Same(Kick),
    /// That of each group that is swept.
    Each(&'a dyn Fn(usize) -> Option<Kick>),
}

/// A run of groups, their kicks, and whether their power is asked for.
pub type Asked<'a> = (Range<usize>, Kicks<'a>, Power);

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
            batch.nodes.iter_mut().zip(nodes).for_each(|(wide, node)| wide[lane] = row_of(*node));
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

    /// The batches from one on.
    #[inline(always)]
    pub(super) fn batches_from(&self, first: usize) -> &[Batch] {
        self.batches.get(first..).unwrap_or_default()
    }

    /// The batches of a group.
    #[inline(always)]
    pub(super) fn batches_of<const N: usize>(&self, group: usize) -> &[Batch; N] {
        self.batches[group * N..].first_chunk().expect("a group is whole")
    }

    /// Elements to a patch.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Shows the numbers, within the block, of the nodes of the elements of a group, again and again where they share them.
    pub fn nodes(&self, group: usize, mut see: impl FnMut(u16)) {
        for batch in &self.batches[group * self.depth..(group + 1) * self.depth] {
            batch.filled().for_each(|lane| batch.nodes[..=D].iter().for_each(|wide| see(number_of(wide[lane]))));
        }
    }

    /// Σ κ at the nodes of a block, in the order of a sweep over all its groups: the same bits.
    pub fn sum_stiffness(&self, groups: Range<usize>, stiffness: &[f64], part: &mut [Accumulated]) {
        for sum in part.iter_mut() {
            sum[3] = 0.0;
        }
        self.corners(groups, |corner| part[usize::from(corner.node)][3] += stiffness[usize::from(corner.slot)]);
    }

    /// Shows the corners of the elements of these groups in the order of a sweep; empty slots are at the first node.
    #[inline(always)]
    pub fn corners(&self, groups: Range<usize>, mut see: impl FnMut(Corner)) {
        let batches = &self.batches[groups.start * self.depth..groups.end * self.depth];
        for (batch, first) in batches.iter().zip((0..).step_by(LANES)) {
            // Loops: as a chain of iterators this takes six times as long.
            for a in 0..=D {
                for lane in 0..LANES {
                    see(Corner { slot: first + lane as u16, node: number_of(batch.nodes[a][lane]) });
                }
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

    /// The strains of all elements of a group; 1 in the lanes of patches of which one is strained, as the pressure of all is then, else 0.
    #[inline(always)]
    pub(super) fn strain_group<const N: usize, G: Solid<D>, S: Simd>(
        &self,
        (group, batches, rest): (usize, &[Batch; N], &[G::Rest; N]),
        positions: &Rows,
        strains: &mut [Strains<D, f64x8<S>>],
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
        positions: &Rows,
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
        s.inner = away.select(determinant(&s.f) * unit, one);
        if D == 2 && self.section == Section::Axisymmetric {
            s.hoop = batch.hoop(simd);
            s.out = away.select((rows[0][0] + rows[1][0] + rows[2][0]) * s.hoop, one);
        }
        s.strained = if G::REMEMBERS { one } else { strained };
    }
}

/// Volumetric energy, J, and slope and curvature of each element: U(J) of an element that is a patch by itself; else
/// U_s(J) of each and U_v(J̄) of the patch (numerics 5).
#[inline(always)]
pub(super) fn volumetric<const D: usize, const N: usize, S: Simd>(
    gel: &impl Solid<D>,
    batches: &[Batch; N],
    strains: &[Strains<D, f64x8<S>>],
    slopes: &mut [Slopes<f64x8<S>>],
) -> f64x8<S> {
    let simd = strains[0].inner.simd;
    if N == 1 {
        let u = gel.volume().volumetric(strains[0].jacobian());
        slopes[0] = Slopes { slope: u.slope, curvature: u.curvature.at_least(0.0) };
        return wide(simd, &batches[0].volume) * u.energy;
    }
    let mut volume = wide(simd, &batches[0].volume);
    let mut now = volume * strains[0].jacobian();
    for k in 1..N {
        let own = wide(simd, &batches[k].volume);
        (volume, now) = (volume + own, now + own * strains[k].jacobian());
    }
    // An empty lane has no volume; the smallest number keeps it from 0/0.
    let shared = gel.volume().shared(now / volume.at_least(f64::MIN_POSITIVE));
    let mut energy = volume * shared.energy;
    for k in 0..N {
        let own = gel.volume().own(strains[k].jacobian());
        energy += wide(simd, &batches[k].volume) * own.energy;
        slopes[k].slope = own.slope + shared.slope;
        slopes[k].curvature = own.curvature.at_least(0.0) + shared.curvature.at_least(0.0);
    }
    energy
}
