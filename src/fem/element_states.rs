//! States of all elements at one configuration, eight patches at a time in reused lanes; prepares a new mesh.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::history::HistoryLanes;
use super::law::element_law::{
    ElementDeformation, ElementLaw, LaneRatios, LawInput, VolumetricSlopes, evaluate_elements, evaluate_volumetric,
};
use super::simd::batch::{LANES, LaneArray, load_lanes, on};
use super::simd::layout::{BatchLaw, ElementBatches, ReferenceBatch};
use super::simd::node_cache::{HeldNodes, NodeCache, rounding};
use super::{DEPTH, ElementStates, GroupKick, HistoryVariables, MAX_NODES, Simplices, max_patch_size};
use crate::math::{Number, Vector};
use crate::mesh::ElementId;
use fearless_simd::{Level, Simd, SimdBase, f64x8};
use std::any::Any;

/// States of eight patches: V, J, and of their elements κ, N/m, and J.
#[derive(Default)]
struct BatchStates {
    energy: LaneArray,
    stiffness: [LaneArray; DEPTH],
    jacobian: [LaneArray; DEPTH],
}

/// Builds the SIMD form of elements, [`super::Potential::lanes`].
pub(super) fn build_batches<const D: usize>(
    simplices: &Simplices<D>,
    slots: &[Option<ElementId>],
    depth: usize,
    local: &[[u16; MAX_NODES]],
) -> Option<ElementBatches<D>> {
    let mut lanes = ElementBatches::empty(slots.len(), depth, &simplices.material, simplices.section)?;
    for (at, (slots, local)) in slots.as_chunks::<LANES>().0.iter().zip(local.as_chunks::<LANES>().0).enumerate() {
        simplices.set_batch(&mut lanes, at, slots, local);
    }
    Some(lanes)
}

/// Evaluates all elements, [`super::Potential::measure_all`]; none for a material without a SIMD form.
pub(super) fn evaluate_all<const D: usize>(
    simplices: &Simplices<D>,
    x: &[Vector<D>],
    memory: &[HistoryVariables<D>],
) -> Option<ElementStates> {
    let patches = &simplices.patches;
    let mut measured = ElementStates::at_rest(simplices.elements().len(), patches.len());
    let depth = if patches.largest() > 1 { max_patch_size(D) } else { 1 };
    let mut lanes = ElementBatches::empty(LANES * depth, depth, &simplices.material, simplices.section)?;
    let (mut cache, mut history) = (NodeCache::new(rounding(&simplices.rest)), lanes.memory());
    for first in (0..patches.len()).step_by(LANES) {
        let ids = |lane: usize| if first + lane < patches.len() { patches.of(first + lane) } else { &[] };
        lanes.clear_incompatible();
        for k in 0..depth {
            let slots = std::array::from_fn(|lane| ids(lane).get(k).copied());
            simplices.fill_batch(&mut lanes, k, &slots, x, &mut cache);
            simplices.fill_history(&lanes, k, &slots, memory, &mut history);
        }
        let states = lanes.evaluate_held(&cache, &mut history);
        for lane in 0..LANES.min(patches.len() - first) {
            measured.energy[first + lane] = states.energy[lane];
            for (k, id) in ids(lane).iter().enumerate() {
                measured.stiffness[id.index()] = states.stiffness[k][lane];
                measured.jacobian[id.index()] = states.jacobian[k][lane];
            }
        }
    }
    Some(measured)
}

impl<const D: usize> Simplices<D> {
    /// Collects the reference shapes of eight elements.
    fn reference_batch(&self, elements: &[Option<ElementId>; LANES]) -> ReferenceBatch<D> {
        let (edges, ones) = ([[[0.0; LANES]; D]; D], [1.0; LANES]);
        let ratios = LaneRatios { strength: ones, bulk: ones };
        let mut rest = ReferenceBatch { edges, radius: ones, filled: [0.0; LANES], density: ones, ratios };
        for (lane, element) in elements.iter().enumerate() {
            let Some(element) = element else {
                (0..D).for_each(|i| rest.edges[i][i][lane] = 1.0);
                continue;
            };
            let reference = self.reference(*element);
            (rest.radius[lane], rest.filled[lane]) = (reference.radius, 1.0);
            rest.density[lane] = self.relative_density(*element);
            let ratios = self.ratios(*element);
            (rest.ratios.strength[lane], rest.ratios.bulk[lane]) = (ratios.strength, ratios.bulk);
            for i in 0..D {
                for j in 0..D {
                    rest.edges[i][j][lane] = reference.edges[(i, j)];
                }
            }
        }
        rest
    }

