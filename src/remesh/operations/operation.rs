//! Operations as values: what they replace, and by what.

use crate::math::Vector;
use crate::mesh::{ElementId, NodeId, Simplex};
use crate::remesh::NodeOrigin;

/// Rest position, position and velocity of a node, and where it lies in the first mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EditedNode<const D: usize> {
    pub rest: Vector<D>,
    pub position: Vector<D>,
    pub velocity: Vector<D>,
    pub origin: NodeOrigin,
}

/// Kind of an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OperationKind {
    Split,
    Collapse,
    Flip,
    Move,
}

/// Replacement of the elements of a cavity.
#[derive(Debug, Clone)]
pub struct Operation<const D: usize> {
    /// Kind.
    pub kind: OperationKind,
    /// Elements that are replaced.
    pub old: Vec<ElementId>,
    /// Nodes of the elements that replace them.
    pub new: Vec<Simplex>,
    /// Node that is made or moved, and its new state.
    pub node: Option<(NodeId, EditedNode<D>)>,
    /// Ends of the edge that is split, collapsed, removed or, by the flip of a facet, made; the node that is moved, twice.
    pub parents: [NodeId; 2],
}
