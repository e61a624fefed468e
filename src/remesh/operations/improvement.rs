//! Improvement of a mesh: which elements are remade, and by which operation.
//!
//! An element is remade when it hinders: when its own frequency exceeds a limit and so sets the step, or when it is
//! compressed beyond one. Of the operations around it the one is performed that lowers the hindrance of its cavity
//! most, at the least change of stored energy. Edges that have grown long are split (`refinement`), and those of a gel
//! that flows collapsed where they have become short (`coarsening`). Shape alone asks for nothing: a stretched skin has
//! a good rest shape and a good step, and remaking it would cost energy.
//!
//! Evidence: many thresholds of the operations are those of a *prototype*, a separate program with triangles about an
//! axis and one global step. It shot the ball of `sphere-deep` in some eighty runs at 13 to 30 m/s on three meshes. Its
//! figures are cited by that name; most of its values were never varied one by one.

use super::edge_rules::EdgeRules;
use super::edit_scene::EditScene;
use super::editable_mesh::{EditableMesh, ReferenceConfiguration};
use super::element_model::ElementModel;
use super::nodal_sizes::NodalSizes;
use super::operation::{EditedNode, Operation, OperationKind};
use super::trial::Trial;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId, Simplex};
use crate::remesh::NodeOrigin;

/// Limits of the operations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EditLimits {
    /// Energy to which changes of stored energy are compared, J.
    pub energy: f64,
    /// Edge of the first mesh where it is finest, m.
    pub usual: f64,
    /// Least target edge, m.
    pub least: f64,
}

/// Operations performed, and what they leave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EditCounts {
    /// Splits, collapses, flips and moves.
    pub operations: [usize; 4],
    /// Elements above the limit for which no operation was found.
    pub stuck: usize,
    /// Greatest hindrance that is left.
    pub hindrance: f64,
}

impl EditCounts {
    /// Operations of all kinds.
    #[must_use]
    pub fn total(&self) -> usize {
        self.operations.iter().sum()
    }
}

/// Rounds over the elements above the limit, and over the long edges. The prototype's value; assumed, not measured.
pub(super) const ROUNDS: usize = 3;
/// Factor by which an operation must lower the hindrance of the element for which it is performed. The prototype's
/// value; assumed, not measured.
const GAIN: f64 = 0.93;
/// Weight of the change of energy, relative to the reference, against the logarithm of the hindrance. The prototype's
/// value; assumed, not measured.
const ENERGY_WEIGHT: f64 = 300.0;
/// Greatest gain of stored energy, relative to the reference, by an operation for an element of hindrance 1, which
/// grows with the square of the hindrance, and the greatest of any operation. It is bounded more tightly than a loss: a
/// gain is returned by slowing the motion around, where there may be none. With the bounds of losses remeshing added
/// 1.6 % to the ball of `sphere-deep` at 20 m/s on 1.25 mm (−0.03 % with these), and 5 to 240 % to 23 of 500 random
/// scenes.
const MAX_GAIN: [f64; 2] = [3e-4, 3e-3];
/// Greatest loss of stored energy, likewise. Random operations without a bound added 13 to 108 % of energy in the
/// prototype, at 5 m/s. The first value is the prototype's, the second is assumed; neither was varied.
const MAX_LOSS: [f64; 2] = [3e-3, 0.02];
/// Depth of the middle of a surface edge in a body, in usual lengths, above which no operation makes it. A third of the
/// prototype's runs at 20 m/s died without this limit, none with it.
const MAX_DEPTH: f64 = 0.12;
/// Parts of the way of a node to the centroid of its neighbours, at rest. The prototype's values; assumed, not
/// measured.
const WAYS_TO_CENTROID: [f64; 3] = [0.25, 0.5, 1.0];
/// Parts of the way of a node to each of its neighbours, at rest. The prototype's values; assumed, not measured.
const WAYS_TO_NEIGHBOUR: [f64; 2] = [0.12, 0.3];

