//! Target lengths at the nodes, which bound those at the middles of edges: a target length costs a distance from a
//! body, and most edges are neither long nor short.

use super::edit_scene::EditScene;
use super::editable_mesh::EditableMesh;
use crate::math::Vector;
use crate::mesh::NodeId;
use std::cell::OnceCell;

/// Factor that covers roundings of distances. Assumed, not measured; with it the test
/// `nodal_sizes_bound_the_relative_length_of_each_edge` holds for every edge.
const SLACK: f64 = 1.001;

/// Target lengths at the nodes, each found when it is first asked for.
pub(super) struct NodalSizes<'a, 's, const D: usize> {
    scene: &'a EditScene<'s, D>,
    /// Target length at each node, m.
    known: Vec<OnceCell<f64>>,
}

impl<'a, 's, const D: usize> NodalSizes<'a, 's, D> {
    /// Target lengths at this many nodes, none known yet.
    pub fn new(scene: &'a EditScene<'s, D>, n_nodes: usize) -> Self {
        Self { scene, known: vec![OnceCell::new(); n_nodes] }
    }

    /// Forgets the target length at a node that has moved or is new.
    pub fn forget(&mut self, node: NodeId) {
        self.known.resize(self.known.len().max(node.index() + 1), OnceCell::new());
        self.known[node.index()] = OnceCell::new();
    }

    /// Returns the least and greatest length that an edge can have in target lengths: the target length changes by no
    /// more than [`EditScene::growth`] times the half edge from each end to the middle.
    pub fn relative_length(&self, mesh: &EditableMesh<'_, D>, a: NodeId, b: NodeId) -> [f64; 2] {
        let length = (mesh.place(a) - mesh.place(b)).norm();
        let (at_a, at_b, change) = (self.at(mesh, a), self.at(mesh, b), self.change(length));
        [length / (at_a.min(at_b) + change), greatest(length, at_a.max(at_b) - change)]
    }

    /// Returns the greatest length, in target lengths, that an edge from a node to this point can have.
    pub fn greatest_length(&self, mesh: &EditableMesh<'_, D>, node: NodeId, to: &Vector<D>) -> f64 {
        let length = (mesh.place(node) - to).norm();
        greatest(length, self.at(mesh, node) - self.change(length))
    }

    /// Greatest change of the target length from an end of an edge of this length, m, to its middle, m.
    fn change(&self, length: f64) -> f64 {
        SLACK * self.scene.growth * 0.5 * length
    }

    /// Target length at a node, m.
    fn at(&self, mesh: &EditableMesh<'_, D>, node: NodeId) -> f64 {
        *self.known[node.index()].get_or_init(|| (self.scene.size)(&mesh.place(node)))
    }
}

/// Length in target lengths of at least this, m.
fn greatest(length: f64, least: f64) -> f64 {
    if least > 0.0 { length / least } else { f64::INFINITY }
}