    /// Fills a batch with elements whose nodes have these numbers within the block.
    fn set_batch(
        &self,
        lanes: &mut ElementBatches<D>,
        at: usize,
        slots: &[Option<ElementId>; LANES],
        local: &[[u16; MAX_NODES]; LANES],
    ) {
        let rest = self.reference_batch(slots);
        lanes.set_batch(at, &rest, local);
        if self.is_layered() {
            lanes.set_ratios(at, rest.ratios);
        }
        for (lane, element) in slots.iter().enumerate() {
            if element.is_some_and(|element| !self.is_compatible(element)) {
                lanes.mark_incompatible(at * LANES + lane);
            }
        }
    }

    /// Fills the k-th batch with elements, each with nodes of its own.
    fn fill_batch(
        &self,
        lanes: &mut ElementBatches<D>,
        k: usize,
        slots: &[Option<ElementId>; LANES],
        x: &[Vector<D>],
        cache: &mut NodeCache,
    ) {
        let number = |lane: usize, a: usize| (k * LANES + lane) * (D + 1) + a;
        let numbers = std::array::from_fn(|lane| {
            let of = |a: usize| if a <= D { number(lane, a) as u16 } else { 0 };
            [0, 1, 2, 3].map(of)
        });
        self.set_batch(lanes, k, slots, &numbers);
        for (lane, element) in slots.iter().enumerate() {
            let Some(element) = element else { continue };
            let numbered = self.corners(*element).iter().enumerate().map(|(a, node)| (number(lane, a), *node));
            cache.load(Level::new(), &HeldNodes::new(x, &self.rest), numbered);
        }
    }

    /// Stores the history variables of the elements in the rows of the k-th batch.
    fn fill_history(
        &self,
        lanes: &ElementBatches<D>,
        k: usize,
        slots: &[Option<ElementId>; LANES],
        memory: &[HistoryVariables<D>],
        history: &mut [HistoryLanes],
    ) {
        let (rows, n) = (lanes.rows(), self.records());
        for (lane, element) in slots.iter().enumerate().filter(|_| n > 0) {
            let Some(element) = element else { continue };
            lanes.remember(&mut history[k * rows..(k + 1) * rows], lane, &memory[element.index() * n..][..n]);
        }
    }
}

impl<const D: usize> ElementBatches<D> {
    /// Evaluates the first group with all nodes held.
    fn evaluate_held(&self, cache: &NodeCache, memory: &mut [HistoryLanes]) -> BatchStates {
        // Not generic, like [`Self::sweep`].
        let lanes: &dyn Any = self;
        if let Some(lanes) = lanes.downcast_ref() {
            evaluate_plane(lanes, cache, memory)
        } else {
            evaluate_space(lanes.downcast_ref().expect("the gel has two or three dimensions"), cache, memory)
        }
    }

    /// Dispatches on the material, for patches of one or `N` elements.
    #[inline(always)]
    fn evaluate_by_law<const N: usize>(&self, cache: &NodeCache, memory: &mut [HistoryLanes]) -> BatchStates {
        match self.law() {
            BatchLaw::NeoHookean(gel, rest) => self.evaluate_by_depth::<N, _>(gel, rest, cache, memory),
            BatchLaw::TwoNetwork(gel, rest) => self.evaluate_by_depth::<N, _>(gel, rest, cache, memory),
        }
    }

    /// Dispatches on the vector unit and the patch depth.
    fn evaluate_by_depth<const N: usize, G: ElementLaw<D>>(
        &self,
        gel: &G,
        rest: &[G::Rest<LaneArray>],
        cache: &NodeCache,
        memory: &mut [HistoryLanes],
    ) -> BatchStates {
        if self.depth() == 1 {
            on!(narrow Level::new(), simd => self.evaluate_group::<1, _, _>(simd, gel, rest, cache, memory))
        } else {
            on!(narrow Level::new(), simd => self.evaluate_group::<N, _, _>(simd, gel, rest, cache, memory))
        }
    }

