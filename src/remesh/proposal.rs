//! Deformed mesh, and the proposal of a mesh that replaces it.

use crate::math::Vector;
use crate::mesh::{ElementId, Mesh, NodeId, Simplex};

/// Mesh in its deformed configuration.
#[derive(Debug, Clone, Copy)]
pub struct DeformedMesh<'a, const D: usize> {
    /// Mesh with its rest positions.
    pub mesh: &'a Mesh<D>,
    /// Current positions of the nodes, m.
    pub position: &'a [Vector<D>],
}

/// Origin of a node of a new mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NodeOrigin {
    /// Node of the old mesh at its current position.
    Kept(NodeId),
    /// Point of the old boundary, as weights of the nodes of one of its facets: none negative, of sum 1. An edge of the
    /// plane repeats its second node with weight 0.
    Surface([NodeId; 3], [f64; 3]),
    /// Point in the interior.
    Inside,
}

/// Proposed mesh of the same body, without fields.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedMesh<const D: usize> {
    /// Positions of the nodes, m.
    pub position: Vec<Vector<D>>,
    /// Origins of the nodes.
    pub origin: Vec<NodeOrigin>,
    /// Elements, positively oriented at `position`.
    pub elements: Vec<Simplex>,
    /// Old elements that each new element may overlap, ascending. An empty entry, or an empty list, admits all old
    /// elements. The restriction matters where a body overlaps itself: a nearby old element need not be the source of a
    /// new one.
    pub over: Vec<Vec<ElementId>>,
    /// Loss of area or volume, m² or m³, by cutting off loops and needles of the boundary and by moving new boundary
    /// points out of bodies.
    pub cleared: f64,
}
