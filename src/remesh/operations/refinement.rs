//! Refinement: splits of edges that have grown long.

use super::edge_rules::EdgeRules;
use super::element_model::ElementModel;
use super::improvement::{Improver, ROUNDS, Replacement, edges_of};
use super::operation::Operation;
use crate::mesh::{ElementId, NodeId};

/// Least half edge at rest of a split, in least target lengths. In the prototype splits without this limit and that of
/// the rest quality made needles at the pole; the value is assumed, not measured.
const LEAST_REST_EDGE: f64 = 0.2;
/// Parts of the way out of a body that the middle of a split surface edge is pushed; the first that is accepted is
/// taken. Assumed, not measured.
const WAYS_OUT: [f64; 4] = [1.0, 0.7, 0.4, 0.0];
/// Greatest change of energy of a split, relative to the reference. A split by itself stores none (test
/// `a_split_stores_no_energy`); patches that are grouped anew may. The prototype's value; assumed, not measured.
const MAX_SPLIT_ENERGY: f64 = 1e-4;

impl<const D: usize, M: ElementModel<D>> Improver<'_, '_, '_, D, M> {
    /// Splits the edges that have grown long, the longest first.
    pub(super) fn split_long_edges(&mut self) {
        let mut seen = 0;
        for _ in 0..ROUNDS {
            let from = std::mem::replace(&mut seen, self.mesh.n_elements());
            for (_, a, b) in self.long_edges(from) {
                if !self.mesh.around_edge(a, b).is_empty() {
                    self.perform(self.split_of(a, b));
                }
            }
        }
    }

    /// Edges of the elements from a number on that are too long, with the negative of their length in
    /// target lengths, the longest first.
    fn long_edges(&self, from: usize) -> Vec<(f64, NodeId, NodeId)> {
        let all = (from..self.mesh.n_elements()).map(|element| ElementId(element as u32));
        let all = all.filter(|element| self.mesh.has(*element) && self.mesh.is_compatible(*element));
        let mut long: Vec<_> = all.flat_map(|element| self.long_edges_of(element)).collect();
        long.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        long.dedup_by(|a, b| (a.1, a.2) == (b.1, b.2));
        long
    }

    /// Edges of an element that are too long, with the negative of their length in target lengths.
    fn long_edges_of(&self, element: ElementId) -> Vec<(f64, NodeId, NodeId)> {
        let at = |node: NodeId| self.mesh.place(node);
        let nodes = &self.mesh.elements[element.index()];
        let edges = edges_of::<D>().map(|(i, j)| (nodes[i].min(nodes[j]), nodes[i].max(nodes[j])));
        let long = edges.filter_map(|(a, b)| {
            let length = (at(a) - at(b)).norm();
            let is_short = length <= self.rules.long * self.limits.least;
            if is_short || self.sizes.relative_length(self.mesh, a, b)[1] <= self.rules.long {
                return None;
            }
            let middle = (at(a) + at(b)) * 0.5;
            let ratio = length / (self.scene.size)(&middle);
            let is_long = ratio > self.rules.long && (self.scene.gap)(&middle) <= self.rules.near * self.limits.usual;
            is_long.then_some((-ratio, a, b))
        });
        long.collect()
    }

    /// Finds the split of an edge; `None` if none is accepted. The middle of a surface edge is pushed out of bodies, or
    /// part of the way where the elements beneath are too flat.
    fn split_of(&self, a: NodeId, b: NodeId) -> Option<Replacement<D>> {
        let rest = |node: NodeId| self.mesh.nodes[node.index()].rest;
        if 0.5 * (rest(a) - rest(b)).norm() < LEAST_REST_EDGE * self.limits.least {
            return None;
        }
        let operation = self.mesh.split(a, b);
        if self.lacks_surface_origin(&operation) {
            return None;
        }
        let is_surface = self.mesh.is_boundary_edge(a, b);
        let ways = if is_surface && self.rules.keeps_chords { &WAYS_OUT[..] } else { &WAYS_OUT[..1] };
        ways.iter().find_map(|way| {
            let mut operation = operation.clone();
            self.clear_partly(&mut operation, *way);
            self.accepted_split(operation, is_surface)
        })
    }

    /// Tries a split; `None` if it is not accepted.
    fn accepted_split(&self, operation: Operation<D>, is_surface: bool) -> Option<Replacement<D>> {
        let EdgeRules { split_hindrance, surface_rise, .. } = self.rules;
        let of_surface = |before: f64| split_hindrance.max(1.0).max(surface_rise * before);
        let limit = |before: f64| if is_surface { of_surface(before) } else { split_hindrance };
        let trial = self.mesh.attempt(&operation, self.model, limit)?;
        let energy = self.change_of_energy(&operation, &trial)?;
        let is_kept = energy.abs() <= MAX_SPLIT_ENERGY * self.limits.energy;
        is_kept.then_some(Replacement { operation, trial })
    }
}