    /// Runs the stages of a sweep of zero duration, without the nodal sums.
    #[inline(always)]
    fn evaluate_group<const N: usize, G: ElementLaw<D>, S: Simd>(
        &self,
        simd: S,
        gel: &G,
        rest: &[G::Rest<LaneArray>],
        cache: &NodeCache,
        memory: &mut [HistoryLanes],
    ) -> BatchStates {
        let (batches, rest) = (self.batches_of::<N>(0), rest.first_chunk().expect("a group is whole"));
        let zero = f64x8::splat(simd, 0.0);
        let mut strains = [ElementDeformation::at_rest(zero); N];
        let strained = self.strain_group::<N, G, S>(0, batches, rest, cache.motion()[0], &mut strains);
        let mut slopes = [VolumetricSlopes { slope: zero, curvature: zero }; N];
        let mut volumes = [zero; N];
        for k in 0..N {
            volumes[k] = load_lanes(simd, &batches[k].volume);
        }
        let ratios = self.ratios_of::<N, S>(simd, 0);
        let mut energy =
            evaluate_volumetric(gel, &volumes, &strains, &mut slopes, ratios.as_ref().map(<[_; N]>::as_slice));
        let (mut states, rows) = (BatchStates::default(), gel.rows());
        for k in 0..N {
            let history = &mut memory[k * rows..(k + 1) * rows];
            let scale = load_lanes(simd, &batches[k].scale);
            let input = LawInput { volume: volumes[k], scale, rest: &rest[k], kick: GroupKick::NONE, history };
            let ratios = ratios.as_ref().map(|ratios| &ratios[k]);
            let forces = evaluate_elements(gel, self.section(), input, &strains[k], &slopes[k], ratios);
            energy = forces.energy.multiply_add(strained, energy);
            forces.stiffness.store_slice(&mut states.stiffness[k]);
            strains[k].jacobian().store_slice(&mut states.jacobian[k]);
        }
        energy.store_slice(&mut states.energy);
        states
    }
}

#[inline(never)]
fn evaluate_plane(lanes: &ElementBatches<2>, cache: &NodeCache, memory: &mut [HistoryLanes]) -> BatchStates {
    lanes.evaluate_by_law::<{ max_patch_size(2) }>(cache, memory)
}

