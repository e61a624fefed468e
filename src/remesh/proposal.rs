//! Deformed mesh, and the proposal of a mesh that replaces it.

use crate::math::Vector;
use crate::mesh::{ElementId, Mesh, NodeId, Simplex};
use std::sync::Arc;

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

impl NodeOrigin {
    /// Weighted mean of points of the old surface; `None` if it involves an interior point, or more than three old nodes.
    #[must_use]
    pub fn blend(parts: &[(Self, f64)]) -> Option<Self> {
        let (mut nodes, mut weights, mut n) = ([NodeId::default(); 3], [0.0; 3], 0);
        for (origin, part) in parts {
            for (node, weight) in origin.parents()?.into_iter().filter(|(_, weight)| part * *weight > 0.0) {
                let k = nodes[..n].iter().position(|other| *other == node).unwrap_or(n);
                *nodes.get_mut(k)? = node;
                weights[k] += part * weight;
                n = n.max(k + 1);
            }
        }
        let last = nodes[n.checked_sub(1)?];
        nodes[n..].fill(last);
        let whole: f64 = weights.iter().sum();
        Some(Self::Surface(nodes, weights.map(|weight| weight / whole)))
    }

    /// Old nodes that a point of the old surface interpolates, and their weights; `None` in the interior.
    #[must_use]
    pub fn parents(&self) -> Option<[(NodeId, f64); 3]> {
        match *self {
            Self::Kept(node) => Some([(node, 1.0), (node, 0.0), (node, 0.0)]),
            Self::Surface(nodes, weights) => Some(std::array::from_fn(|k| (nodes[k], weights[k]))),
            Self::Inside => None,
        }
    }
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
    pub over: Vec<Arc<[ElementId]>>,
}
