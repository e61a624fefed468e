//! F-bar patches of a cavity: those that lose an element are grouped anew, with the elements that an operation makes,
//! and all others stay. Grouping the whole mesh anew would change the mean J of patches far from any operation.

use super::editable_mesh::{EditableMesh, ReferenceConfiguration};
use super::element_model::{ElementModel, ElementState};
use super::operation::{Operation, OperationKind};
use crate::math::Vector;
use crate::mesh::{ElementId, ElementPatches, NodeId, Simplex, face_neighbours};

/// Element of a patch after an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PatchMember {
    /// Element that stays.
    Kept(ElementId),
    /// Element that the operation makes, by its place among them.
    Made(usize),
}

/// Patches of a cavity after an operation.
#[derive(Debug, Clone)]
pub struct Regrouping {
    /// Patches that replace those of the cavity.
    pub(super) patches: Vec<Vec<PatchMember>>,
    /// Change of stored energy, J; 0 of a gel that flows.
    pub energy: f64,
}

/// Stored energy of a patch, J.
fn energy_of<const D: usize>(states: impl Iterator<Item = ElementState>, model: &impl ElementModel<D>) -> f64 {
    let (mut volume, mut stiff, mut flow, mut energy) = (0.0, 0.0, 0.0, 0.0);
    for state in states {
        volume += state.volume;
        stiff += state.volume * state.strength;
        flow += state.volume * state.jacobian;
        energy += state.energy;
    }
    energy + stiff * model.common_energy(flow / volume)
}

impl<const D: usize> EditableMesh<'_, D> {
    /// Groups the cavity of an operation anew, by the states of the elements that it makes; `None` if a patch of the
    /// cavity has an element with a rest shape of its own, or if the energy is infinite.
    pub(super) fn regroup(
        &self,
        operation: &Operation<D>,
        states: &[ElementState],
        model: &impl ElementModel<D>,
    ) -> Option<Regrouping> {
        let mut touched: Vec<u32> = operation.old.iter().map(|element| self.patch[element.index()]).collect();
        touched.sort_unstable();
        touched.dedup();
        let members = || touched.iter().map(|patch| self.members(*patch));
        if members().flatten().any(|element| !self.is_compatible(*element)) {
            return None;
        }
        let patches = if operation.kind == OperationKind::Move {
            self.same_patches(operation, &touched)
        } else {
            self.new_patches(operation, &touched)
        };
        if self.configuration == ReferenceConfiguration::Present {
            return Some(Regrouping { patches, energy: 0.0 });
        }
        let stored = |elements: &[ElementId]| energy_of(elements.iter().map(|e| self.state(*e, model)), model);
        let before = members().map(stored).fold(0.0, |sum, energy| sum + energy);
        let state = |member: &PatchMember| match member {
            PatchMember::Kept(element) => self.state(*element, model),
            PatchMember::Made(k) => states[*k],
        };
        let after = patches.iter().map(|patch| energy_of(patch.iter().map(state), model));
        let energy = after.fold(0.0, |sum, energy| sum + energy) - before;
        energy.is_finite().then_some(Regrouping { patches, energy })
    }

    /// Elements of a patch.
    fn members(&self, patch: u32) -> &[ElementId] {
        match (patch as usize).checked_sub(self.first_patches.len()) {
            Some(made) => &self.made_patches[made],
            None => self.first_patches.of(patch as usize),
        }
    }

    /// Patches of a cavity whose elements stay together: a move replaces each by one.
    fn same_patches(&self, operation: &Operation<D>, touched: &[u32]) -> Vec<Vec<PatchMember>> {
        let member = |element: &ElementId| {
            let made = operation.old.iter().position(|old| old == element);
            made.map_or(PatchMember::Kept(*element), PatchMember::Made)
        };
        touched.iter().map(|patch| self.members(*patch).iter().map(member).collect()).collect()
    }

    /// Patches of the remaining elements of those of a cavity and of the new ones, grouped by their rest shapes.
    fn new_patches(&self, operation: &Operation<D>, touched: &[u32]) -> Vec<Vec<PatchMember>> {
        let kept = touched.iter().flat_map(|patch| self.members(*patch)).filter(|e| !operation.old.contains(e));
        let mut members: Vec<PatchMember> = kept.map(|element| PatchMember::Kept(*element)).collect();
        members.extend((0..operation.new.len()).map(PatchMember::Made));
        if !self.has_patches {
            return members.into_iter().map(|member| vec![member]).collect();
        }
        let corners = |member: &PatchMember| match member {
            PatchMember::Kept(element) => self.elements[element.index()],
            PatchMember::Made(k) => operation.new[*k],
        };
        let global: Vec<Simplex> = members.iter().map(corners).collect();
        let mut nodes: Vec<NodeId> = global.iter().flat_map(|nodes| nodes[..=D].iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let local = |node: NodeId| NodeId(nodes.binary_search(&node).unwrap_or_default() as u32);
        let elements: Vec<Simplex> =
            global.iter().map(|nodes| std::array::from_fn(|k| local(nodes[if k <= D { k } else { 0 }]))).collect();
        let rest: Vec<Vector<D>> = nodes.iter().map(|node| self.after(operation, *node).rest).collect();
        let groups = ElementPatches::grouped_at((&rest, &elements), &face_neighbours::<D>(&elements));
        groups.iter().map(|group| group.iter().map(|k| members[k.index()]).collect()).collect()
    }

    /// Records the patches of a cavity whose new elements have been appended from number `first` on.
    pub(super) fn adopt_patches(&mut self, patches: &[Vec<PatchMember>], first: usize) {
        self.patch.resize(self.elements.len(), 0);
        for patch in patches {
            let number = (self.first_patches.len() + self.made_patches.len()) as u32;
            let element = |member: &PatchMember| match member {
                PatchMember::Kept(element) => *element,
                PatchMember::Made(k) => ElementId((first + k) as u32),
            };
            let members: Vec<ElementId> = patch.iter().map(element).collect();
            for element in &members {
                self.patch[element.index()] = number;
            }
            self.made_patches.push(members);
        }
    }
}
