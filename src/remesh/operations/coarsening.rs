//! Coarsening: collapses of edges of elements that are far smaller than the target lengths.

use super::element_model::ElementModel;
use super::improvement::{Improver, Replacement, edges_of};
use super::nodal_sizes::NodalSizes;
use super::operation::Operation;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId, Simplex};

/// Length of an edge, relative to the longest one before, above which it is much longer.
const MUCH_LONGER: f64 = 1.25;
/// Edges of an element that are tried, the shortest.
const TRIED_EDGES: usize = 2;

impl<const D: usize, M: ElementModel<D>> Improver<'_, '_, '_, D, M> {
    /// Collapses an edge of each element that is too small, the smallest first.
    pub(super) fn coarsen(&mut self) {
        for element in self.small_elements() {
            if !self.mesh.has(element) {
                continue;
            }
            let mut best: Option<Replacement<D>> = None;
            for (a, b) in self.short_edges(element) {
                for (a, b, part) in [(a, b, 0.0), (b, a, 0.0), (a, b, 0.5)] {
                    let least = best.as_ref().map_or(1.0, |best| best.trial.hindrance[1]);
                    best = self.collapse_below(least, a, b, part).or(best);
                }
            }
            if let Some(replacement) = best {
                self.perform(&replacement);
            }
        }
    }

    /// Shortest edges of an element.
    fn short_edges(&self, element: ElementId) -> Vec<(NodeId, NodeId)> {
        let nodes = self.mesh.elements[element.index()];
        let mut edges: Vec<(NodeId, NodeId)> = edges_of::<D>().map(|(i, j)| (nodes[i], nodes[j])).collect();
        let place = |node: NodeId| self.mesh.nodes[node.index()].position;
        edges.sort_by(|a, b| (place(a.0) - place(a.1)).norm().total_cmp(&(place(b.0) - place(b.1)).norm()));
        edges.truncate(TRIED_EDGES);
        edges
    }

    /// Elements that are too small, the smallest first; none without a body, whose distance tells how fine the mesh must be.
    fn small_elements(&self) -> Vec<ElementId> {
        let has_bodies = (self.scene.gap)(&Vector::<D>::zeros()) < f64::INFINITY;
        if self.rules.short <= 0.0 || !has_bodies {
            return vec![];
        }
        let here = |node: NodeId| self.mesh.nodes[node.index()].position;
        let (mut sizes, mut small) = (NodalSizes::new(self.mesh, self.scene), vec![]);
        for element in self.mesh.present().filter(|element| self.mesh.is_compatible(*element)) {
            let nodes = self.mesh.elements[element.index()];
            let may_be_short = |(i, j)| sizes.relative_length(nodes[i], nodes[j])[0] < self.rules.short;
            let is_short = |(i, j)| self.relative_length([nodes[i], nodes[j]].map(here)) < self.rules.short;
            if edges_of::<D>().all(may_be_short) && edges_of::<D>().all(is_short) {
                small.push((self.longest_edge(&[nodes], &here), element));
            }
        }
        small.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        small.into_iter().map(|(_, element)| element).collect()
    }

    /// Tries a collapse; `None` unless it is legal, makes no long edge, and leaves a hindrance below a limit.
    fn collapse_below(&mut self, limit: f64, a: NodeId, b: NodeId, part: f64) -> Option<Replacement<D>> {
        let mut operation = self.mesh.collapse(a, b, part)?;
        self.clear(&mut operation);
        if self.is_lost(&operation) {
            return None;
        }
        let trial = self.mesh.attempt(&operation, self.model, |_| limit)?;
        if trial.hindrance[1] >= limit || self.is_stretched(&operation) || self.is_in_body(&operation) {
            return None;
        }
        let regrouping = self.mesh.regroup(&operation, &trial.states, self.model)?;
        Some(Replacement { operation, trial, regrouping })
    }

    /// Returns true if an operation makes an edge that is too long, and much longer than one before: a little longer are those
    /// that the collapse of a very short edge makes.
    pub(super) fn is_stretched(&self, operation: &Operation<D>) -> bool {
        if self.rules.longest == f64::INFINITY {
            return false;
        }
        let longest = self.longest_edge(&operation.new, &|node| self.mesh.after(operation, node).position);
        let old: Vec<Simplex> = operation.old.iter().map(|element| self.mesh.elements[element.index()]).collect();
        let before = || self.longest_edge(&old, &|node| self.mesh.nodes[node.index()].position);
        longest > self.rules.longest && longest > MUCH_LONGER * before()
    }

    /// Longest edge of these elements, in target lengths.
    fn longest_edge(&self, elements: &[Simplex], at: &dyn Fn(NodeId) -> Vector<D>) -> f64 {
        let edges = elements.iter().flat_map(|nodes| edges_of::<D>().map(|(i, j)| [at(nodes[i]), at(nodes[j])]));
        edges.map(|ends| self.relative_length(ends)).fold(0.0, f64::max)
    }

    /// Length of an edge between two points, in target lengths.
    fn relative_length(&self, [a, b]: [Vector<D>; 2]) -> f64 {
        (a - b).norm() / (self.scene.size)(&((a + b) * 0.5))
    }
}
