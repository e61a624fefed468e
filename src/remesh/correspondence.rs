//! Which elements of a new mesh are those of the old one, and which old ones are gone.

use super::{Origin, Proposal};
use crate::mesh::{ElementId, Incidence, Mesh, NodeId, Simplex};

/// An old element that a new one is again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Same {
    /// The old element.
    pub element: ElementId,
    /// Corner c of the new one is corner `corners[c]` of the old one: an even permutation, which in the plane leaves the fourth.
    pub corners: [u8; 4],
}

impl Same {
    /// An old element, its corners in their order.
    #[must_use]
    pub fn in_order(element: ElementId) -> Self {
        Self { element, corners: [0, 1, 2, 3] }
    }

    /// What belongs to the corners of the old element, in the order of the new one.
    #[must_use]
    pub fn turned<T: Copy>(&self, corners: &[T; 4]) -> [T; 4] {
        self.corners.map(|c| corners[usize::from(c)])
    }

    /// An old element, if a new one has these of the old nodes and turns the same way.
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

/// How two meshes agree.
#[derive(Debug, Clone)]
pub struct Pairing {
    /// By new element, the old one that it is.
    pub same: Vec<Option<Same>>,
    /// The old elements that are gone.
    pub gone: Vec<ElementId>,
    /// By new node, the old one whose elements are all there again, and no others.
    pub unchanged: Vec<Option<NodeId>>,
}

/// How many old elements beyond the last one found are looked at before an element is looked for among all that are left.
const AHEAD: usize = 256;

impl Pairing {
    /// Of an old mesh and a new one: an element is the same if its nodes are the same and turn the same way.
    #[must_use]
    pub fn of<const D: usize>(old: &Mesh<D>, new: &Proposal<D>) -> Self {
        // Most that stay stand in their old order.
        let mut next = 0;
        let mut in_order = |nodes: &Simplex| {
            let kept = kept(new, nodes)?;
            let ahead = old.elements[next..].iter().take(AHEAD).position(|own| own[..=D] == kept[..=D])?;
            next += ahead + 1;
            Some(Same::in_order(ElementId(next as u32 - 1)))
        };
        let mut same: Vec<Option<Same>> = new.elements.iter().map(&mut in_order).collect();
        let left = Left::of(old, &gone(&same, old.elements.len()));
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

    /// What is known of the old elements, of those that are there again with their corners in the same order; the rest is made.
    pub fn carried<T: Copy>(&self, known: &[T], mut made: impl FnMut(usize) -> T) -> Vec<T> {
        let one = |(e, same): (usize, &Option<Same>)| match same {
            Some(Same { element, corners: [0, 1, 2, 3] }) => known[element.index()],
            Some(_) | None => made(e),
        };
        self.same.iter().enumerate().map(one).collect()
    }

    /// The new elements that are not old ones.
    pub fn changed(&self) -> impl Iterator<Item = usize> + '_ {
        self.same.iter().enumerate().filter(|(_, same)| same.is_none()).map(|(e, _)| e)
    }
}

/// The old nodes of a new element all of whose nodes are old ones.
fn kept<const D: usize>(new: &Proposal<D>, nodes: &Simplex) -> Option<[NodeId; 4]> {
    let mut kept = [NodeId::default(); 4];
    for (kept, node) in kept.iter_mut().zip(&nodes[..=D]) {
        let Origin::Kept(old) = new.origin[node.index()] else { return None };
        *kept = old;
    }
    Some(kept)
}

/// Old elements by their nodes.
struct Left<'a, const D: usize> {
    old: &'a Mesh<D>,
    /// The nodes of each, ascending, and which it is; in that order.
    all: Vec<([NodeId; 4], ElementId)>,
}

impl<'a, const D: usize> Left<'a, D> {
    fn of(old: &'a Mesh<D>, elements: &[ElementId]) -> Self {
        let mut all: Vec<_> = elements.iter().map(|e| (ascending::<D>(&old.elements[e.index()]), *e)).collect();
        all.sort_unstable();
        Self { old, all }
    }

    /// That which a new element with these of the old nodes is.
    fn same(&self, nodes: &[NodeId; 4]) -> Option<Same> {
        let key = ascending::<D>(nodes);
        let first = self.all.partition_point(|(nodes, _)| *nodes < key);
        let mut equal = self.all[first..].iter().take_while(|(nodes, _)| *nodes == key);
        equal.find_map(|(_, element)| Same::of::<D>(*element, &self.old.elements[element.index()], nodes))
    }
}

/// The nodes of an element in ascending order; of a fourth in the plane the first one.
fn ascending<const D: usize>(nodes: &Simplex) -> [NodeId; 4] {
    let mut ascending = [NodeId::default(); 4];
    ascending[..=D].copy_from_slice(&nodes[..=D]);
    ascending[..=D].sort_unstable();
    ascending
}

fn gone(same: &[Option<Same>], n_old: usize) -> Vec<ElementId> {
    let mut is_gone = vec![true; n_old];
    for same in same.iter().flatten() {
        is_gone[same.element.index()] = false;
    }
    (0..n_old as u32).map(ElementId).filter(|e| is_gone[e.index()]).collect()
}

/// The elements across the facets of what is gone. Where no element of the new mesh is new nothing was put in its place, and what it
/// carries is laid on them. Where some are it is laid on the nearest of those, however far: with heirs then, too, the splash of
/// `hydro-drag` on cells of R/12 was drawn to slivers at which no mesh was good enough, and three of four runs stopped, none without.
fn heirs<const D: usize>(old: &Mesh<D>, gone: &[ElementId]) -> Vec<ElementId> {
    if gone.is_empty() {
        return vec![];
    }
    let around = Incidence::new(old.rest.len(), old.elements.iter().map(|nodes| &nodes[..=D]));
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

/// The old nodes around which no old element is gone and no new one is new.
fn unchanged<const D: usize>(
    (old, new): (&Mesh<D>, &Proposal<D>),
    same: &[Option<Same>],
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
    let whole = |(origin, has_new): (&Origin, bool)| match origin {
        Origin::Kept(node) if !has_new && !has_lost[node.index()] => Some(*node),
        Origin::Kept(_) | Origin::Surface(..) | Origin::Inside => None,
    };
    new.origin.iter().zip(has_new).map(whole).collect()
}
