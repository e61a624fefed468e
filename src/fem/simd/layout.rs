//! SIMD layout of the elements: eight patches in vector lanes, each quantity of the eight in one vector.
//!
//! The arithmetic is that of [`crate::fem::Simplices`], lane by lane, with the same bits on every instruction set.
//! Products are fused into sums only where the source says so (method A9): AVX2 and AVX-512 have an instruction for
//! it, other processors call a slow function. Gather and scatter use rows of four numbers per node, transposed four
//! by four.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::batch::{ElementBatch, LANES, LaneArray, load_lanes, on};
use super::node_cache::{NodeAccumulator, NodeRows, number_of, row_of};
use super::transpose::gather;
use crate::constitutive::{Material, NeoHookean, TwoNetwork};
use crate::fem::history::{HistoryLanes, HistoryLayout, MOST_MEMORIES, MOST_ROWS};
use crate::fem::law::element_law::{ElementDeformation, ElementLaw, LaneRatios};
use crate::fem::law::neo_hookean::ShearStiffness;
use crate::fem::law::rest_geometry::RestGeometry;
use crate::fem::law::two_network::NetworkRest;
use crate::fem::{GroupKick, HistoryVariables, MAX_NODES, Section, max_patch_size};
use crate::math::Number;
use fearless_simd::{Level, Simd, SimdBase, f64x8};
use std::ops::Range;

/// Response of a group of eight patches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupResponse {
    /// Σ V, J.
    pub energy: f64,
    /// Σ f·v, W.
    pub power: f64,
    /// Least J of the elements.
    pub least_jacobian: f64,
    /// Greatest closing rate of the elements, 1/s; may be too small if no element inverts within
    /// [`crate::fem::FORESEEN`] steps.
    pub closing: f64,
    /// Bit set of the elements with J ≤ 0: bit 8k + l for the k-th element of the patch in lane l.
    pub inverted: u32,
    /// Number of elements below the floor of J.
    pub crushed: u32,
}

/// Reference shapes of eight elements.
pub(crate) struct ReferenceBatch<const D: usize> {
    /// Edges as columns, m; the identity in an empty lane.
    pub edges: [[LaneArray; D]; D],
    /// R̄ of rings, m.
    pub radius: LaneArray,
    /// 1 in a filled lane, else 0.
    pub filled: LaneArray,
    /// Relative density; 1 in an empty lane.
    pub density: LaneArray,
    /// Relative strength and bulk modulus.
    pub ratios: LaneRatios<LaneArray>,
}

/// Corner of an element in a slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementCorner {
    /// Slot of the element, counted from the first slot of the first group.
    pub slot: u16,
    /// Number of the node within the block.
    pub node: u16,
}

/// Request for the power Σ f·v of the groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReportPower {
    /// Report the power of each group.
    Told,
    /// Report no power; nodal velocities are not loaded.
    Untold,
}

/// Output of a sweep: κ of each slot, the response of each group, and the history variables.
pub type SweepOutput<'a> = (&'a mut [f64], &'a mut [GroupResponse], &'a mut [HistoryLanes]);

/// Kicks of the groups of a run.
#[derive(Clone, Copy)]
pub enum GroupKicks<'a> {
    /// One kick for all groups.
    Same(GroupKick),
    /// Kick of each group; none for a group outside the sweep.
    Each(&'a dyn Fn(usize) -> Option<GroupKick>),
}

/// Input of a sweep: a run of groups, their kicks, and the request for their power.
pub type SweepInput<'a> = (Range<usize>, GroupKicks<'a>, ReportPower);

/// Material of the elements in lanes, with the rest data of each batch.
#[derive(Debug, Clone)]
pub(crate) enum BatchLaw<const D: usize> {
    NeoHookean(NeoHookean, Vec<ShearStiffness<D>>),
    TwoNetwork(TwoNetwork, Vec<NetworkRest<D>>),
}

impl<const D: usize> BatchLaw<D> {
    /// Returns the layout of the history variables.
    fn history_layout(&self) -> &dyn HistoryLayout<D> {
        match self {
            Self::NeoHookean(gel, _) => gel,
            Self::TwoNetwork(gel, _) => gel,
        }
    }
}

