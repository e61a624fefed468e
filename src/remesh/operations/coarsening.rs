//! Coarsening: collapses of edges of elements that are far smaller than the target lengths.

use super::element_model::ElementModel;
use super::improvement::{Improver, Replacement, edges_of};
use super::operation::Operation;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId, Simplex};

/// Length of an edge, relative to the longest one before, above which it is much longer. Assumed, not measured.
const MUCH_LONGER: f64 = 1.25;
/// Number of the shortest edges of an element that are tried, each in three collapses. Assumed, not measured.
const TRIED_EDGES: usize = 2;

impl<const D: usize, M: ElementModel<D>> Improver<'_, '_, '_, D, M> {
    /// Collapses an edge of each element that is too small, the smallest first.
    pub(super) fn coarsen(&mut self) {
        for element in self.small_elements() {
            if self.mesh.has(element) {
                self.perform(self.best_collapse(element));
            }
        }
    }

    /// Finds the collapse of a short edge of an element that leaves the least hindrance; `None` if none is accepted.
    fn best_collapse(&self, element: ElementId) -> Option<Replacement<D>> {
        let mut best: Option<Replacement<D>> = None;
        for (a, b) in self.short_edges(element) {
            for (a, b, part) in [(a, b, 0.0), (b, a, 0.0), (a, b, 0.5)] {
                let least = best.as_ref().map_or(1.0, |best| best.trial.hindrance[1]);
                best = self.collapse_below(least, a, b, part).or(best);
            }
        }
        best
    }

    /// Shortest edges of an element.
    fn short_edges(&self, element: ElementId) -> Vec<(NodeId, NodeId)> {
        let nodes = self.mesh.elements[element.index()];
        let mut edges: Vec<(NodeId, NodeId)> = edges_of::<D>().map(|(i, j)| (nodes[i], nodes[j])).collect();
        let place = |node: NodeId| self.mesh.place(node);
        edges.sort_by(|a, b| (place(a.0) - place(a.1)).norm().total_cmp(&(place(b.0) - place(b.1)).norm()));
        edges.truncate(TRIED_EDGES);
        edges
    }

    /// Elements that are too small, the smallest first; none without a body, whose distance tells how fine the mesh
    /// must be.
    fn small_elements(&self) -> Vec<ElementId> {
        let has_bodies = (self.scene.gap)(&Vector::<D>::zeros()) < f64::INFINITY;
        if self.rules.short <= 0.0 || !has_bodies {
            return vec![];
        }
        let here = |node: NodeId| self.mesh.place(node);
        let longest_if_small = |element: ElementId| {
            let nodes = self.mesh.elements[element.index()];
            let may_be_short = |(i, j)| self.sizes.relative_length(self.mesh, nodes[i], nodes[j])[0] < self.rules.short;
            let longer = |longest: f64, (i, j)| {
                let length = self.relative_length([nodes[i], nodes[j]].map(here));
                (length < self.rules.short).then(|| longest.max(length))
            };
            edges_of::<D>().all(may_be_short).then(|| edges_of::<D>().try_fold(0.0, longer)).flatten()
        };
        let all = self.mesh.present().filter(|element| self.mesh.is_compatible(*element));
        let mut small: Vec<(f64, ElementId)> =
            all.filter_map(|element| Some((longest_if_small(element)?, element))).collect();
        small.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        small.into_iter().map(|(_, element)| element).collect()
    }

    /// Tries a collapse; `None` unless it is legal, makes no long edge, and leaves a hindrance below a limit.
    fn collapse_below(&self, limit: f64, a: NodeId, b: NodeId, part: f64) -> Option<Replacement<D>> {
        let mut operation = self.mesh.collapse(a, b, part)?;
        self.clear(&mut operation);
        if self.lacks_surface_origin(&operation) {
            return None;
        }
        let trial = self.mesh.attempt(&operation, self.model, |_| limit)?;
        if trial.hindrance[1] >= limit || self.is_stretched(&operation) || self.is_in_body(&operation) {
            return None;
        }
        self.change_of_energy(&operation, &trial)?;
        Some(Replacement { operation, trial })
    }

    /// Returns true if an operation makes an edge that is too long, and much longer than one before: a little longer
    /// are those that the collapse of a very short edge makes.
    pub(super) fn is_stretched(&self, operation: &Operation<D>) -> bool {
        if self.rules.longest == f64::INFINITY {
            return false;
        }
        let at = |node: NodeId| self.mesh.after(operation, node).position;
        let is_made = |node: NodeId| operation.node.as_ref().is_some_and(|(made, _)| *made == node);
        // Most edges are clearly short; no two ends are new.
        let may_be_long = |(a, b): &(NodeId, NodeId)| {
            let (a, b) = if is_made(*a) { (*b, *a) } else { (*a, *b) };
            self.sizes.greatest_length(self.mesh, a, &at(b)) > self.rules.longest
        };
        let new = operation.new.iter().flat_map(|nodes| edges_of::<D>().map(|(i, j)| (nodes[i], nodes[j])));
        let lengths = new.filter(may_be_long).map(|(a, b)| self.relative_length([at(a), at(b)]));
        let longest = lengths.fold(0.0, f64::max);
        let old: Vec<Simplex> = operation.old.iter().map(|element| self.mesh.elements[element.index()]).collect();
        let before = || self.longest_edge(&old, &|node| self.mesh.place(node));
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
