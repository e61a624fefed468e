//! F-bar patches (de Souza Neto et al. 2005): disjoint groups of elements that share one volume change (method 5).
//!
//! A linear triangle or tetrahedron with a volume constraint of its own locks near incompressibility: there are more
//! constraints than the nodes can satisfy. Patches of two triangles or four tetrahedra with one common constraint do
//! not lock. The grouping is a matching in the element graph: groups that share facets are joined two by two, once in
//! the plane, twice in space. It leaves few groups over and prefers compact unions. In space, rings of four tetrahedra
//! around an edge are joined first: those of the centred lattice are its octahedra, and elsewhere too they give a
//! smoother pressure.
//!
//! Verification: a punch on a quarter of a clamped block (linear, N = 16 cells per edge) at ν = 0.4999, force relative
//! to nodal averaging. In the plane pairs give 0.97–1.00 and plain triangles 1.00–2.28, on crossed, Kuhn, displaced and
//! random Delaunay triangles. In space fours give 0.986–1.011 and plain tetrahedra 1.19–3.31, on the centred and Kuhn
//! lattice, displaced or not, and on random Delaunay tetrahedra, of which 99 % are in fours. Pairs of tetrahedra still
//! lock, by 7 to 81 %.

mod element_graph;
mod matching;
mod rings;

use super::{ElementId, Mesh, Simplex, face_neighbours};
use crate::math::Vector;
use element_graph::ElementGraph;
use rings::EdgeRing;

/// Partition of the elements into disjoint patches.
///
/// Patches are ordered by their first elements, elements within a patch ascend: the locality of the mesh order is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ElementPatches {
    /// Offsets: patch p is `members[start[p]..start[p + 1]]`. Empty where patch p is element p.
    start: Vec<u32>,
    members: Vec<ElementId>,
}

impl ElementPatches {
    /// Returns the trivial partition: one patch per element.
    #[must_use]
    pub fn alone(n_elements: usize) -> Self {
        let n = n_elements as u32;
        Self { start: vec![], members: (0..n).map(ElementId).collect() }
    }

    /// Groups the elements of a mesh into patches that do not lock: pairs in the plane, up to four elements in space.
    /// Elements without a partner stay in smaller patches. The elements of a patch are connected through facets, so it
    /// has at most 4 nodes in the plane and 7 in space.
    ///
    /// ```
    /// use ballistic_gel::mesh::{BlockSpec, CellSplit, ElementId, ElementPatches, block, uniform};
    ///
    /// let axis = || uniform(0.0, 1.0, 0.5);
    /// let mesh = block(BlockSpec { planes: [axis(), axis(), axis()], split: CellSplit::Centred, faces: vec![] });
    /// let patches = ElementPatches::grouped(&mesh);
    /// assert!(patches.iter().all(|elements| elements.len() == 4));
    /// ```
    #[must_use]
    pub fn grouped<const D: usize>(mesh: &Mesh<D>) -> Self {
        Self::grouped_at((&mesh.rest, &mesh.elements), &face_neighbours::<D>(&mesh.elements))
    }

    /// Groups elements at given node positions, with known face neighbours, into patches as [`ElementPatches::grouped`] does.
    ///
    /// # Panics
    /// Unless there is one row of neighbours per element.
    #[must_use]
    pub fn grouped_at<const D: usize>(
        (nodes, elements): (&[Vector<D>], &[Simplex]),
        across: &[[Option<ElementId>; 4]],
    ) -> Self {
        assert_eq!(elements.len(), across.len(), "each element has its neighbours");
        let (alone, graph) = (Self::alone(elements.len()), ElementGraph::new(nodes, elements, across));
        if D == 2 { alone.paired(&graph) } else { alone.quadrupled(&graph, &rings::rings(elements, across, &graph)) }
    }

    /// Joins single elements into pairs that share a facet; elements without a partner stay alone.
    fn paired<const D: usize>(&self, graph: &ElementGraph<D>) -> Self {
        self.joined(&matching::match_groups(graph, vec![None; self.len()]))
    }

    /// Joins single elements into rings of four, then into pairs of pairs; the rest stay in groups of one to three.
    fn quadrupled<const D: usize>(&self, graph: &ElementGraph<D>, rings: &[EdgeRing]) -> Self {
        let mut mates = vec![None; self.len()];
        for &[a, b, c, d] in rings {
            matching::set_mates(&mut mates, a, b);
            matching::set_mates(&mut mates, c, d);
        }
        let pairs = self.joined(&matching::match_groups(graph, mates));
        let patch = pairs.patch_of_elements();
        let mut mates = vec![None; pairs.len()];
        for [a, b, c, d] in rings.iter().map(|ring| ring.map(|e| patch[e.index()])) {
            if a == b && c == d {
                matching::set_mates(&mut mates, a, c);
            }
        }
        pairs.joined(&matching::match_groups(&graph.contracted(&pairs, &patch), mates))
    }

