//! Construction of the operations: split and collapse of an edge, flip, and move of a node, written once for the plane
//! and for space.

use super::editable_mesh::{EditableMesh, ReferenceConfiguration};
use super::operation::{EditedNode, Operation, OperationKind};
use crate::math::Vector;
use crate::mesh::{CORNERS, ElementId, NodeId, Simplex};
use crate::remesh::NodeOrigin;
use crate::remesh::barycentric::DeformedElement;

/// Nodes with `from` replaced by `to`.
fn replaced(nodes: &Simplex, from: NodeId, to: NodeId) -> Simplex {
    nodes.map(|node| if node == from { to } else { node })
}

/// Point between two states, `part` of the way to the second.
fn between<const D: usize>(a: &EditedNode<D>, b: &EditedNode<D>, part: f64) -> EditedNode<D> {
    let mix = |a: Vector<D>, b: Vector<D>| a * (1.0 - part) + b * part;
    EditedNode {
        rest: mix(a.rest, b.rest),
        position: mix(a.position, b.position),
        velocity: mix(a.velocity, b.velocity),
        origin: mixed_origin::<D>(&[(a.origin, 1.0 - part), (b.origin, part)]),
    }
}

/// Origin of a point between others on a facet of the old surface; interior where these do not tell.
fn mixed_origin<const D: usize>(parts: &[(NodeOrigin, f64)]) -> NodeOrigin {
    let is_of_facet = |origin: &NodeOrigin| {
        origin.parents().is_some_and(|parents| parents.iter().filter(|(_, weight)| *weight > 0.0).count() <= D)
    };
    NodeOrigin::blend(parts).filter(is_of_facet).unwrap_or(NodeOrigin::Inside)
}