#[inline(never)]
fn evaluate_space(lanes: &ElementBatches<3>, cache: &NodeCache, memory: &mut [HistoryLanes]) -> BatchStates {
    lanes.evaluate_by_law::<{ max_patch_size(3) }>(cache, memory)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::{
        Branch, BulkViscosity, Dashpot, EquationOfState, LayerStack, Material, MaterialLayer, MaterialRatios,
        MixedModuli, NeoHookean, TwoNetwork,
    };
    use crate::fem::potential::measure_patches;
    use crate::fem::{Potential, ReferenceShape, Section};
    use crate::math::Tensor;
    use crate::mesh::{BlockSpec, CellSplit, ElementPatches, Mesh, block, uniform};

    /// Returns a mesh of elements, not a multiple of eight, some of them incompatible, with or without patches.
    fn simplices<const D: usize>(
        material: &Material,
        section: Section,
        is_grouped: bool,
        is_layered: bool,
    ) -> Simplices<D> {
        let planes = std::array::from_fn(|_| uniform(0.5, 1.5, 0.25));
        let mut mesh = block::<D>(BlockSpec { planes, split: CellSplit::Centred, faces: vec![] });
        mesh.elements.truncate(mesh.elements.len() - 3);
        let strange = |e: u32| {
            let told = ReferenceShape::of(&mesh.rest, &mesh.elements[e as usize]);
            let bent = Tensor::<D>::from_fn(|i, j| if i == j { 1.1 } else { 0.1 * (i as f64 - j as f64) });
            (ElementId(e), ReferenceShape { edges: bent * told.edges, ..told })
        };
        let references: Vec<_> = (3..60).step_by(5).map(strange).collect();
        let n = mesh.elements.len();
        let mesh = Mesh { elements: mesh.elements, ..mesh };
        let patches = if is_grouped { ElementPatches::grouped(&mesh) } else { ElementPatches::alone(n) };
        let simplices = Simplices::in_patches(&mesh, patches, (*material, section)).with_references(&references);
        if !is_layered {
            return simplices;
        }
        let (bulk, moduli) = match material {
            Material::TwoNetwork(_) => (1.7, MixedModuli::Apart),
            _ => (2.5, MixedModuli::InProportion),
        };
        let layer = MaterialLayer { thickness: 1.0, ratios: MaterialRatios { strength: 2.5, bulk, density: 1.3 } };
        let stack = LayerStack::new(&[layer], moduli);
        let parts = |e: usize| [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.3, 0.7, 0.0, 0.0]][e % 3];
        simplices.with_layers(&stack, (0..n).map(parts).collect())
    }

    fn check<const D: usize>(material: &Material, section: Section, is_grouped: bool, is_layered: bool) {
        let all = simplices::<D>(material, section, is_grouped, is_layered);
        let mut memory = vec![HistoryVariables::default(); all.memories() * all.len()];
        for (e, memory) in memory.iter_mut().enumerate() {
            memory.damage = 0.1 * (e % 3) as f64;
        }
        for size in [0.0, 0.02, 0.1] {
            let wave = |i: usize, a: usize| size * ((7 * a + 3 * i) as f64).sin();
            let moved = |(a, x): (usize, &Vector<D>)| x + Vector::<D>::from_fn(|i, _| wave(i, a));
            let x: Vec<Vector<D>> = all.rest().iter().enumerate().map(moved).collect();
            let one = measure_patches(&all, &x, &memory);
            let eight = all.measure_all(&x, &memory);
            if !is_grouped {
                assert_eq!((&eight.jacobian, &eight.stiffness), (&one.jacobian, &one.stiffness), "{section:?} {size}");
            }
            let close = |found: &[f64], wanted: &[f64], part: f64| {
                let scale = wanted.iter().map(|w| w.abs()).fold(0.0, f64::max);
                found.len() == wanted.len() && found.iter().zip(wanted).all(|(f, w)| (f - w).abs() <= part * scale)
            };
            assert!(close(&eight.jacobian, &one.jacobian, 1e-14), "{section:?} {size}");
            assert!(close(&eight.energy, &one.energy, 1e-13), "{section:?} {size}");
            for ids in (0..all.patches().len()).map(|patch| all.patches().of(patch)) {
                // In lanes a single element among patches has the sum of two bounds, not the bound of the sum.
                let room = if ids.len() < all.patches().largest() { f64::INFINITY } else { 1e-8 };
                for e in ids.iter().map(|id| id.index()) {
                    let more = eight.stiffness[e] / one.stiffness[e] - 1.0;
                    // For a ring the bound contains the root of a rounded difference of stretches.
                    assert!((-1e-8..=room).contains(&more), "{section:?} {size}: {more}");
                }
            }
        }
    }

    #[test]
    fn lanes_agree_with_the_scalar_elements() {
        let branches = [Branch::new(2.0, Dashpot::linear(1e-3)), Branch::new(4.8, Dashpot::power_law(0.3, 0.8))];
        let viscosity = BulkViscosity { linear: 0.1, quadratic: 1.0 };
        let gel = |n: usize| TwoNetwork::new(3.0, &branches[..n], EquationOfState::new(60.0, 0.0, 20.0), 1.0);
        for material in [NeoHookean::new(3.0, 40.0).into(), gel(0).with_viscosity(viscosity).into(), gel(2).into()] {
            for (is_grouped, is_layered) in [(false, false), (false, true), (true, false), (true, true)] {
                check::<2>(&material, Section::Planar { thickness: 0.7 }, is_grouped, is_layered);
                check::<2>(&material, Section::Axisymmetric, is_grouped, is_layered);
                check::<3>(&material, Section::Spatial, is_grouped, is_layered);
            }
        }
    }
}
