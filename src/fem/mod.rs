//! Finite elements: the potential energy of simplices in F-bar patches, scalar and SIMD.

mod batch;
mod element_pressure;
mod element_states;
mod facet_pressure;
mod history;
mod hyperelastic_simd;
mod inversion_time;
mod kinematics;
mod layout;
mod node_cache;
mod pipeline;
mod rest_geometry;
mod simd_material;
mod simplex;
mod simplices;
mod symmetric_tensor;
mod transpose;
mod viscoelastic;
mod viscoelastic_simd;
mod viscoplastic;
mod viscoplastic_simd;

use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, NodeId};

pub(crate) use batch::on;
pub use batch::{ElementBatch, LANES};
pub use facet_pressure::{FacetPressure, push};
pub use history::{HistoryLanes, HistoryVariables};
pub use layout::{
    DEPTH, ElementBatches, ElementCorner, GroupKick, GroupKicks, GroupResponse, ReportPower, SweepInput, SweepOutput,
    max_patch_size,
};
pub use node_cache::{
    HeldNodes, MOST_LOCAL_NODES, NodeAccumulator, NodeCache, NodeMotion, NodeRow, NodeSource, rounding,
};
pub use simplex::{ReferenceShape, Section};
pub use simplices::Simplices;
pub use viscoplastic::Dissipation;

/// Inversion margin: a step may take J at most this far below 0, by extrapolation of the rate at its start.
///
/// A stiffness bound at the start of the step does not see inversion. A strip of a wall, 0.1 mm thick, whose sides
/// met at 50 m/s, had J = −2.3 and 9000 times its κ after one step. It returned many times the energy of its closing.
/// The margin is half of the J at which the continuation begins, since the resistance grows no further there. Halving
/// J per step is no alternative: J → 0 in ever shorter steps, and `ball-square` at 30 m/s, which reaches J = 0.01 on
/// its fixed mesh, ended there.
pub const TURNED: f64 = 0.1;
/// Look-ahead of the inversion check, in steps of the last length.
///
/// The closing rate is reported if an element would reach the margin [`TURNED`] within the look-ahead: a step may
/// then be doubled without another check.
pub const FORESEEN: f64 = 2.0;

/// Most nodes of an element.
pub const MAX_NODES: usize = 4;

/// Response of an element at one position of its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementResponse<const D: usize> {
    /// Nodal forces −∂V/∂x, N: the share of this element in the energy V of its patch.
    pub forces: [Vector<D>; MAX_NODES],
    /// Upper bound κ of the greatest eigenvalue of the element's share of the stiffness matrix ∂²V/∂x∂x, N/m.
    pub stiffness: f64,
    /// J = det F.
    pub jacobian: f64,
}

impl<const D: usize> Default for ElementResponse<D> {
    fn default() -> Self {
        Self { forces: [Vector::zeros(); MAX_NODES], stiffness: 0.0, jacobian: 1.0 }
    }
}

/// Responses of all elements at one position of the nodes, without the forces.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementStates {
    /// κ of each element, N/m.
    pub stiffness: Vec<f64>,
    /// J of each element.
    pub jacobian: Vec<f64>,
    /// V of each patch, J.
    pub energy: Vec<f64>,
}

impl ElementStates {
    /// Creates the states of `n_elements` elements in `n_patches` patches, all at rest.
    fn at_rest(n_elements: usize, n_patches: usize) -> Self {
        Self { stiffness: vec![0.0; n_elements], jacobian: vec![1.0; n_elements], energy: vec![0.0; n_patches] }
    }

    /// Evaluates a patch and records the states of its elements.
    fn record_patch<const D: usize, P: Potential<D> + ?Sized>(
        &mut self,
        potential: &P,
        patch: usize,
        x: &[Vector<D>],
        memory: &[HistoryVariables<D>],
    ) {
        let mut answers = [ElementResponse::default(); DEPTH];
        self.energy[patch] = potential.evaluate(patch, x, memory, &mut answers);
        for (element, answer) in potential.patches().of(patch).iter().zip(&answers) {
            self.stiffness[element.index()] = answer.stiffness;
            self.jacobian[element.index()] = answer.jacobian;
        }
    }
}

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
    /// Evaluates a patch at its next tick, `step` s after the last, and updates its history variables.
    fn advance(
        &self,
        patch: usize,
        x: &[Vector<D>],
        (_, memory): (f64, &mut [HistoryVariables<D>]),
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
        (memory, _viscous): (&[HistoryVariables<D>], &[f64; DEPTH]),
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
        let mut measured = ElementStates::at_rest(self.len(), self.patches().len());
        (0..self.patches().len()).for_each(|patch| measured.record_patch(self, patch, x, memory));
        measured
    }
    /// Returns the closing rate of an element, 1/s: 1 over the time until J reaches the margin [`TURNED`], 0 if never.
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
