//! Source and target of a history transfer: the old elements, and the composition of the new ones.

use super::patch_volume_share::shares;
use crate::fem::{HistoryVariables, Section, Simplices};
use crate::math::Vector;
use crate::mesh::{ElementId, Simplex};
use crate::remesh::{OverlapSource, ProposedMesh, TransferredFields, UnchangedElement};
use crate::state::MeshInstance;

/// Source mesh of a transfer, with the history variables of its elements.
pub(super) struct SourceMesh<'a, const D: usize> {
    pub potential: &'a Simplices<D>,
    pub old: &'a MeshInstance<D>,
    pub memory: &'a [HistoryVariables<D>],
    /// Ratio J/J̄ of each old element to its patch; 1 for a patch of one element.
    pub shares: Vec<f64>,
}

impl<'a, const D: usize> SourceMesh<'a, D> {
    /// Source mesh with the nodes at `x`.
    pub fn new(
        potential: &'a Simplices<D>,
        old: &'a MeshInstance<D>,
        memory: &'a [HistoryVariables<D>],
        x: &[Vector<D>],
    ) -> Self {
        Self { potential, old, memory, shares: shares(potential, x) }
    }

    /// History variables of an old element.
    pub fn memory(&self, same: UnchangedElement) -> HistoryVariables<D> {
        self.memory[same.element.index()]
    }

    /// Area or volume, or area times radius of a ring, of an old element at rest.
    pub fn rest(&self, element: ElementId) -> f64 {
        self.potential.reference(element).size(self.potential.section() == Section::Axisymmetric)
    }
}

/// Target mesh of a transfer, and the composition of its elements.
#[derive(Clone, Copy)]
pub(super) struct TargetMesh<'a, const D: usize> {
    /// Current nodal positions, and rest positions of the same matter.
    pub position: &'a [Vector<D>],
    pub rest: &'a [Vector<D>],
    pub elements: &'a [Simplex],
    /// Old element that each element is, if unchanged.
    pub same: &'a [Option<UnchangedElement>],
    /// Sources of the other elements, in order.
    pub sources: &'a [OverlapSource],
    /// True for the old mesh itself, kept where no other was accepted: elements unchanged in their patch keep their
    /// state.
    pub is_kept: bool,
}

impl<'a, const D: usize> TargetMesh<'a, D> {
    /// Target mesh of a remeshing.
    pub fn by(proposal: &'a ProposedMesh<D>, new: &'a TransferredFields<D>) -> Self {
        let TransferredFields { rest, same, sources, .. } = new;
        Self { position: &proposal.position, elements: &proposal.elements, rest, same, sources, is_kept: false }
    }
}
