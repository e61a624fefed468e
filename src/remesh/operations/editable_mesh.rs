//! Mesh whose elements are replaced one cavity at a time.

use super::operation::Operation;
use super::trial::{ElementModel, ElementState};
use super::velocity::keep_motion;
use crate::math::Vector;
use crate::mesh::{ElementId, Mesh, NodeId, NodeIncidence, Simplex};
use crate::remesh::nodal_fields::corner_masses;
use crate::remesh::{BodySymmetry, MeshCorrespondence, UnchangedElement};
use std::collections::BTreeMap;

/// Rest position, position and velocity of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeState<const D: usize> {
    pub rest: Vector<D>,
    pub position: Vector<D>,
    pub velocity: Vector<D>,
}

/// Nodes and elements of a deformed gel, with the elements around each node.
///
/// Nodes and elements that are made are appended; those that are given up keep their number until [`Self::finish`].
#[derive(Debug, Clone)]
pub struct EditableMesh<'a, const D: usize> {
    pub(super) nodes: Vec<NodeState<D>>,
    /// Masses of the nodes, kg.
    pub(super) mass: Vec<f64>,
    pub(super) held: Vec<[bool; D]>,
    /// Elements, also those that were replaced.
    pub(super) elements: Vec<Simplex>,
    /// Masses of the corners of the elements, kg.
    corner_mass: Vec<[f64; 4]>,
    /// Time steps with which the elements were integrated, s.
    step: Vec<f64>,
    /// True for elements of the present mesh.
    is_there: Vec<bool>,
    /// True for elements whose rest shape is that of their nodes; no operation touches the others.
    is_compatible: Vec<bool>,
    /// Elements around each node of the first mesh.
    incidence: &'a NodeIncidence,
    /// Elements around the nodes of cavities, ascending.
    star: BTreeMap<NodeId, Vec<ElementId>>,
    /// State of each element, where it has been asked for.
    states: Vec<Option<ElementState>>,
    /// Elements of the first mesh.
    n_first: usize,
    pub(super) symmetry: BodySymmetry,
}

/// Mesh after its operations, numbered anew: kept nodes and elements first, in their old order.
#[derive(Debug, Clone, PartialEq)]
pub struct EditedMesh<const D: usize> {
    /// Rest positions, m.
    pub rest: Vec<Vector<D>>,
    /// Positions, m.
    pub position: Vec<Vector<D>>,
    /// Velocities, m/s.
    pub velocity: Vec<Vector<D>>,
    /// Held directions.
    pub held: Vec<[bool; D]>,
    /// Masses of the nodes, kg.
    pub mass: Vec<f64>,
    /// Elements.
    pub elements: Vec<Simplex>,
    /// Masses of the corners of the elements, kg.
    pub corner_mass: Vec<[f64; 4]>,
    /// Time steps of the elements, or of those that they replace, s.
    pub step: Vec<f64>,
}

impl<'a, const D: usize> EditableMesh<'a, D> {
    /// Mesh with the positions, m, and velocities, m/s, of its nodes; elements with a rest shape of their own are not
    /// `is_compatible`. `step` holds their time steps, s, and `incidence` the elements around each node.
    #[must_use]
    pub fn new(
        (mesh, incidence): (&Mesh<D>, &'a NodeIncidence),
        (position, velocity): (&[Vector<D>], &[Vector<D>]),
        (mass, corner_mass): (&[f64], &[[f64; 4]]),
        (step, is_compatible): (Vec<f64>, Vec<bool>),
        symmetry: BodySymmetry,
    ) -> Self {
        let node = |i: usize| NodeState { rest: mesh.rest[i], position: position[i], velocity: velocity[i] };
        Self {
            nodes: (0..mesh.rest.len()).map(node).collect(),
            mass: mass.to_vec(),
            held: mesh.held.clone(),
            elements: mesh.elements.clone(),
            corner_mass: corner_mass.to_vec(),
            step,
            is_there: vec![true; mesh.elements.len()],
            is_compatible,
            incidence,
            star: BTreeMap::new(),
            states: vec![None; mesh.elements.len()],
            n_first: mesh.elements.len(),
            symmetry,
        }
    }

    /// Number of elements so far, also of those that were replaced.
    pub(super) fn n_elements(&self) -> usize {
        self.elements.len()
    }

    /// Elements of the present mesh, ascending.
    pub(super) fn present(&self) -> impl Iterator<Item = ElementId> + '_ {
        (0..).map(ElementId).zip(&self.is_there).filter(|(_, is_there)| **is_there).map(|(element, _)| element)
    }

