//! Interface of the elements to the integrator: the potential energy of a gel.

use super::{
    DEPTH, Dissipation, ElementBatches, ElementResponse, ElementStates, GroupKick, HistoryVariables, MAX_NODES,
};
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, NodeId};

/// Potential energy V = Σ_P V_P(x) of patches P of elements.
pub trait Potential<const D: usize>: Send + Sync {
    /// Returns the number of elements.
    fn len(&self) -> usize;
    /// Returns true if there are no elements.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Returns the nodes of an element, at most [`MAX_NODES`].
    fn nodes(&self, element: ElementId) -> &[NodeId];
    /// Returns the patches of elements with a common energy, at most [`DEPTH`] elements each.
    fn patches(&self) -> &ElementPatches;
    /// Evaluates the energy of a patch, J, at the positions `x` of all nodes.
    ///
    /// `answers` receives the responses of the elements of the patch, in their order. `memory` holds the history
    /// variables of all elements, element by element, [`Self::memories`] of each.
    fn evaluate(
        &self,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64;
    /// Evaluates a patch at its next tick, for a kick, and updates its history variables.
    fn advance(
        &self,
        patch: usize,
        x: &[Vector<D>],
        _kick: GroupKick,
        memory: &mut [HistoryVariables<D>],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> Dissipation {
        Dissipation { energy: self.evaluate(patch, x, memory, answers), ..Dissipation::default() }
    }
    /// Evaluates a patch again at a tick to which it has been advanced.
    ///
    /// `viscous` is the part of U′ that viscosity added in each element at that tick, Pa.
    fn again(
        &self,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
        _viscous: &[f64; DEPTH],
        answers: &mut [ElementResponse<D>; DEPTH],
    ) -> f64 {
        self.evaluate(patch, x, memory, answers)
    }
    /// Returns the number of [`HistoryVariables`] records of an element.
    fn memories(&self) -> usize {
        0
    }
    /// Returns true if the elements have history variables.
    fn remembers(&self) -> bool {
        self.memories() > 0
    }
    /// Returns true if J is below the floor of the material law, in its continuation.
    fn is_crushed(&self, jacobian: f64) -> bool;
    /// Returns a multiple of the area or volume of an element with these corners.
    ///
    /// A ring with history variables has its full volume of revolution. Only for a potential with meshes.
    fn measure(&self, _corners: &[Vector<D>; MAX_NODES]) -> f64 {
        1.0
    }
    /// Returns true if [`Self::measure`] is a volume of revolution.
    fn measures_rings(&self) -> bool {
        false
    }
    /// Evaluates the states of all elements, without forces; agrees with [`Self::evaluate`] up to rounding.
    fn measure_all(&self, x: &[Vector<D>], memory: &[HistoryVariables<D>]) -> ElementStates {
        measure_patches(self, x, memory)
    }
    /// Returns the closing rate of an element, 1/s: 1 over the time until J reaches the margin of inversion, 0 if never.
    ///
    /// Arguments are its J and the positions, m, and velocities, m/s, of all nodes.
    fn closing(&self, _element: ElementId, _jacobian: f64, (_x, _v): (&[Vector<D>], &[Vector<D>])) -> f64 {
        0.0
    }
    /// Returns the rest positions of all nodes; only for a potential with a SIMD form.
    fn rest(&self) -> &[Vector<D>] {
        &[]
    }
    /// Builds the SIMD form of the elements, if the material has one.
    ///
    /// Lanes follow the order of `slots`, `None` in an empty lane; `local` numbers the nodes of the element in each
    /// slot.
    fn lanes(
        &self,
        _slots: &[Option<ElementId>],
        _depth: usize,
        _local: &[[u16; MAX_NODES]],
    ) -> Option<ElementBatches<D>> {
        None
    }
}

/// Evaluates the states of all elements, patch by patch.
pub(super) fn measure_patches<const D: usize, P: Potential<D> + ?Sized>(
    potential: &P,
    x: &[Vector<D>],
    memory: &[HistoryVariables<D>],
) -> ElementStates {
    let mut measured = ElementStates::at_rest(potential.len(), potential.patches().len());
    for patch in 0..potential.patches().len() {
        let mut answers = [ElementResponse::default(); DEPTH];
        measured.energy[patch] = potential.evaluate(patch, x, memory, &mut answers);
        for (element, answer) in potential.patches().of(patch).iter().zip(&answers) {
            measured.stiffness[element.index()] = answer.stiffness;
            measured.jacobian[element.index()] = answer.jacobian;
        }
    }
    measured
}