/// Elements in vector lanes, in batches of eight.
#[derive(Debug, Clone)]
pub struct ElementBatches<const D: usize> {
    batches: Vec<ElementBatch>,
    /// Mask of each batch: 1 in the lanes of incompatible elements; empty if all elements are compatible.
    incompatible: Vec<LaneArray>,
    /// Relative strength and bulk modulus of each batch; empty of a gel of one material.
    ratios: Vec<LaneRatios<LaneArray>>,
    depth: usize,
    law: BatchLaw<D>,
    section: Section,
}

impl<const D: usize> ElementBatches<D> {
    /// Creates empty lanes for `n_slots` elements, `depth` to a patch; none for a material without a SIMD form.
    ///
    /// # Panics
    /// If the slots do not fill their batches, or `depth` is neither 1 nor [`max_patch_size`].
    pub(crate) fn empty(n_slots: usize, depth: usize, material: &Material, section: Section) -> Option<Self> {
        assert!(n_slots.is_multiple_of(LANES * depth), "slots fill whole groups");
        assert!(
            depth == 1 || depth == max_patch_size(D),
            "a patch has one place, or two in the plane and four in space"
        );
        let n = n_slots / LANES;
        let law = match material {
            Material::NeoHookean(gel) => BatchLaw::NeoHookean(*gel, vec![ShearStiffness::default(); n]),
            Material::TwoNetwork(gel) => BatchLaw::TwoNetwork(*gel, vec![NetworkRest::default(); n]),
            Material::MooneyRivlin(_) | Material::Ogden(_) => return None,
        };
        let (batches, incompatible, ratios) = (vec![ElementBatch::default(); n], vec![], vec![]);
        Some(Self { batches, incompatible, ratios, depth, law, section })
    }

    /// Fills a batch with the rest shapes of eight elements and the numbers of their nodes.
    pub(crate) fn set_batch(&mut self, at: usize, rest: &ReferenceBatch<D>, nodes: &[[u16; MAX_NODES]; LANES]) {
        let (batch, section) = (&mut self.batches[at], self.section);
        for (lane, nodes) in nodes.iter().enumerate() {
            batch.nodes.iter_mut().zip(nodes).for_each(|(wide, node)| wide[lane] = row_of(*node));
        }
        match &mut self.law {
            BatchLaw::NeoHookean(gel, law) => {
                on!(Level::new(), simd => store_rest_geometry(simd, gel, batch, &mut law[at], rest, section));
            }
            BatchLaw::TwoNetwork(gel, law) => {
                on!(Level::new(), simd => store_rest_geometry(simd, gel, batch, &mut law[at], rest, section));
            }
        }
    }

    /// Sets the relative strength and bulk modulus of a batch of a layered gel.
    pub(crate) fn set_ratios(&mut self, at: usize, ratios: LaneRatios<LaneArray>) {
        let gel = LaneRatios { strength: [1.0; LANES], bulk: [1.0; LANES] };
        self.ratios.resize(self.batches.len(), gel);
        self.ratios[at] = ratios;
    }

    /// Returns the relative strengths and bulk moduli of a group of a layered gel.
    #[inline(always)]
    pub(crate) fn ratios_of<const N: usize, S: Simd>(
        &self,
        simd: S,
        group: usize,
    ) -> Option<[LaneRatios<f64x8<S>>; N]> {
        let ratios: &[LaneRatios<LaneArray>; N] = self.ratios.get(group * N..)?.first_chunk()?;
        let mut loaded = [LaneRatios { strength: f64x8::splat(simd, 1.0), bulk: f64x8::splat(simd, 1.0) }; N];
        for k in 0..N {
            loaded[k].strength = load_lanes(simd, &ratios[k].strength);
            loaded[k].bulk = load_lanes(simd, &ratios[k].bulk);
        }
        Some(loaded)
    }

    /// Marks an element whose rest shape is not that of the rest positions of its nodes.
    pub(crate) fn mark_incompatible(&mut self, slot: usize) {
        self.incompatible.resize(self.batches.len(), [0.0; LANES]);
        self.incompatible[slot / LANES][slot % LANES] = 1.0;
    }

    /// Marks all elements as compatible.
    pub(crate) fn clear_incompatible(&mut self) {
        self.incompatible.clear();
    }

    /// Returns the material and its rest data.
    pub(crate) fn law(&self) -> &BatchLaw<D> {
        &self.law
    }

    /// Returns the kinematic model.
    pub(crate) fn section(&self) -> Section {
        self.section
    }

    /// Returns the batches of a group.
    #[inline(always)]
    pub(crate) fn batches_of<const N: usize>(&self, group: usize) -> &[ElementBatch; N] {
        self.batches[group * N..].first_chunk().expect("a group is whole")
    }

