//! Mesh whose elements are replaced one cavity at a time.

use super::element_model::{ElementModel, ElementState};
use super::operation::EditedNode;
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, Mesh, NodeId, NodeIncidence, Simplex};
use crate::remesh::{BodySymmetry, MeshCorrespondence, NodeOrigin, UnchangedElement};
use std::cell::OnceCell;
use std::sync::Arc;

/// Nodes and elements of a deformed gel, with the elements around each node.
///
/// Nodes and elements that are made are appended; those that are given up keep their number until [`Self::finish`].
#[derive(Debug, Clone)]
pub struct EditableMesh<'a, const D: usize> {
    pub(super) nodes: Vec<EditedNode<D>>,
    /// Masses of the nodes, kg.
    pub(super) mass: Vec<f64>,
    pub(super) held: Vec<[bool; D]>,
    /// Elements, also those that were replaced.
    pub(super) elements: Vec<Simplex>,
    /// Masses of the corners of the elements, kg.
    pub(super) corner_mass: Vec<[f64; 4]>,
    /// Time steps with which the elements were integrated, s.
    pub(super) step: Vec<f64>,
    /// True for elements of the present mesh.
    pub(super) is_there: Vec<bool>,
    /// True for elements whose rest shape is that of their nodes; no operation touches the others.
    pub(super) is_compatible: Vec<bool>,
    /// Elements around each node of the first mesh.
    incidence: &'a NodeIncidence,
    /// Elements around the nodes of cavities, ascending; none of a node whose elements are those of the first mesh.
    pub(super) star: Vec<Option<Vec<ElementId>>>,
    /// True for nodes of the boundary: operations keep it, and its nodes.
    pub(super) is_boundary: Vec<bool>,
    /// Patch of each element, those of the first mesh, and those made since.
    pub(super) patch: Vec<u32>,
    pub(super) first_patches: &'a ElementPatches,
    pub(super) made_patches: Vec<Vec<ElementId>>,
    /// True if elements share their change of volume in patches.
    pub(super) has_patches: bool,
    /// State of each element, found when it is first asked for.
    pub(super) states: Vec<OnceCell<ElementState>>,
    /// Elements of the first mesh.
    n_first: usize,
    /// Elements of the first mesh that each element made since replaces, ascending: one list for all of an operation.
    pub(super) made_of: Vec<Arc<[ElementId]>>,
    pub(super) symmetry: BodySymmetry,
    pub(super) configuration: ReferenceConfiguration,
}

/// Configuration of the gel in which operations are judged: the positions that stand for X in F = ∂x/∂X.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferenceConfiguration {
    /// Rest positions that the nodes carry, of a gel without history variables: operations keep its surface at rest,
    /// and are accepted by their change of stored energy.
    Rest,
    /// Present positions of the nodes, of a gel that flows: one with history variables, or an elastic one that an
    /// immersed mesh has given rest shapes by element. Its stress does not follow from rest positions of nodes: no
    /// energy is compared, and the surface may be smoothed a little.
    Present,
}

/// Gel as it is before the operations.
pub struct EditSource<'a, const D: usize> {
    /// Mesh.
    pub mesh: &'a Mesh<D>,
    /// Elements around each node.
    pub incidence: &'a NodeIncidence,
    /// F-bar patches of the elements.
    pub patches: &'a ElementPatches,
    /// Positions of the nodes, m.
    pub position: &'a [Vector<D>],
    /// Velocities of the nodes, m/s.
    pub velocity: &'a [Vector<D>],
    /// Masses of the nodes, kg.
    pub mass: &'a [f64],
    /// Masses of the corners of the elements, kg.
    pub corner_mass: &'a [[f64; 4]],
    /// Time steps of the elements, s.
    pub step: Vec<f64>,
    /// True for elements that operations may replace: those whose rest shape is that of their nodes.
    pub is_compatible: Vec<bool>,
    /// Symmetry of the body.
    pub symmetry: BodySymmetry,
    /// Configuration in which operations are judged.
    pub configuration: ReferenceConfiguration,
}

