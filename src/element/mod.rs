//! Potential energies made of patches, each local to its own nodes: what the integrator steps.

mod simplices;

use crate::algebra::Vector;
use crate::mesh::{ElementId, NodeId};

pub use simplices::{Section, Simplices};

/// Most nodes a patch may have.
pub const MAX_NODES: usize = 8;

/// What a patch answers at one position of its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Evaluation {
    /// V, stored energy, J.
    pub energy: f64,
    /// κ, upper bound of the greatest eigenvalue of the patch's stiffness matrix ∂²V/∂x∂x, N/m.
    pub stiffness: f64,
    /// J = det F.
    pub jacobian: f64,
}

/// An elastic energy V = Σ_K V_K(x) of patches K.
pub trait Potential<const D: usize>: Send + Sync {
    /// Number of patches.
    fn len(&self) -> usize;
    /// Whether there are no patches.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Nodes of each patch, at most [`MAX_NODES`].
    fn stride(&self) -> usize;
    /// The nodes of a patch.
    fn nodes(&self, patch: ElementId) -> &[NodeId];
    /// Energy, stiffness bound and J at the positions `x` of all nodes; `forces` receives −∂V_K/∂x of its nodes, N.
    fn evaluate(&self, patch: ElementId, x: &[Vector<D>], forces: &mut [Vector<D>]) -> Evaluation;
    /// Whether the patch is crushed beyond what its material law means (below the continuation).
    fn is_crushed(&self, jacobian: f64) -> bool;
}