/// Remakes the elements above the limit, `bad` of the mesh as it is, and splits long edges.
pub fn improve<const D: usize>(
    mesh: &mut EditableMesh<'_, D>,
    model: &impl ElementModel<D>,
    scene: &EditScene<'_, D>,
    limits: &EditLimits,
    bad: Vec<ElementId>,
) -> EditCounts {
    let n_first = mesh.n_elements();
    let rules = EdgeRules::of(mesh.configuration);
    let sizes = NodalSizes::new(scene, mesh.nodes.len());
    let mut improver = Improver { mesh, model, scene, limits, rules, sizes, counts: EditCounts::default() };
    improver.split_long_edges();
    let (mut bad, mut seen) = (bad, n_first);
    for _ in 0..ROUNDS {
        // Elements that were made since belong to the next round.
        let made = seen..improver.mesh.n_elements();
        seen = made.end;
        bad.extend(made.map(|element| ElementId(element as u32)));
        bad = improver.above_limit(bad);
        if !improver.remake_all(&bad) {
            break;
        }
    }
    improver.coarsen();
    bad.extend((seen..improver.mesh.n_elements()).map(|element| ElementId(element as u32)));
    let left = improver.above_limit(bad);
    improver.counts.hindrance = left.first().map_or(1.0, |worst| improver.mesh.state(*worst, improver.model).hindrance);
    improver.counts
}

/// Improvement in progress.
pub(super) struct Improver<'a, 'm, 's, const D: usize, M> {
    pub(super) mesh: &'a mut EditableMesh<'m, D>,
    pub(super) model: &'a M,
    pub(super) scene: &'a EditScene<'s, D>,
    pub(super) limits: &'a EditLimits,
    pub(super) rules: EdgeRules,
    pub(super) sizes: NodalSizes<'a, 's, D>,
    counts: EditCounts,
}

/// Operation that has been tried.
pub(super) struct Replacement<const D: usize> {
    pub(super) operation: Operation<D>,
    pub(super) trial: Trial,
}