impl<const D: usize> EditableMesh<'_, D> {
    /// Split of an edge at its middle.
    pub(super) fn split(&self, a: NodeId, b: NodeId) -> Operation<D> {
        let (old, node) = (self.around_edge(a, b), NodeId(self.nodes.len() as u32));
        let halves = |element: &ElementId| {
            let nodes = &self.elements[element.index()];
            [replaced(nodes, a, node), replaced(nodes, b, node)]
        };
        let mut new = Vec::with_capacity(2 * old.len());
        new.extend(old.iter().flat_map(halves));
        let middle = between(&self.nodes[a.index()], &self.nodes[b.index()], 0.5);
        let node = Some((node, middle));
        Operation { kind: OperationKind::Split, old, new, node, parents: [a, b] }
    }

    /// Collapse of an edge: `a` is given up, and `b` moves the part `part` of the way to it. `None` where the boundary
    /// or its supports would change.
    pub(super) fn collapse(&self, a: NodeId, b: NodeId, part: f64) -> Option<Operation<D>> {
        let (is_boundary, moves) = (self.is_boundary(a), part > 0.0);
        let [held, held_after] = [a, b].map(|node| self.held[node.index()]);
        // A surface without a shape at rest may end elsewhere at the axis or at a plane of symmetry.
        let is_freer =
            self.configuration == ReferenceConfiguration::Present && (0..D).all(|axis| held_after[axis] || !held[axis]);
        if is_boundary && !((is_freer || held == held_after) && self.is_boundary_edge(a, b)) {
            return None;
        }
        if moves && (is_boundary != self.is_boundary(b) || held != held_after) {
            return None;
        }
        let around = self.around(a);
        let mut old = Vec::with_capacity(around.len() + if moves { self.around(b).len() } else { 0 });
        old.extend(around);
        if moves {
            old.extend(self.around(b).iter().filter(|element| !self.corners(**element).contains(&a)));
        }
        let stays = |element: &&ElementId| {
            let nodes = self.corners(**element);
            !(nodes.contains(&a) && nodes.contains(&b))
        };
        let mut new = Vec::with_capacity(old.len());
        new.extend(old.iter().filter(stays).map(|e| replaced(&self.elements[e.index()], a, b)));
        let node = moves.then(|| (b, between(&self.nodes[b.index()], &self.nodes[a.index()], part)));
        Some(Operation { kind: OperationKind::Collapse, old, new, node, parents: [a, b] })
    }

    /// Flip of the facet opposite a corner: its elements become those around the edge between the two nodes across it,
    /// two in the plane, three in space. `None` on the boundary.
    pub(super) fn flip(&self, element: ElementId, corner: usize) -> Option<Operation<D>> {
        let other = self.across(element, corner)?;
        let nodes = self.elements[element.index()];
        let apex = *self.corners(other).iter().find(|node| !nodes[..=D].contains(node))?;
        let new = (0..=D).filter(|k| *k != corner).map(|k| replaced(&nodes, nodes[k], apex)).collect();
        Some(Self::flip_of(vec![element, other], new, [nodes[corner], apex]))
    }

    /// Removal of an edge in space: the elements around it become those that join `to`, a node of the ring around the
    /// edge, with the facets of the ring.
    pub(super) fn remove_edge(&self, a: NodeId, b: NodeId, to: NodeId) -> Operation<D> {
        let old = self.around_edge(a, b);
        let apart = old.iter().map(|element| self.elements[element.index()]).filter(|nodes| !nodes[..=D].contains(&to));
        let mut new = Vec::with_capacity(2 * old.len());
        new.extend(apart.flat_map(|nodes| [replaced(&nodes, a, to), replaced(&nodes, b, to)]));
        Self::flip_of(old, new, [a, b])
    }

    fn flip_of(old: Vec<ElementId>, new: Vec<Simplex>, parents: [NodeId; 2]) -> Operation<D> {
        Operation { kind: OperationKind::Flip, old, new, node: None, parents }
    }

    /// Move of a node a part of the way to a neighbour.
    pub(super) fn moved_towards(&self, node: NodeId, other: NodeId, part: f64) -> Operation<D> {
        self.move_of(node, between(&self.nodes[node.index()], &self.nodes[other.index()], part))
    }

    /// Move of a node to a rest position in the elements around it, with position and velocity interpolated there;
    /// `None` where it lies in none of them.
    pub(super) fn moved(&self, node: NodeId, rest: &Vector<D>) -> Option<Operation<D>> {
        Some(self.move_of(node, self.interpolated(node, rest)?))
    }

    fn move_of(&self, node: NodeId, state: EditedNode<D>) -> Operation<D> {
        let old = self.around(node).to_vec();
        let new = old.iter().map(|element| self.elements[element.index()]).collect();
        Operation { kind: OperationKind::Move, old, new, node: Some((node, state)), parents: [node; 2] }
    }

    /// Fields at a rest position in the elements around a node.
    fn interpolated(&self, node: NodeId, rest: &Vector<D>) -> Option<EditedNode<D>> {
        /// Least weight of a point that counts as inside, for rounding. Assumed, not measured.
        const OUTSIDE: f64 = -1e-9;
        let weights = |element: &ElementId| {
            let corners: Vec<Vector<D>> = self.corners(*element).iter().map(|n| self.nodes[n.index()].rest).collect();
            let weights = DeformedElement::of(&corners, &CORNERS).weights(rest);
            let least = weights[..=D].iter().copied().fold(f64::INFINITY, f64::min);
            (least, *element, weights)
        };
        let all = self.around(node).iter().map(weights);
        let (least, element, weights) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        if least.is_nan() || least < OUTSIDE {
            return None;
        }
        let mix = |of: &dyn Fn(&EditedNode<D>) -> Vector<D>| {
            let terms = self.corners(element).iter().zip(weights);
            terms.map(|(node, weight)| of(&self.nodes[node.index()]) * weight).sum()
        };
        // Of a point a little below the surface, the nodes of the surface tell where it is.
        let is_parent = |(node, weight): &(&NodeId, f64)| *weight > -OUTSIDE && self.is_boundary(**node);
        let parents = self.corners(element).iter().zip(weights).filter(is_parent);
        let parents: Vec<_> = parents.map(|(node, weight)| (self.nodes[node.index()].origin, weight)).collect();
        let (position, velocity) = (mix(&|n| n.position), mix(&|n| n.velocity));
        Some(EditedNode { rest: *rest, position, velocity, origin: mixed_origin::<D>(&parents) })
    }
}
