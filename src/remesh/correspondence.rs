//! Correspondence of two meshes: unchanged, changed and removed elements.

use super::{NodeOrigin, ProposedMesh};
use crate::mesh::{ElementId, Mesh, NodeId, NodeIncidence, Simplex};

/// Unchanged element: an old element that reappears in the new mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnchangedElement {
    /// Old element.
    pub element: ElementId,
    /// Permutation: corner c of the new element is corner `corners[c]` of the old one. It is even; in the plane it
    /// fixes the fourth.
    pub corners: [u8; 4],
}

impl UnchangedElement {
    /// Builds the identity correspondence of an old element.
    #[must_use]
    pub fn in_order(element: ElementId) -> Self {
        Self { element, corners: [0, 1, 2, 3] }
    }

    /// Permutes corner values of the old element to the order of the new one.
    #[must_use]
    pub fn turned<T: Copy>(&self, corners: &[T; 4]) -> [T; 4] {
        self.corners.map(|c| corners[usize::from(c)])
    }

    /// Matches an old element with the old nodes of a new one, if the nodes and the orientation agree.
    fn of<const D: usize>(element: ElementId, old: &Simplex, nodes: &[NodeId; 4]) -> Option<Self> {
        let mut corners = [0, 1, 2, 3];
        for (corner, node) in corners[..=D].iter_mut().zip(nodes) {
            *corner = (0..=D as u8).find(|c| old[usize::from(*c)] == *node)?;
        }
        let pairs = (0..4).flat_map(|i| (0..i).map(move |j| (j, i)));
        let swaps = pairs.filter(|(j, i)| corners[*j] > corners[*i]).count();
        swaps.is_multiple_of(2).then_some(Self { element, corners })
    }
}

/// Overlap of an old and a new element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverlapSource {
    /// New element.
    pub new: ElementId,
    /// Old element.
    pub old: ElementId,
    /// Mass of the overlap, kg.
    pub mass: f64,
    /// Overlap relative to the area or volume of the old element, weighted by the radius for a ring.
    pub part: f64,
}

/// Correspondence of an old and a new mesh.
#[derive(Debug, Clone)]
pub struct MeshCorrespondence {
    /// Old element of each unchanged new element.
    pub same: Vec<Option<UnchangedElement>>,
    /// Old elements that the new mesh lacks.
    pub gone: Vec<ElementId>,
    /// Old node of each new node whose set of elements is unchanged.
    pub unchanged: Vec<Option<NodeId>>,
}

/// Old elements inspected beyond the last match before the search covers all remaining ones.
const AHEAD: usize = 256;

impl MeshCorrespondence {
    /// Matches an old and a new mesh: an element is unchanged if its nodes and its orientation are.
    #[must_use]
    pub fn of<const D: usize>(old: &Mesh<D>, new: &ProposedMesh<D>) -> Self {
        // Most unchanged elements keep their old order.
        let mut next = 0;
        let mut in_order = |nodes: &Simplex| {
            let kept = kept(new, nodes)?;
            let ahead = old.elements[next..].iter().take(AHEAD).position(|own| own[..=D] == kept[..=D])?;
            next += ahead + 1;
            Some(UnchangedElement::in_order(ElementId(next as u32 - 1)))
        };
        let mut same: Vec<Option<UnchangedElement>> = new.elements.iter().map(&mut in_order).collect();
        let left = RemainingElements::of(old, &gone(&same, old.elements.len()));
        for (nodes, same) in new.elements.iter().zip(&mut same).filter(|(_, same)| same.is_none()) {
            *same = kept(new, nodes).and_then(|kept| left.same(&kept));
        }
        let mut gone = gone(&same, old.elements.len());
        if same.iter().all(Option::is_some) {
            let heirs = heirs(old, &gone);
            same.iter_mut()
                .filter(|same| same.is_some_and(|same| heirs.binary_search(&same.element).is_ok()))
                .for_each(|s| *s = None);
            gone.extend(heirs);
            gone.sort_unstable();
        }
        let unchanged = unchanged((old, new), &same, &gone);
        Self { same, gone, unchanged }
    }

    /// Carries known values to the unchanged elements with unpermuted corners; the others are made.
    pub fn carried<T: Copy>(&self, known: &[T], mut made: impl FnMut(usize) -> T) -> Vec<T> {
        let one = |(e, same): (usize, &Option<UnchangedElement>)| match same {
            Some(UnchangedElement { element, corners: [0, 1, 2, 3] }) => known[element.index()],
            Some(_) | None => made(e),
        };
        self.same.iter().enumerate().map(one).collect()
    }

    /// Iterates over the changed elements of the new mesh.
    pub fn changed(&self) -> impl Iterator<Item = usize> + '_ {
        self.same.iter().enumerate().filter(|(_, same)| same.is_none()).map(|(e, _)| e)
    }
}

