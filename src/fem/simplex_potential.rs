//! Potential energy of the elements of a gel, by its material.

use super::element_states::{build_batches, evaluate_all};
use super::history::MOST_MEMORIES;
use super::inversion_time::closing_rate_of_element;
use super::potential::measure_patches;
use super::scalar::one_lane::PatchUpdate;
use super::simd::batch::on;
use super::{
    DEPTH, Dissipation, ElementBatches, ElementResponse, ElementStates, GroupKick, HistoryVariables, MAX_NODES,
    Potential, ReferenceShape, Simplices,
};
use crate::constitutive::{Material, NeoHookean};
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, NodeId};
use fearless_simd::Level;
use std::ops::Range;

/// History variables of the elements of a patch, element by element.
type PatchHistory<const D: usize> = [HistoryVariables<D>; DEPTH * MOST_MEMORIES];

impl<const D: usize> Simplices<D> {
    /// Collects the history variables of the elements of a patch.
    fn patch_history(&self, ids: &[ElementId], memory: &[HistoryVariables<D>]) -> PatchHistory<D> {
        let mut own = [HistoryVariables::default(); DEPTH * MOST_MEMORIES];
        for (k, id) in ids.iter().enumerate() {
            own[self.history_range(k)].copy_from_slice(&memory[self.history_range(id.index())]);
        }
        own
    }

    /// Returns the range of the history records of an element.
    fn history_range(&self, element: usize) -> Range<usize> {
        element * self.records()..(element + 1) * self.records()
    }

    /// Evaluates a patch for a kick; `viscous` is the held part of U′ of each element at its last tick again, Pa.
    fn evaluate_by_law(
        &self,
        ids: &[ElementId],
        x: &[Vector<D>],
        kick: GroupKick,
        own: &mut PatchHistory<D>,
        viscous: &[f64; DEPTH],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        let memory = &mut own[..ids.len() * self.records()];
        let update = PatchUpdate { kick, memory, viscous };
        // A fused multiply-add is one instruction of AVX2, and a call without it.
        on!(narrow Level::new(), _simd => match &self.material {
            Material::NeoHookean(gel) => self.evaluate_patch(gel, ids, x, update, answers),
            Material::MooneyRivlin(gel) => self.evaluate_patch(gel, ids, x, update, answers),
            Material::Ogden(gel) => self.evaluate_patch(gel, ids, x, update, answers),
            Material::TwoNetwork(gel) => self.evaluate_patch(gel, ids, x, update, answers),
        })
    }
}

impl<const D: usize> Potential<D> for Simplices<D> {
    fn len(&self) -> usize {
        self.elements().len()
    }

    fn nodes(&self, element: ElementId) -> &[NodeId] {
        self.corners(element)
    }

    fn patches(&self) -> &ElementPatches {
        &self.patches
    }

    fn evaluate(
        &self,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        self.again(patch, x, memory, &[0.0; DEPTH], answers)
    }

    fn advance(
        &self,
        patch: usize,
        x: &[Vector<D>],
        kick: GroupKick,
        memory: &mut [HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        let ids = self.patches.of(patch);
        let mut own = self.patch_history(ids, memory);
        let spent = self.evaluate_by_law(ids, x, kick, &mut own, &[0.0; DEPTH], answers);
        for (k, id) in ids.iter().enumerate() {
            memory[self.history_range(id.index())].copy_from_slice(&own[self.history_range(k)]);
        }
        spent
    }

    fn again(
        &self,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
        viscous: &[f64; DEPTH],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        let ids = self.patches.of(patch);
        self.evaluate_by_law(ids, x, GroupKick::NONE, &mut self.patch_history(ids, memory), viscous, answers).energy
    }

    fn memories(&self) -> usize {
        self.records()
    }

    fn is_crushed(&self, jacobian: f64) -> bool {
        jacobian < NeoHookean::FLOOR
    }

    fn closing(&self, element: ElementId, jacobian: f64, now: (&[Vector<D>], &[Vector<D>])) -> f64 {
        closing_rate_of_element(jacobian, &self.elements()[element.index()], self.section, now.0, now.1)
    }

    fn measure(&self, corners: &[Vector<D>; MAX_NODES]) -> f64 {
        self.measure_shape(&ReferenceShape::of(corners, &[0, 1, 2, 3].map(NodeId)))
    }

    fn measures_rings(&self) -> bool {
        self.has_ring_volumes()
    }

    fn rest(&self) -> &[Vector<D>] {
        &self.rest
    }

    fn lanes(
        &self,
        slots: &[Option<ElementId>],
        depth: usize,
        local: &[[u16; MAX_NODES]],
    ) -> Option<ElementBatches<D>> {
        build_batches(self, slots, depth, local)
    }

    fn measure_all(&self, x: &[Vector<D>], memory: &[HistoryVariables<D>]) -> ElementStates {
        evaluate_all(self, x, memory).unwrap_or_else(|| measure_patches(self, x, memory))
    }
}