/// Mesh after its operations, numbered anew: kept nodes and elements first, in their old order.
#[derive(Debug, Clone, PartialEq)]
pub struct EditedMesh<const D: usize> {
    /// Rest positions, m.
    pub rest: Vec<Vector<D>>,
    /// Positions, m.
    pub position: Vec<Vector<D>>,
    /// Velocities, m/s; of a gel that flows interpolated, without a correction.
    pub velocity: Vec<Vector<D>>,
    /// Held directions.
    pub held: Vec<[bool; D]>,
    /// Masses of the nodes, kg; of a gel that flows those before.
    pub mass: Vec<f64>,
    /// Elements.
    pub elements: Vec<Simplex>,
    /// Masses of the corners of the elements, kg.
    pub corner_mass: Vec<[f64; 4]>,
    /// F-bar patches of the elements.
    pub patches: ElementPatches,
    /// Time steps of the elements, or of those that they replace, s.
    pub step: Vec<f64>,
    /// Origins of the nodes in the first mesh.
    pub origin: Vec<NodeOrigin>,
    /// Elements of the first mesh that each new element replaces, ascending; none of an element that stays.
    pub over: Vec<Arc<[ElementId]>>,
}

impl<'a, const D: usize> EditableMesh<'a, D> {
    /// Mesh of a gel.
    #[must_use]
    pub fn new(gel: EditSource<'a, D>) -> Self {
        let EditSource { mesh, incidence, patches, position, velocity, mass, corner_mass, .. } = gel;
        let rest = if gel.configuration == ReferenceConfiguration::Rest { &mesh.rest } else { position };
        let mut is_boundary = vec![false; mesh.rest.len()];
        mesh.facets.iter().flat_map(|facet| &facet[..D]).for_each(|node| is_boundary[node.index()] = true);
        let origin = |i: usize| NodeOrigin::Kept(NodeId(i as u32));
        let node =
            |i: usize| EditedNode { rest: rest[i], position: position[i], velocity: velocity[i], origin: origin(i) };
        Self {
            nodes: (0..mesh.rest.len()).map(node).collect(),
            mass: mass.to_vec(),
            held: mesh.held.clone(),
            elements: mesh.elements.clone(),
            corner_mass: corner_mass.to_vec(),
            step: gel.step,
            is_there: vec![true; mesh.elements.len()],
            is_compatible: gel.is_compatible,
            incidence,
            star: vec![None; mesh.rest.len()],
            is_boundary,
            patch: patches.patch_of_elements().into_iter().map(|patch| patch.0).collect(),
            first_patches: patches,
            made_patches: vec![],
            has_patches: patches.largest() > 1,
            states: vec![OnceCell::new(); mesh.elements.len()],
            n_first: mesh.elements.len(),
            made_of: vec![],
            symmetry: gel.symmetry,
            configuration: gel.configuration,
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

    /// Position of a node, m.
    pub(super) fn place(&self, node: NodeId) -> Vector<D> {
        self.nodes[node.index()].position
    }

    /// Elements around a node, ascending.
    pub(super) fn around(&self, node: NodeId) -> &[ElementId] {
        self.star[node.index()].as_deref().unwrap_or_else(|| self.incidence.of(node))
    }

    /// Elements around a node, to be changed.
    pub(super) fn star_mut(&mut self, node: NodeId) -> &mut Vec<ElementId> {
        self.star[node.index()].get_or_insert_with(|| self.incidence.of(node).to_vec())
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
        self.is_boundary(a) && self.is_boundary(b) && self.boundary_facets_at(a, b).next().is_some()
    }

    /// Elements of the boundary facets at an edge: one in the plane, two in space where the gel does not touch itself.
    pub(super) fn boundary_facets_at(&self, a: NodeId, b: NodeId) -> impl Iterator<Item = ElementId> {
        let facets = move |element: ElementId| {
            let nodes = self.corners(element);
            let is_facet = move |k: &usize| nodes[*k] != a && nodes[*k] != b && self.across(element, *k).is_none();
            (0..=D).filter(is_facet).map(move |_| element)
        };
        self.around_edge(a, b).into_iter().flat_map(facets)
    }

    /// Returns true if three nodes of an element in space are those of a facet of the boundary.
    pub(super) fn is_boundary_facet(&self, facet: [NodeId; 3]) -> bool {
        let has_facet = |element: &&ElementId| facet.iter().all(|node| self.corners(**element).contains(node));
        self.around(facet[0]).iter().filter(has_facet).count() == 1
    }

    /// Returns true if a node lies on the boundary.
    pub(super) fn is_boundary(&self, node: NodeId) -> bool {
        self.is_boundary[node.index()]
    }

    /// Neighbours of a node along edges, ascending.
    pub(super) fn neighbours(&self, node: NodeId) -> Vec<NodeId> {
        let around = self.around(node);
        let mut all = Vec::with_capacity(D * around.len());
        all.extend(around.iter().flat_map(|e| self.corners(*e)).copied().filter(|other| *other != node));
        all.sort_unstable();
        all.dedup();
        all
    }

    /// State of an element.
    pub(super) fn state(&self, element: ElementId, model: &impl ElementModel<D>) -> ElementState {
        *self.states[element.index()].get_or_init(|| {
            let nodes = &self.elements[element.index()];
            let [rest, now] = [|n: &EditedNode<D>| n.rest, |n: &EditedNode<D>| n.position]
                .map(|of| std::array::from_fn(|k| of(&self.nodes[nodes[k.min(D)].index()])));
            model.state(&rest, &now)
        })
    }

    /// Raises the hindrance of an element to this, if it is less.
    pub fn raise_hindrance(&mut self, element: ElementId, model: &impl ElementModel<D>, hindrance: f64) {
        let state = self.state(element, model);
        self.states[element.index()] = ElementState { hindrance: state.hindrance.max(hindrance), ..state }.into();
    }

    pub(super) fn is_compatible(&self, element: ElementId) -> bool {
        self.is_compatible[element.index()]
    }

    /// Mass of an element, kg.
    pub(super) fn mass_of(&self, element: ElementId) -> f64 {
        self.corner_mass[element.index()][..=D].iter().sum()
    }

    /// Elements of the first mesh that an element made since replaces; none of an element of the first mesh.
    fn made_of(&self, element: ElementId) -> Arc<[ElementId]> {
        element.index().checked_sub(self.n_first).map_or_else(Arc::default, |made| Arc::clone(&self.made_of[made]))
    }

    /// Elements of the first mesh that these elements are or replace, ascending.
    pub(super) fn first_elements(&self, elements: &[ElementId]) -> Arc<[ElementId]> {
        let mut lists: Vec<Arc<[ElementId]>> = elements.iter().map(|element| self.made_of(*element)).collect();
        lists.sort_unstable_by_key(|list| list.as_ptr());
        lists.dedup_by_key(|list| list.as_ptr());
        let mut all: Vec<ElementId> = elements.iter().copied().filter(|e| e.index() < self.n_first).collect();
        for list in &lists {
            all.extend_from_slice(list);
        }
        all.sort_unstable();
        all.dedup();
        all.into()
    }

    /// Origin of a node in the first mesh.
    fn origin(&self, node: NodeId) -> NodeOrigin {
        match self.nodes[node.index()].origin {
            NodeOrigin::Surface(..) if !self.is_boundary(node) => NodeOrigin::Inside,
            origin => origin,
        }
    }

    /// Mesh without what was given up, and its correspondence with the first one.
    #[must_use]
    pub fn finish(self) -> (EditedMesh<D>, MeshCorrespondence) {
        let is_used = |node: usize| self.star[node].as_ref().is_none_or(|star| !star.is_empty());
        let mut number = vec![NodeId(0); self.nodes.len()];
        let kept: Vec<usize> = (0..self.nodes.len()).filter(|node| is_used(*node)).collect();
        for (new, old) in (0..).map(NodeId).zip(&kept) {
            number[*old] = new;
        }
        let present: Vec<usize> = self.present().map(ElementId::index).collect();
        let elements = present.iter().map(|e| self.elements[*e].map(|node| number[node.index()])).collect();
        let patch: Vec<u32> = present.iter().map(|e| self.patch[*e]).collect();
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
        let field = |of: &dyn Fn(&EditedNode<D>) -> Vector<D>| kept.iter().map(|node| of(&self.nodes[*node])).collect();
        let edited = EditedMesh {
            rest: field(&|node| node.rest),
            position: field(&|node| node.position),
            velocity: field(&|node| node.velocity),
            held: kept.iter().map(|node| self.held[*node]).collect(),
            mass: kept.iter().map(|node| self.mass[*node]).collect(),
            elements,
            corner_mass: present.iter().map(|e| self.corner_mass[*e]).collect(),
            patches: ElementPatches::of_labels(&patch),
            step: present.iter().map(|e| self.step[*e]).collect(),
            origin: kept.iter().map(|node| self.origin(NodeId(*node as u32))).collect(),
            over: present.iter().map(|e| self.made_of(ElementId(*e as u32))).collect(),
        };
        (edited, MeshCorrespondence { same, gone, unchanged })
    }
}
