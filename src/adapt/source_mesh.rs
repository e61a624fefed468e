//! Source and target of a history transfer: the old elements, and the composition of the new ones.

use super::patch_volume_share::{shares, shares_after_loss};
use crate::constitutive::ElasticAverage;
use crate::fem::{HistoryVariables, ReferenceShape, Section, Simplices};
use crate::math::{Tensor, Vector};
use crate::mesh::{ElementId, Simplex};
use crate::remesh::{OverlapSource, ProposedMesh, TransferredFields, UnchangedElement};
use crate::state::MeshInstance;

/// Source mesh of a transfer, with the history variables of its elements.
pub(super) struct SourceMesh<'a, const D: usize> {
    pub potential: &'a Simplices<D>,
    pub old: &'a MeshInstance<D>,
    pub memory: &'a [HistoryVariables<D>],
    /// Factor of each old element's rest measure where its patch changes: its J/J̄, 1 for a patch of one element.
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

    /// Source mesh, with the nodes at `x`, of what remains once these elements are lost: the rest of a patch keeps its J̄.
    pub fn after_loss(
        potential: &'a Simplices<D>,
        old: &'a MeshInstance<D>,
        memory: &'a [HistoryVariables<D>],
        x: &[Vector<D>],
        lost: &[bool],
    ) -> Self {
        Self { potential, old, memory, shares: shares_after_loss(potential, x, lost) }
    }

    /// Reference of an unchanged element, whose nodes may be permuted now.
    pub fn kept_reference(&self, same: UnchangedElement) -> ReferenceShape<D> {
        let reference = self.potential.reference(same.element);
        if same == UnchangedElement::in_order(same.element) {
            return reference;
        }
        let corner = |a: usize| if a == 0 { Vector::<D>::zeros() } else { reference.edges.column(a - 1).into_owned() };
        let corners = same.turned(&[0, 1, 2, 3].map(|a| if a <= D { corner(a) } else { Vector::<D>::zeros() }));
        ReferenceShape { edges: Tensor::<D>::from_fn(|i, j| corners[j + 1][i] - corners[0][i]), ..reference }
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
    /// Rule of the averages of a two-network gel.
    pub rule: ElasticAverage,
}

impl<'a, const D: usize> TargetMesh<'a, D> {
    /// Target mesh of a remeshing.
    pub fn by(proposal: &'a ProposedMesh<D>, new: &'a TransferredFields<D>, rule: ElasticAverage) -> Self {
        let TransferredFields { rest, same, sources, .. } = new;
        Self { position: &proposal.position, elements: &proposal.elements, rest, same, sources, rule }
    }
}