    /// Returns the elements per patch.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.depth
    }

    /// Visits the node numbers of the elements of a group; shared nodes repeatedly.
    pub fn nodes(&self, group: usize, mut see: impl FnMut(u16)) {
        for batch in &self.batches[group * self.depth..(group + 1) * self.depth] {
            batch.filled_lanes().for_each(|lane| batch.nodes[..=D].iter().for_each(|wide| see(number_of(wide[lane]))));
        }
    }

    /// Sums κ at the nodes of a block in the order of a sweep, with the same bits.
    pub fn sum_stiffness(&self, groups: Range<usize>, stiffness: &[f64], part: &mut [NodeAccumulator]) {
        for sum in part.iter_mut() {
            sum[3] = 0.0;
        }
        self.corners(groups, |corner| part[usize::from(corner.node)][3] += stiffness[usize::from(corner.slot)]);
    }

    /// Visits the corners of the elements of a run of groups in the order of a sweep; empty slots use node 0.
    #[inline(always)]
    pub fn corners(&self, groups: Range<usize>, mut see: impl FnMut(ElementCorner)) {
        let batches = &self.batches[groups.start * self.depth..groups.end * self.depth];
        for (batch, first) in batches.iter().zip((0..).step_by(LANES)) {
            // Loops: a chain of iterators is six times slower.
            for a in 0..=D {
                for lane in 0..LANES {
                    see(ElementCorner { slot: first + lane as u16, node: number_of(batch.nodes[a][lane]) });
                }
            }
        }
    }

    /// Returns the allocated size, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let law_size = match &self.law {
            BatchLaw::NeoHookean(_, rest) => size_of_val(rest.as_slice()),
            BatchLaw::TwoNetwork(_, rest) => size_of_val(rest.as_slice()),
        };
        let batches = size_of_val(self.batches.as_slice()) + size_of_val(self.ratios.as_slice());
        law_size + batches + size_of_val(self.incompatible.as_slice())
    }

    /// Returns the number of history rows of a batch.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.law.history_layout().rows()
    }

    /// Creates the initial history variables of all batches; empty for a material without history.
    #[must_use]
    pub fn memory(&self) -> Vec<HistoryLanes> {
        let mut batch = vec![HistoryLanes::default(); self.rows()];
        (0..LANES).for_each(|lane| self.remember(&mut batch, lane, &[HistoryVariables::default(); MOST_MEMORIES]));
        batch.repeat(self.batches.len())
    }

    /// Stores the history variables of an element in a lane of the rows of its batch.
    pub fn remember(&self, batch: &mut [HistoryLanes], lane: usize, memory: &[HistoryVariables<D>]) {
        let mut numbers = lane_numbers(batch, lane);
        self.law.history_layout().store_history(&mut numbers[..batch.len()], memory);
        batch.iter_mut().zip(numbers).for_each(|(row, number)| row.0[lane] = number);
    }

    /// Loads the history variables of an element from a lane of the rows of its batch.
    pub fn recall(&self, batch: &[HistoryLanes], lane: usize, memory: &mut [HistoryVariables<D>]) {
        self.law.history_layout().load_history(&lane_numbers(batch, lane)[..batch.len()], memory);
    }

    /// Returns the viscous part of U′ of the element in a lane at its last tick, Pa.
    #[must_use]
    pub fn viscous(&self, batch: &[HistoryLanes], lane: usize) -> f64 {
        self.law.history_layout().viscous(&lane_numbers(batch, lane)[..batch.len()])
    }

    /// Computes the deformation of all elements of a group.
    ///
    /// Returns 1 in the lanes of patches with a strained element, since its pressure acts on all of them, else 0.
    #[inline(always)]
    pub(crate) fn strain_group<const N: usize, G: ElementLaw<D>, S: Simd>(
        &self,
        group: usize,
        batches: &[ElementBatch; N],
        rest: &[G::Rest<LaneArray>; N],
        positions: &NodeRows,
        strains: &mut [ElementDeformation<D, f64x8<S>>],
    ) -> f64x8<S> {
        let incompatible: &[LaneArray] = self.incompatible.get(group * N..(group + 1) * N).unwrap_or_default();
        for k in 0..N {
            self.strain_batch::<G, S>(&batches[k], incompatible.get(k), &rest[k], positions, &mut strains[k]);
        }
        let mut strained = strains[0].strained;
        for k in 1..N {
            strained = strained.or_greater(strains[k].strained);
        }
        strained
    }

    /// Computes F of a batch from the edges x_a − x_0, with J and λ.
    #[inline(always)]
    fn strain_batch<G: ElementLaw<D>, S: Simd>(
        &self,
        batch: &ElementBatch,
        incompatible: Option<&LaneArray>,
        rest: &G::Rest<LaneArray>,
        positions: &NodeRows,
        s: &mut ElementDeformation<D, f64x8<S>>,
    ) {
        let simd = s.det_f.simd;
        let rows = gather::<D, S>(simd, &batch.nodes, positions);
        let mut moved = rows[0][3].or_greater(rows[1][3]).or_greater(rows[2][3].or_greater(rows[3][3]));
        if let Some(incompatible) = incompatible {
            moved = moved.or_greater(load_lanes(simd, incompatible));
        }
        for a in 0..D {
            for i in 0..D {
                s.f[i][a] = rows[a + 1][i] - rows[0][i];
            }
        }
        let (volume, scale) = (load_lanes(simd, &batch.volume), load_lanes(simd, &batch.scale));
        let radii = rows[0][0] + rows[1][0] + rows[2][0];
        s.deform::<G>(self.section, rest, volume, scale, moved, radii);
    }
}