    pub(super) fn has(&self, element: ElementId) -> bool {
        self.is_there[element.index()]
    }

    /// Corners of an element.
    pub(super) fn corners(&self, element: ElementId) -> &[NodeId] {
        &self.elements[element.index()][..=D]
    }

    /// Elements around a node, ascending.
    pub(super) fn around(&self, node: NodeId) -> &[ElementId] {
        self.star.get(&node).map_or_else(|| self.incidence.of(node), Vec::as_slice)
    }

    /// Elements around a node, to be changed.
    fn star_mut(&mut self, node: NodeId) -> &mut Vec<ElementId> {
        self.star.entry(node).or_insert_with(|| self.incidence.of(node).to_vec())
    }

    /// Elements around an edge, ascending.
    pub(super) fn around_edge(&self, a: NodeId, b: NodeId) -> Vec<ElementId> {
        self.around(a).iter().copied().filter(|element| self.corners(*element).contains(&b)).collect()
    }

    /// Element across the facet opposite a corner.
    pub(super) fn across(&self, element: ElementId, corner: usize) -> Option<ElementId> {
        let nodes = self.corners(element);
        let facet = || nodes.iter().enumerate().filter(|(k, _)| *k != corner).map(|(_, node)| *node);
        let first = facet().next()?;
        let has_facet = |other: &&ElementId| **other != element && facet().all(|n| self.corners(**other).contains(&n));
        self.around(first).iter().find(has_facet).copied()
    }

    /// Returns true if an edge lies on the boundary.
    pub(super) fn is_boundary_edge(&self, a: NodeId, b: NodeId) -> bool {
        self.around_edge(a, b).iter().any(|element| {
            let nodes = self.corners(*element);
            (0..=D).any(|k| nodes[k] != a && nodes[k] != b && self.across(*element, k).is_none())
        })
    }

    /// Returns true if a node lies on the boundary.
    pub(super) fn is_boundary(&self, node: NodeId) -> bool {
        self.around(node).iter().any(|element| {
            let nodes = self.corners(*element);
            (0..=D).any(|k| nodes[k] != node && self.across(*element, k).is_none())
        })
    }