impl<const D: usize, M: ElementModel<D>> Improver<'_, '_, '_, D, M> {
    /// Selects the elements that are there and above the limit, the worst first.
    fn above_limit(&self, elements: Vec<ElementId>) -> Vec<ElementId> {
        let mut bad: Vec<(f64, ElementId)> = vec![];
        for element in elements {
            if !self.mesh.has(element) {
                continue;
            }
            let hindrance = self.mesh.state(element, self.model).hindrance;
            if hindrance > 1.0 && self.mesh.is_compatible(element) {
                bad.push((hindrance, element));
            }
        }
        bad.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        bad.into_iter().map(|(_, element)| element).collect()
    }

    /// Remakes each of these elements; returns true if any was remade.
    fn remake_all(&mut self, bad: &[ElementId]) -> bool {
        let mut any = false;
        self.counts.stuck = 0;
        for element in bad {
            if !self.mesh.has(*element) {
                continue;
            }
            let best = self.best_operation(*element);
            any |= best.is_some();
            self.counts.stuck += usize::from(best.is_none());
            self.perform(best);
        }
        any
    }

    /// Finds the best operation around an element; `None` if there is none.
    fn best_operation(&self, element: ElementId) -> Option<Replacement<D>> {
        let hindrance = self.mesh.state(element, self.model).hindrance;
        let mut best = None;
        let nodes = self.mesh.elements[element.index()];
        for corner in 0..=D {
            let flip = self.mesh.flip(element, corner);
            self.consider(flip, hindrance, &mut best);
        }
        for (a, b) in edges_of::<D>().map(|(i, j)| (nodes[i], nodes[j])) {
            for (a, b, part) in [(a, b, 0.0), (b, a, 0.0), (a, b, 0.5)] {
                let collapse = self.mesh.collapse(a, b, part);
                self.consider(collapse, hindrance, &mut best);
            }
            if D == 3 {
                for to in self.ring(a, b) {
                    let removal = self.mesh.remove_edge(a, b, to);
                    self.consider(Some(removal), hindrance, &mut best);
                }
            }
        }
        for node in &nodes[..=D] {
            let moves = if best.is_none() || self.rules.moves_freely { self.moves(*node) } else { vec![] };
            for moved in moves {
                self.consider(Some(moved), hindrance, &mut best);
            }
        }
        best.map(|(_, replacement)| replacement)
    }

    /// Nodes around an edge.
    fn ring(&self, a: NodeId, b: NodeId) -> Vec<NodeId> {
        let around = self.mesh.around_edge(a, b);
        let nodes = around.iter().flat_map(|element| self.mesh.corners(*element)).copied();
        let mut ring: Vec<NodeId> = nodes.filter(|node| *node != a && *node != b).collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// Moves of a node.
    fn moves(&self, node: NodeId) -> Vec<Operation<D>> {
        let here = self.mesh.nodes[node.index()].rest;
        let mut neighbours = self.mesh.neighbours(node);
        // A node of the surface stays in it, and a support keeps its ends.
        if self.mesh.is_boundary(node) {
            let held = |node: NodeId| self.mesh.held[node.index()];
            let is_as_held = |other: NodeId| (0..D).all(|axis| held(other)[axis] || !held(node)[axis]);
            neighbours.retain(|other| is_as_held(*other) && self.mesh.is_boundary_edge(node, *other));
        }
        if neighbours.is_empty() {
            return vec![];
        }
        let rest = |other: &NodeId| self.mesh.nodes[other.index()].rest;
        let centroid = neighbours.iter().map(rest).sum::<Vector<D>>() / neighbours.len() as f64;
        let inwards =
            WAYS_TO_CENTROID.iter().filter_map(|way| self.mesh.moved(node, &(here + (centroid - here) * *way)));
        let along = |other: &NodeId| WAYS_TO_NEIGHBOUR.map(|way| self.mesh.moved_towards(node, *other, way));
        inwards.chain(neighbours.iter().flat_map(along)).collect()
    }

    /// Tries an operation for an element of this hindrance; `best` is the one of the least score so far, and its score.
    fn consider(&self, operation: Option<Operation<D>>, hindrance: f64, best: &mut Option<(f64, Replacement<D>)>) {
        let Some(mut operation) = operation else { return };
        self.clear(&mut operation);
        if self.lacks_surface_origin(&operation) {
            return;
        }
        // A change of energy only adds to the score; every cavity of an inverted element has infinite hindrance.
        let least = best.as_ref().map_or(f64::INFINITY, |(least, _)| least.exp());
        let scale = |before: f64| if before.is_finite() { before } else { 1.0 };
        let limit = |before: f64| (GAIN * hindrance).min(least * scale(before));
        let Some(trial) = self.mesh.attempt(&operation, self.model, limit) else { return };
        if self.is_in_body(&operation) || self.is_stretched(&operation) {
            return;
        }
        let Some(gained) = self.change_of_energy(&operation, &trial) else { return };
        let energy = gained.abs() / self.limits.energy;
        let [before, after] = trial.hindrance;
        let score = (after / scale(before)).ln() + ENERGY_WEIGHT * energy;
        let [usual, most] = if gained > 0.0 { MAX_GAIN } else { MAX_LOSS };
        if energy <= most.min(usual * hindrance * hindrance) && best.as_ref().is_none_or(|(least, _)| score < *least) {
            *best = Some((score, Replacement { operation, trial }));
        }
    }

    /// Change of stored energy by an operation, J, which is 0 of a gel that flows; `None` if it is infinite, or a patch
    /// of the cavity has an element with a rest shape of its own.
    pub(super) fn change_of_energy(&self, operation: &Operation<D>, trial: &Trial) -> Option<f64> {
        match self.mesh.configuration {
            ReferenceConfiguration::Present => Some(0.0),
            ReferenceConfiguration::Rest => Some(self.mesh.regroup(operation, &trial.states, self.model)?.energy),
        }
    }

    /// Returns true if the node that an operation makes or moves is of the surface.
    fn is_of_surface(&self, operation: &Operation<D>) -> bool {
        let [a, b] = operation.parents;
        match operation.kind {
            OperationKind::Split => self.mesh.is_boundary_edge(a, b),
            OperationKind::Collapse | OperationKind::Move => self.mesh.is_boundary(b),
            OperationKind::Flip => false,
        }
    }

    /// Moves the node of an operation out of the bodies if it is of the surface.
    pub(super) fn clear(&self, operation: &mut Operation<D>) {
        self.clear_partly(operation, 1.0);
    }

    /// Moves the node of an operation a part of the way out of the bodies if it is of the surface.
    pub(super) fn clear_partly(&self, operation: &mut Operation<D>, part: f64) {
        let is_surface = self.is_of_surface(operation);
        if let Some((_, state)) = operation.node.as_mut().filter(|_| is_surface) {
            let cleared = (self.scene.cleared)(&state.position);
            state.position = if part == 1.0 { cleared } else { state.position + (cleared - state.position) * part };
            if self.mesh.configuration == ReferenceConfiguration::Present {
                state.rest = state.position;
            }
        }
    }

    /// Returns true if an operation makes a surface node whose place on the old surface is unknown: the transfer of the
    /// fields of a gel that flows needs it.
    pub(super) fn lacks_surface_origin(&self, operation: &Operation<D>) -> bool {
        let is_inside = |(_, state): &(NodeId, EditedNode<D>)| state.origin == NodeOrigin::Inside;
        self.mesh.configuration == ReferenceConfiguration::Present
            && operation.node.as_ref().is_some_and(is_inside)
            && self.is_of_surface(operation)
    }

    /// Returns true if an operation makes a surface edge whose middle is deep in a body, and deeper than one before.
    pub(super) fn is_in_body(&self, operation: &Operation<D>) -> bool {
        if operation.kind == OperationKind::Split {
            return false;
        }
        let limit = MAX_DEPTH * self.limits.usual;
        let depth = self.surface_depth(&operation.new, limit, &|node| self.mesh.after(operation, node).position);
        let old = || operation.old.iter().map(|element| self.mesh.elements[element.index()]).collect::<Vec<_>>();
        depth > limit && depth > self.surface_depth(&old(), limit, &|node| self.mesh.place(node))
    }

    /// Greatest depth in a body of the middles of surface edges of these elements, if above a limit, m; otherwise 0.
    fn surface_depth(&self, elements: &[Simplex], limit: f64, at: &dyn Fn(NodeId) -> Vector<D>) -> f64 {
        let edges = elements.iter().flat_map(|nodes| edges_of::<D>().map(|(i, j)| (nodes[i], nodes[j])));
        let of_surface = edges.filter(|(a, b)| self.mesh.is_boundary(*a) && self.mesh.is_boundary(*b));
        let depths = of_surface.map(|(a, b)| -(self.scene.gap)(&((at(a) + at(b)) * 0.5)));
        depths.filter(|depth| *depth > limit).fold(0.0, f64::max)
    }

    /// Performs an operation that has been tried, if any.
    pub(super) fn perform(&mut self, replacement: Option<Replacement<D>>) {
        let Some(Replacement { operation, trial }) = replacement else { return };
        let Some(patches) = self.mesh.regroup(&operation, &trial.states, self.model) else { return };
        self.mesh.commit(&operation, &trial.states, &patches);
        if let Some((node, _)) = operation.node {
            self.sizes.forget(node);
        }
        self.counts.operations[operation.kind as usize] += 1;
    }
}

/// Pairs of corners of a simplex.
pub(super) fn edges_of<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..=D).flat_map(|j| (0..j).map(move |i| (i, j)))
}
