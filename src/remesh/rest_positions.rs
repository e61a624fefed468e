//! Rest positions and interpolated fields of the nodes of a new mesh, by their location in the old mesh.

use super::barycentric::{DeformedElement, interpolate};
use super::overlap_candidates::OverlapCandidates;
use super::{DeformedMesh, NodeOrigin, ProposedMesh};
use crate::math::{Vector, map_in_order};
use crate::mesh::{ElementId, NodeId};

/// Distance outside the old mesh, relative to the longest edge of the nearest element, above which a point is a miss.
/// It is far above the rounding of a boundary point and far below any relevance to a field.
const OUTSIDE: f64 = 1e-9;

/// Least number of nodes that a thread locates.
const NODES_PER_THREAD: usize = 64;

/// Location of a new node in the old mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
enum RestLocation {
    Node(NodeId),
    /// Nodes of an element, and their weights.
    Between([NodeId; 4], [f64; 4]),
    /// No location: there is no old element.
    Nowhere,
}

/// Locations of all new nodes in the old mesh.
#[derive(Debug)]
pub(super) struct RestLocations {
    traces: Vec<RestLocation>,
    /// Number of interior points outside the old mesh; they are located at its nearest point.
    pub misses: usize,
}

impl RestLocations {
    /// Locates the nodes of a new mesh, given the removed old elements, which new interior points replace.
    pub fn of<const D: usize>(
        old: &DeformedMesh<'_, D>,
        new: &ProposedMesh<D>,
        (gone, under): (&[ElementId], &OverlapCandidates<'_, D>),
    ) -> Self {
        let element_of = elements_of(new);
        let inside = |node: usize| {
            let Some(place) = under.nearest(element_of[node], &new.position[node]) else {
                return (RestLocation::Nowhere, true);
            };
            let nodes = old.mesh.elements[gone[place.cell].index()];
            let longest = DeformedElement::of(old.position, &nodes).longest_edge_squared();
            (RestLocation::Between(nodes, place.weights), place.distance > OUTSIDE * OUTSIDE * longest)
        };
        let trace = |node: &usize| match new.origin[*node] {
            NodeOrigin::Kept(node) => (RestLocation::Node(node), false),
            NodeOrigin::Surface([a, b, c], [u, v, w]) => (RestLocation::Between([a, b, c, c], [u, v, w, 0.0]), false),
            NodeOrigin::Inside => inside(*node),
        };
        let nodes: Vec<usize> = (0..new.position.len()).collect();
        let found = map_in_order(&nodes, NODES_PER_THREAD, trace);
        let misses = found.iter().filter(|(_, is_miss)| *is_miss).count();
        Self { traces: found.into_iter().map(|(location, _)| location).collect(), misses }
    }

    /// Interpolates an old field to the new nodes: kept nodes keep their values bit for bit.
    pub fn values<const D: usize>(&self, field: &[Vector<D>]) -> Vec<Option<Vector<D>>> {
        let at = |node: NodeId| field[node.index()];
        let value = |trace: &RestLocation| match trace {
            RestLocation::Node(node) => Some(at(*node)),
            RestLocation::Between(nodes, weights) => Some(interpolate(&nodes.map(at), weights)),
            RestLocation::Nowhere => None,
        };
        self.traces.iter().map(value).collect()
    }
}

/// An element of each new node.
fn elements_of<const D: usize>(new: &ProposedMesh<D>) -> Vec<usize> {
    let mut element_of = vec![0; new.position.len()];
    for (element, nodes) in new.elements.iter().enumerate() {
        nodes[..=D].iter().for_each(|node| element_of[node.index()] = element);
    }
    element_of
}

/// Held directions of the new nodes. Kept nodes keep theirs; a boundary point has those common to all nodes that it
/// interpolates.
pub(super) fn held<const D: usize>(old: &[[bool; D]], origin: &[NodeOrigin]) -> Vec<[bool; D]> {
    let of = |origin: &NodeOrigin| match *origin {
        NodeOrigin::Kept(node) => old[node.index()],
        NodeOrigin::Surface(nodes, weights) => std::array::from_fn(|axis| {
            nodes.iter().zip(weights).all(|(node, weight)| weight == 0.0 || old[node.index()][axis])
        }),
        NodeOrigin::Inside => [false; D],
    };
    origin.iter().map(of).collect()
}