    /// Neighbours of a node along edges, ascending.
    pub(super) fn neighbours(&self, node: NodeId) -> Vec<NodeId> {
        let all = self.around(node).iter().flat_map(|element| self.corners(*element));
        let mut all: Vec<NodeId> = all.copied().filter(|other| *other != node).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// State of an element.
    pub(super) fn state(&mut self, element: ElementId, model: &impl ElementModel<D>) -> ElementState {
        let nodes = &self.elements[element.index()];
        let [rest, now] = [|n: &NodeState<D>| n.rest, |n: &NodeState<D>| n.position]
            .map(|of| std::array::from_fn(|k| of(&self.nodes[nodes[k.min(D)].index()])));
        *self.states[element.index()].get_or_insert_with(|| model.state(&rest, &now))
    }

    pub(super) fn is_compatible(&self, element: ElementId) -> bool {
        self.is_compatible[element.index()]
    }

    /// Mass of an element, kg.
    pub(super) fn mass_of(&self, element: ElementId) -> f64 {
        self.corner_mass[element.index()][..=D].iter().sum()
    }

    /// Performs an operation; returns the change of kinetic energy, J.
    pub(super) fn commit(&mut self, operation: &Operation<D>, states: &[ElementState]) -> f64 {
        let touched = self.touched(operation);
        let before = self.motion(&touched);
        let whole = operation.old.iter().map(|element| self.mass_of(*element)).sum::<f64>();
        if let Some((node, state)) = operation.node {
            self.place(node, state, operation);
        }
        for element in &operation.old {
            self.is_there[element.index()] = false;
            for node in self.elements[element.index()][..=D].to_vec() {
                self.star_mut(node).retain(|other| other != element);
            }
        }
        // Every part of the cavity has the density of the whole, at rest.
        let volume = states.iter().map(|state| state.volume).sum::<f64>();
        let step = operation.old.iter().map(|element| self.step[element.index()]).fold(f64::INFINITY, f64::min);
        for (nodes, state) in operation.new.iter().zip(states) {
            self.add(*nodes, *state, whole * state.volume / volume);
            self.step.push(step);
        }
        for node in &touched {
            let corner = |element: &ElementId| {
                let nodes = self.elements[element.index()];
                (0..=D).filter(|k| nodes[*k] == *node).map(|k| self.corner_mass[element.index()][k]).sum::<f64>()
            };
            self.mass[node.index()] = self.around(*node).iter().map(corner).sum::<f64>() + 0.0;
        }
        keep_motion(self, &touched, &before)
    }

    /// Nodes of a cavity before and after an operation, ascending.
    fn touched(&self, operation: &Operation<D>) -> Vec<NodeId> {
        let old = operation.old.iter().flat_map(|element| self.corners(*element).iter().copied());
        let new = operation.new.iter().flat_map(|nodes| nodes[..=D].iter().copied());
        let mut touched: Vec<NodeId> = old.chain(new).collect();
        touched.sort_unstable();
        touched.dedup();
        touched
    }

    /// Moves a node, or appends it.
    fn place(&mut self, node: NodeId, state: NodeState<D>, operation: &Operation<D>) {
        if node.index() < self.nodes.len() {
            self.nodes[node.index()] = state;
            return;
        }
        let [a, b] = operation.parents;
        self.nodes.push(state);
        self.mass.push(0.0);
        self.star.insert(node, vec![]);
        self.held.push(std::array::from_fn(|axis| self.held[a.index()][axis] && self.held[b.index()][axis]));
    }

    fn add(&mut self, nodes: Simplex, state: ElementState, mass: f64) {
        let element = ElementId(self.elements.len() as u32);
        let rest: Vec<Vector<D>> = nodes[..=D].iter().map(|node| self.nodes[node.index()].rest).collect();
        let own = [0, 1, 2, if D == 2 { 0 } else { 3 }].map(NodeId);
        let corner_mass = corner_masses(&rest, &[own], &[mass], self.symmetry)[0];
        nodes[..=D].iter().for_each(|node| self.star_mut(*node).push(element));
        self.elements.push(nodes);
        self.corner_mass.push(corner_mass);
        self.is_there.push(true);
        self.is_compatible.push(true);
        self.states.push(Some(state));
    }

    /// Mesh without what was given up, and its correspondence with the first one.
    #[must_use]
    pub fn finish(self) -> (EditedMesh<D>, MeshCorrespondence) {
        let mut is_used = vec![true; self.nodes.len()];
        self.star.iter().filter(|(_, star)| star.is_empty()).for_each(|(node, _)| is_used[node.index()] = false);
        let mut number = vec![NodeId(0); self.nodes.len()];
        let kept: Vec<usize> = (0..self.nodes.len()).filter(|node| is_used[*node]).collect();
        for (new, old) in (0..).map(NodeId).zip(&kept) {
            number[*old] = new;
        }
        let present: Vec<usize> = self.present().map(ElementId::index).collect();
        let elements = present.iter().map(|e| self.elements[*e].map(|node| number[node.index()])).collect();
        let same: Vec<Option<UnchangedElement>> = present
            .iter()
            .map(|e| (*e < self.n_first).then(|| UnchangedElement::in_order(ElementId(*e as u32))))
            .collect();
        let gone: Vec<ElementId> =
            (0..self.n_first).filter(|e| !self.is_there[*e]).map(|e| ElementId(e as u32)).collect();
        let mut is_touched = vec![false; self.nodes.len()];
        let changed = gone.iter().map(|e| e.index()).chain(present.iter().copied().filter(|e| *e >= self.n_first));
        for node in changed.flat_map(|e| &self.elements[e][..=D]) {
            is_touched[node.index()] = true;
        }
        let unchanged = kept.iter().map(|old| (!is_touched[*old]).then_some(NodeId(*old as u32))).collect();
        let field = |of: &dyn Fn(&NodeState<D>) -> Vector<D>| kept.iter().map(|node| of(&self.nodes[*node])).collect();
        let edited = EditedMesh {
            rest: field(&|node| node.rest),
            position: field(&|node| node.position),
            velocity: field(&|node| node.velocity),
            held: kept.iter().map(|node| self.held[*node]).collect(),
            mass: kept.iter().map(|node| self.mass[*node]).collect(),
            elements,
            corner_mass: present.iter().map(|e| self.corner_mass[*e]).collect(),
            step: present.iter().map(|e| self.step[*e]).collect(),
        };
        (edited, MeshCorrespondence { same, gone, unchanged })
    }
}
