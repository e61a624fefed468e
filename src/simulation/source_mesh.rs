//! What the elements of an old mesh were, and what those of a new one are made of.

use super::patch_volume_share::shares;
use crate::fem::{Memory, Section, Simplices};
use crate::math::Vector;
use crate::mesh::{ElementId, Simplex};
use crate::remesh::{Proposal, Same, Source, Transferred};
use crate::state::Birth;

/// What the elements of an old mesh were, and what they remember.
pub(super) struct Past<'a, const D: usize> {
    pub potential: &'a Simplices<D>,
    pub old: &'a Birth<D>,
    pub memory: &'a [Memory<D>],
    /// J of each old element as a part of that of its patch, 1 of one by itself.
    pub shares: Vec<f64>,
}

impl<'a, const D: usize> Past<'a, D> {
    /// With the nodes at these positions.
    pub fn new((potential, old, memory): (&'a Simplices<D>, &'a Birth<D>, &'a [Memory<D>]), x: &[Vector<D>]) -> Self {
        Self { potential, old, memory, shares: shares(potential, x) }
    }

    /// What an old element remembers.
    pub fn memory(&self, same: Same) -> Memory<D> {
        self.memory[same.element.index()]
    }

    /// Area or volume, or area times radius of a ring, of an old element at rest.
    pub fn rest(&self, element: ElementId) -> f64 {
        self.potential.reference(element).size(self.potential.section() == Section::Axisymmetric)
    }
}

/// The elements of a new mesh, and what they are made of.
#[derive(Clone, Copy)]
pub(super) struct Made<'a, const D: usize> {
    /// Where its nodes are, and where their matter was at rest.
    pub position: &'a [Vector<D>],
    pub rest: &'a [Vector<D>],
    pub elements: &'a [Simplex],
    /// The old element that each is, if it is one.
    pub same: &'a [Option<Same>],
    /// What the others are made of, in their order.
    pub sources: &'a [Source],
    /// Whether it is the old mesh itself, where no other was taken: what stands in its patch goes on as it is.
    pub is_kept: bool,
}

impl<'a, const D: usize> Made<'a, D> {
    /// By an exchange.
    pub fn by(proposal: &'a Proposal<D>, new: &'a Transferred<D>) -> Self {
        let Transferred { rest, same, sources, .. } = new;
        Self { position: &proposal.position, elements: &proposal.elements, rest, same, sources, is_kept: false }
    }
}