/// Old nodes of a new element if all its nodes are old.
fn kept<const D: usize>(new: &ProposedMesh<D>, nodes: &Simplex) -> Option<[NodeId; 4]> {
    let mut kept = [NodeId::default(); 4];
    for (kept, node) in kept.iter_mut().zip(&nodes[..=D]) {
        let NodeOrigin::Kept(old) = new.origin[node.index()] else { return None };
        *kept = old;
    }
    Some(kept)
}

/// Remaining old elements, searchable by their nodes.
struct RemainingElements<'a, const D: usize> {
    old: &'a Mesh<D>,
    /// Sorted list of (ascending nodes, element).
    all: Vec<([NodeId; 4], ElementId)>,
}

impl<'a, const D: usize> RemainingElements<'a, D> {
    fn of(old: &'a Mesh<D>, elements: &[ElementId]) -> Self {
        let mut all: Vec<_> = elements.iter().map(|e| (ascending::<D>(&old.elements[e.index()]), *e)).collect();
        all.sort_unstable();
        Self { old, all }
    }

    /// Finds the unchanged element with these old nodes.
    fn same(&self, nodes: &[NodeId; 4]) -> Option<UnchangedElement> {
        let key = ascending::<D>(nodes);
        let first = self.all.partition_point(|(nodes, _)| *nodes < key);
        let mut equal = self.all[first..].iter().take_while(|(nodes, _)| *nodes == key);
        equal.find_map(|(_, element)| UnchangedElement::of::<D>(*element, &self.old.elements[element.index()], nodes))
    }
}

/// Nodes of an element in ascending order; in the plane the first entry replaces the fourth.
fn ascending<const D: usize>(nodes: &Simplex) -> [NodeId; 4] {
    let mut ascending = [NodeId::default(); 4];
    ascending[..=D].copy_from_slice(&nodes[..=D]);
    ascending[..=D].sort_unstable();
    ascending
}

fn gone(same: &[Option<UnchangedElement>], n_old: usize) -> Vec<ElementId> {
    let mut is_gone = vec![true; n_old];
    for same in same.iter().flatten() {
        is_gone[same.element.index()] = false;
    }
    (0..n_old as u32).map(ElementId).filter(|e| is_gone[e.index()]).collect()
}

/// Heirs of removed mass: the elements across the facets of removed elements. They exist only if no new element is
/// changed: nothing replaces the removed elements, and their fields are deposited on the heirs. Otherwise the nearest
/// changed elements receive them, however far. Heirs in that case drew the eroded gel of `hydro-drag` (cells of R/12)
/// to slivers, and three of four runs failed for want of an acceptable mesh; without heirs none did.
fn heirs<const D: usize>(old: &Mesh<D>, gone: &[ElementId]) -> Vec<ElementId> {
    if gone.is_empty() {
        return vec![];
    }
    let around = NodeIncidence::new(old.rest.len(), old.elements.iter().map(|nodes| &nodes[..=D]));
    let nodes_of = |e: &ElementId| &old.elements[e.index()][..=D];
    let mut heirs = vec![];
    for nodes in gone.iter().map(nodes_of) {
        let shared = |other: &ElementId| nodes.iter().filter(|node| nodes_of(other).contains(node)).count();
        let beside = nodes.iter().flat_map(|node| around.of(*node)).filter(|other| shared(other) == D);
        heirs.extend(beside.filter(|other| gone.binary_search(other).is_err()));
    }
    heirs.sort_unstable();
    heirs.dedup();
    heirs
}

/// Old node of each new node around which no element was removed or added.
fn unchanged<const D: usize>(
    (old, new): (&Mesh<D>, &ProposedMesh<D>),
    same: &[Option<UnchangedElement>],
    gone: &[ElementId],
) -> Vec<Option<NodeId>> {
    let mut has_lost = vec![false; old.rest.len()];
    for nodes in gone.iter().map(|e| &old.elements[e.index()]) {
        nodes[..=D].iter().for_each(|node| has_lost[node.index()] = true);
    }
    let mut has_new = vec![false; new.position.len()];
    for (nodes, _) in new.elements.iter().zip(same).filter(|(_, same)| same.is_none()) {
        nodes[..=D].iter().for_each(|node| has_new[node.index()] = true);
    }
    let whole = |(origin, has_new): (&NodeOrigin, bool)| match origin {
        NodeOrigin::Kept(node) if !has_new && !has_lost[node.index()] => Some(*node),
        NodeOrigin::Kept(_) | NodeOrigin::Surface(..) | NodeOrigin::Inside => None,
    };
    new.origin.iter().zip(has_new).map(whole).collect()
}
