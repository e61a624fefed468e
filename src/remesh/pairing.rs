//! Which elements of a new mesh are those of the old one, and which old ones are gone.

use super::{Origin, Proposal};
use crate::mesh::{ElementId, Incidence, Mesh, NodeId, Simplex};

/// An old element that a new one is again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Same {
    /// The old element.
    pub element: ElementId,
    /// Corner c of the new one is corner (c + turn) mod 3 of the old one.
    pub turn: usize,
}

impl Same {
    /// What belongs to the corners of the old element, in the order of the new one.
    #[must_use]
    pub fn turned<T: Copy>(&self, corners: &[T]) -> [T; 3] {
        std::array::from_fn(|c| corners[(c + self.turn) % 3])
    }
}

/// How two meshes agree.
#[derive(Debug)]
pub(super) struct Pairing {
    /// By new element, the old one that it is.
    pub same: Vec<Option<Same>>,
    /// The old elements that are gone.
    pub gone: Vec<ElementId>,
    /// By new node, the old one whose elements are all there again, and no others.
    pub unchanged: Vec<Option<NodeId>>,
}

impl Pairing {
    /// Of an old mesh and a new one: an element is the same if its nodes are the same and turn the same way.
    pub fn of(old: &Mesh<2>, new: &Proposal<2>) -> Self {
        let around = Incidence::new(old.rest.len(), old.elements.iter().map(|nodes| &nodes[..3]));
        let same: Vec<Option<Same>> =
            new.elements.iter().map(|nodes| same(&kept(new, nodes)?, &around, &old.elements)).collect();
        let mut is_gone = vec![true; old.elements.len()];
        for same in same.iter().flatten() {
            is_gone[same.element.index()] = false;
        }
        let gone = (0..old.elements.len() as u32).map(ElementId).filter(|e| is_gone[e.index()]).collect();
        let unchanged = unchanged(new, &same, &around);
        Self { same, gone, unchanged }
    }

    /// The new elements that are not old ones.
    pub fn changed(&self) -> impl Iterator<Item = usize> + '_ {
        self.same.iter().enumerate().filter(|(_, same)| same.is_none()).map(|(e, _)| e)
    }
}

/// The old nodes of a new element all of whose nodes are old ones.
fn kept(new: &Proposal<2>, nodes: &Simplex) -> Option<[NodeId; 3]> {
    let mut kept = [NodeId::default(); 3];
    for (kept, node) in kept.iter_mut().zip(nodes) {
        let Origin::Kept(old) = new.origin[node.index()] else { return None };
        *kept = old;
    }
    Some(kept)
}

fn same(nodes: &[NodeId; 3], around: &Incidence, old: &[Simplex]) -> Option<Same> {
    around.of(nodes[0]).iter().find_map(|element| {
        let turn = old[element.index()][..3].iter().position(|node| *node == nodes[0])?;
        let same = Same { element: *element, turn };
        (same.turned(&old[element.index()][..3]) == *nodes).then_some(same)
    })
}

fn unchanged(new: &Proposal<2>, same: &[Option<Same>], around: &Incidence) -> Vec<Option<NodeId>> {
    let mut found = vec![0_usize; new.position.len()];
    for nodes in new.elements.iter().zip(same).filter(|(_, same)| same.is_some()).map(|(nodes, _)| nodes) {
        nodes[..3].iter().for_each(|node| found[node.index()] += 1);
    }
    for (nodes, _) in new.elements.iter().zip(same).filter(|(_, same)| same.is_none()) {
        nodes[..3].iter().for_each(|node| found[node.index()] = usize::MAX / 2);
    }
    let whole = |(origin, found): (&Origin, usize)| match origin {
        Origin::Kept(node) if around.of(*node).len() == found => Some(*node),
        Origin::Kept(_) | Origin::Surface(..) | Origin::Inside => None,
    };
    new.origin.iter().zip(found).map(whole).collect()
}
