//! Target lengths at the nodes, which bound those at the middles of edges: a target length costs a distance from a body,
//! and most edges are neither long nor short.

use super::editable_mesh::EditableMesh;
use super::improvement::EditScene;
use crate::math::Vector;
use crate::mesh::NodeId;

/// Factor that covers roundings of distances.
const SLACK: f64 = 1.001;

/// Target lengths at the nodes of a mesh as it is, each found when it is first asked for.
pub(super) struct NodalSizes<'a, 'm, const D: usize> {
    mesh: &'a EditableMesh<'m, D>,
    scene: &'a EditScene<'a, D>,
    /// Target length at each node, m; `None` before it was asked for.
    known: Vec<Option<f64>>,
}

impl<'a, 'm, const D: usize> NodalSizes<'a, 'm, D> {
    /// Prepares the target lengths of a mesh, none known yet.
    pub fn new(mesh: &'a EditableMesh<'m, D>, scene: &'a EditScene<'a, D>) -> Self {
        Self { mesh, scene, known: vec![None; mesh.nodes.len()] }
    }

    /// Returns the least and greatest length that an edge can have in target lengths: the target length changes by no more
    /// than [`EditScene::growth`] times the half edge from each end to the middle.
    pub fn relative_length(&mut self, a: NodeId, b: NodeId) -> [f64; 2] {
        let length = (self.place(a) - self.place(b)).norm();
        let (at_a, at_b, change) = (self.at(a), self.at(b), SLACK * self.scene.growth * 0.5 * length);
        let [least, greatest] = [at_a.max(at_b) - change, at_a.min(at_b) + change];
        [length / greatest, if least > 0.0 { length / least } else { f64::INFINITY }]
    }

    /// Returns the target length at a node, m.
    fn at(&mut self, node: NodeId) -> f64 {
        let place = self.place(node);
        *self.known[node.index()].get_or_insert_with(|| (self.scene.size)(&place))
    }

    fn place(&self, node: NodeId) -> Vector<D> {
        self.mesh.nodes[node.index()].position
    }
}