/// Returns the numbers of a lane in the history rows of a batch.
fn lane_numbers(batch: &[HistoryLanes], lane: usize) -> [f64; MOST_ROWS] {
    let mut numbers = [0.0; MOST_ROWS];
    numbers.iter_mut().zip(batch).for_each(|(number, row)| *number = row.0[lane]);
    numbers
}

/// Stores the rest geometry and the rest data of eight elements in a batch.
#[inline(always)]
fn store_rest_geometry<const D: usize, G: ElementLaw<D>, S: Simd>(
    simd: S,
    gel: &G,
    batch: &mut ElementBatch,
    law: &mut G::Rest<LaneArray>,
    rest: &ReferenceBatch<D>,
    section: Section,
) {
    let edges = load_edges(simd, &rest.edges);
    let (radius, filled) = (load_lanes(simd, &rest.radius), load_lanes(simd, &rest.filled));
    let [density, strength, bulk] =
        [&rest.density, &rest.ratios.strength, &rest.ratios.bulk].map(|lanes| load_lanes(simd, lanes));
    let shape = RestGeometry { density, strength, bulk, ..RestGeometry::new(&edges, radius, filled, section) };
    (batch.volume, batch.scale) = (shape.volume.store(), shape.scale().store());
    *law = gel.rest(&shape);
}

/// Loads the edges of eight elements.
#[inline(always)]
fn load_edges<const D: usize, S: Simd>(simd: S, rows: &[[LaneArray; D]; D]) -> [[f64x8<S>; D]; D] {
    let mut all = [[load_lanes(simd, &rows[0][0]); D]; D];
    for i in 0..D {
        for j in 0..D {
            all[i][j] = load_lanes(simd, &rows[i][j]);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn every_instruction_set_gives_the_same_rest_geometry() {
        let gel = NeoHookean::new(3.0, 40.0);
        let wave = |i: usize, j: usize, lane: usize| 0.2 * ((3 * i + 5 * j + 7 * lane) as f64).sin();
        let edge = |i: usize, j: usize, lane: usize| if i == j { 1.0 } else { 0.0 } + wave(i, j, lane);
        let edges = std::array::from_fn(|i| std::array::from_fn(|j| std::array::from_fn(|lane| edge(i, j, lane))));
        // One lane is empty.
        let filled = std::array::from_fn(|lane| if lane < 7 { 1.0 } else { 0.0 });
        let ones = [1.0; LANES];
        let ratios = LaneRatios { strength: ones, bulk: ones };
        let rest = ReferenceBatch { edges, radius: ones, filled, density: ones, ratios };
        let made = |level: Level| {
            let (mut batch, mut law) = (ElementBatch::default(), ShearStiffness::<3>::default());
            on!(level, simd => store_rest_geometry(simd, &gel, &mut batch, &mut law, &rest, Section::Spatial));
            format!("{batch:?} {law:?}")
        };
        let widest = Level::new();
        let narrower = [widest.as_avx2().map(Level::Avx2), widest.as_sse2().map(Level::Sse2)];
        assert!(narrower.iter().any(Option::is_some), "there are instruction sets to compare");
        narrower.into_iter().flatten().for_each(|level| assert_eq!(made(level), made(widest)));
    }
}
