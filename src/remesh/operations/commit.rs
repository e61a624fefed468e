//! Performance of an operation: the elements of its cavity are replaced, and its masses and velocities.

use super::editable_mesh::{EditableMesh, ReferenceConfiguration};
use super::element_model::ElementState;
use super::operation::{EditedNode, Operation};
use super::regrouping::Regrouping;
use super::velocity::keep_motion;
use crate::math::Vector;
use crate::mesh::{ElementId, NodeId, Simplex};
use crate::remesh::nodal_fields::corner_masses;
use std::sync::Arc;

impl<const D: usize> EditableMesh<'_, D> {
    /// Performs an operation; returns the change of kinetic energy, J, 0 of a gel that flows: its velocities and masses
    /// are transferred when all operations are done.
    pub(super) fn commit(&mut self, operation: &Operation<D>, states: &[ElementState], regrouping: &Regrouping) -> f64 {
        let touched = (self.configuration == ReferenceConfiguration::Rest).then(|| self.touched(operation));
        let before = touched.as_ref().map(|touched| self.motion(touched));
        let whole = operation.old.iter().map(|element| self.mass_of(*element)).sum::<f64>();
        if let Some((node, state)) = operation.node {
            self.put(node, state, operation);
        }
        for element in &operation.old {
            self.is_there[element.index()] = false;
            let nodes = self.elements[element.index()];
            for node in nodes.into_iter().take(D + 1) {
                self.star_mut(node).retain(|other| other != element);
            }
        }
        // Every part of the cavity has the density of the whole, at rest, but for that of its materials.
        let share = |state: &ElementState| state.volume * state.density;
        let shares = states.iter().map(share).sum::<f64>();
        let step = operation.old.iter().map(|element| self.step[element.index()]).fold(f64::INFINITY, f64::min);
        let (first, over) = (self.elements.len(), self.first_elements(&operation.old));
        for (nodes, state) in operation.new.iter().zip(states) {
            self.add(*nodes, *state, whole * share(state) / shares);
            self.step.push(step);
            self.made_of.push(Arc::clone(&over));
        }
        self.adopt_patches(&regrouping.patches, first);
        let (Some(touched), Some(before)) = (touched, before) else { return 0.0 };
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
        let mut touched = Vec::with_capacity((D + 1) * (operation.old.len() + operation.new.len()));
        touched.extend(old.chain(new));
        touched.sort_unstable();
        touched.dedup();
        touched
    }

    /// Moves a node, or appends it.
    fn put(&mut self, node: NodeId, state: EditedNode<D>, operation: &Operation<D>) {
        if node.index() < self.nodes.len() {
            self.nodes[node.index()] = state;
            return;
        }
        let [a, b] = operation.parents;
        self.nodes.push(state);
        self.mass.push(0.0);
        self.star.push(Some(vec![]));
        self.is_boundary.push(self.is_boundary_edge(a, b));
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
        self.states.push(state.into());
    }
}
