//! Topology of a gel whose surface may be smoothed: operations on it must not join or part what they move.

use super::editable_mesh::{EditableMesh, ReferenceConfiguration};
use super::operation::{Operation, OperationKind};
use crate::mesh::NodeId;

impl<const D: usize> EditableMesh<'_, D> {
    /// Returns true if an operation keeps the topology of the gel. Elements that are positive and fill the same gel
    /// exactly do; of a surface that may be smoothed, collapses and flips are checked. An edge where erosion has left
    /// gel that only touches itself stays as it is: its node would be two on both sides of the contact.
    pub(super) fn keeps_topology(&self, operation: &Operation<D>) -> bool {
        if self.configuration == ReferenceConfiguration::Rest || !self.changes_surface(operation) {
            return true;
        }
        let [a, b] = operation.parents;
        match operation.kind {
            OperationKind::Collapse => !self.is_contact(a, b) && self.satisfies_link_condition(a, b),
            OperationKind::Flip => self.flips_surface(operation),
            OperationKind::Split => !self.is_contact(a, b),
            OperationKind::Move => true,
        }
    }

    /// Returns true if an operation replaces facets of the surface.
    pub(super) fn changes_surface(&self, operation: &Operation<D>) -> bool {
        let [a, b] = operation.parents;
        match operation.kind {
            OperationKind::Split | OperationKind::Flip => self.is_boundary_edge(a, b),
            OperationKind::Collapse | OperationKind::Move => self.is_boundary(a),
        }
    }

    /// Returns true if the links of the ends of a surface edge have nothing in common but the link of the edge (Dey,
    /// Edelsbrunner, Guha & Nekhayev 1999).
    fn satisfies_link_condition(&self, a: NodeId, b: NodeId) -> bool {
        let is_of_link = |nodes: &[NodeId]| self.has_element_with(a, &[&[b], nodes].concat());
        let is_shared = |nodes: &[NodeId]| self.has_element_with(a, nodes) && self.has_element_with(b, nodes);
        let shared: Vec<NodeId> =
            self.neighbours(a).into_iter().filter(|node| *node != b && is_shared(&[*node])).collect();
        let is_loop = |node: NodeId| self.is_boundary_edge(a, node) && self.is_boundary_edge(b, node);
        let is_facet = |node: NodeId| D == 3 && self.is_boundary_facet([a, b, node]);
        let pairs = || (0..shared.len()).flat_map(|j| (0..j).map(move |i| [i, j])).map(|pair| pair.map(|k| shared[k]));
        shared.iter().all(|node| is_of_link(&[*node]) && (!is_loop(*node) || is_facet(*node)))
            && (D == 2 || pairs().all(|edge| !is_shared(&edge) || is_of_link(&edge)))
    }

    /// Returns true if the removal of a surface edge flips it: the edge that takes its place joins the ends of the ring
    /// around it, and is new.
    fn flips_surface(&self, operation: &Operation<D>) -> bool {
        let [a, b] = operation.parents;
        let corners = || operation.old.iter().flat_map(|element| self.corners(*element)).copied();
        let count = |node: NodeId| corners().filter(|other| *other == node).count();
        let ends: Vec<NodeId> = corners().filter(|node| *node != a && *node != b && count(*node) == 1).collect();
        let is_of_all = |end: &NodeId| operation.new.iter().all(|nodes| nodes[..=D].contains(end));
        let has_all = operation.new.len() == 2 * (operation.old.len() - 1);
        ends.len() == 2 && has_all && ends.iter().any(is_of_all) && self.around_edge(ends[0], ends[1]).is_empty()
    }

    /// Returns true if gel only touches itself along an edge, or the edge is not of the surface.
    fn is_contact(&self, a: NodeId, b: NodeId) -> bool {
        self.boundary_facets_at(a, b).count() != D - 1
    }

    /// Returns true if an element around a node has all of these nodes.
    fn has_element_with(&self, node: NodeId, others: &[NodeId]) -> bool {
        self.around(node).iter().any(|element| others.iter().all(|other| self.corners(*element).contains(other)))
    }
}