    /// Number of patches.
    #[must_use]
    pub fn len(&self) -> usize {
        if self.start.is_empty() { self.members.len() } else { self.start.len() - 1 }
    }

    /// Returns true if there are no patches.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Elements of a patch.
    #[must_use]
    pub fn of(&self, patch: usize) -> &[ElementId] {
        match self.start.get(patch..patch + 2) {
            Some(ends) => &self.members[ends[0] as usize..ends[1] as usize],
            None => std::slice::from_ref(&self.members[patch]),
        }
    }

    /// Iterates over the patches; each item is the elements of one patch.
    pub fn iter(&self) -> impl Iterator<Item = &[ElementId]> {
        (0..self.len()).map(|p| self.of(p))
    }

    /// Number of elements in the largest patch.
    #[must_use]
    pub fn largest(&self) -> usize {
        self.iter().map(<[ElementId]>::len).max().unwrap_or(0)
    }

    /// Returns the mesh with the elements of each patch contiguous, patch by patch, and the patches of that mesh.
    #[must_use]
    pub fn made_contiguous<const D: usize>(self, mesh: Mesh<D>) -> (Mesh<D>, Self) {
        let mesh = mesh.reordered(&self.members);
        let members = (0..self.members.len() as u32).map(ElementId).collect();
        (mesh, Self { start: self.start, members })
    }

    /// Patch of each element.
    #[must_use]
    pub fn patch_of_elements(&self) -> Vec<ElementId> {
        let mut patch = vec![ElementId(0); self.members.len()];
        for (p, elements) in (0..).map(ElementId).zip(self.iter()) {
            for element in elements {
                patch[element.index()] = p;
            }
        }
        patch
    }

    /// Groups elements by the numbers of their patches; `None` unless the patches are numbered by their first elements and
    /// no patch has more elements or nodes than [`ElementPatches::grouped`] would give it.
    #[must_use]
    pub fn of_elements<const D: usize>(elements: &[Simplex], patch: &[u32]) -> Option<Self> {
        let mut next = 0;
        let is_next = |patch: &u32| {
            *patch < next || {
                next += 1;
                *patch + 1 == next
            }
        };
        if patch.len() != elements.len() || !patch.iter().all(is_next) {
            return None;
        }
        let patches = Self::of_labels(patch);
        let (most_elements, most_nodes) = if D == 2 { (2, 4) } else { (4, 7) };
        let is_small = |patch: &[ElementId]| {
            let mut nodes: Vec<_> = patch.iter().flat_map(|element| &elements[element.index()][..=D]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            patch.len() <= most_elements && nodes.len() <= most_nodes
        };
        let all_are_small = patches.iter().all(is_small);
        all_are_small.then_some(patches)
    }

    /// Groups the elements that have the same label.
    #[must_use]
    pub fn of_labels(labels: &[u32]) -> Self {
        let (mut number, mut size): (Vec<Option<u32>>, Vec<u32>) = (vec![], vec![]);
        number.resize(labels.iter().max().map_or(0, |most| *most as usize + 1), None);
        for label in labels {
            let patch = *number[*label as usize].get_or_insert(size.len() as u32) as usize;
            size.resize(size.len().max(patch + 1), 0);
            size[patch] += 1;
        }
        if size.len() == labels.len() {
            return Self::alone(labels.len());
        }
        let start: Vec<u32> = std::iter::once(0).chain(size.iter().scan(0, |sum, n| Some(add_to(sum, *n)))).collect();
        let (mut next, mut members) = (start.clone(), vec![ElementId(0); labels.len()]);
        for (element, label) in (0..).map(ElementId).zip(labels) {
            let patch = number[*label as usize].unwrap_or_default() as usize;
            members[next[patch] as usize] = element;
            next[patch] += 1;
        }
        Self { start, members }
    }

    /// Restricts the patches to the elements `kept`, ascending, which are renumbered in that order; empty patches are
    /// dropped.
    #[must_use]
    pub fn restricted_to(&self, kept: &[ElementId]) -> Self {
        let patch = self.patch_of_elements();
        Self::of_labels(&kept.iter().map(|element| patch[element.index()].0).collect::<Vec<_>>())
    }

    /// Joins each patch with its mate. Patches must be ordered by their first elements.
    fn joined(&self, mates: &[Option<ElementId>]) -> Self {
        let mut joined = Self { start: vec![0], members: Vec::with_capacity(self.members.len()) };
        for (p, mate) in (0..).map(ElementId).zip(mates) {
            if mate.is_some_and(|mate| mate < p) {
                continue;
            }
            let first = joined.members.len();
            joined.members.extend_from_slice(self.of(p.index()));
            joined.members.extend(mate.iter().flat_map(|&mate| self.of(mate.index())));
            joined.members[first..].sort_unstable();
            joined.start.push(joined.members.len() as u32);
        }
        joined
    }
}

/// Adds to a sum and returns it.
fn add_to(sum: &mut u32, n: u32) -> u32 {
    *sum += n;
    *sum
}
