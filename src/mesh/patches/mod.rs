//! Disjoint patches of elements that share one volume change (numerics 5).
//!
//! A linear triangle or tetrahedron has its own volume to keep, which near incompressibility is more than the nodes can
//! follow: it locks. Where a few neighbours keep their common volume instead, it does not: two triangles, or four tetrahedra.
//! Which ones is a matching: groups that share facets are joined two by two, at most one join to a group, so that few are
//! left over and the joined shapes are compact; once in the plane, twice in space. There the rings of four tetrahedra around
//! an edge go first: those of the centred lattice are its octahedra, and elsewhere too pressure is smoother with them.
//!
//! A punch on a quarter of a clamped block (linear, N = 16 cells per edge) at ν = 0.4999, the force over that of nodal
//! averaging: pairs 0.97–1.00 and plain triangles 1.00–2.28 on crossed, Kuhn's, displaced and random Delaunay triangles;
//! fours 0.986–1.011 and plain tetrahedra 1.19–3.31 on the centred and Kuhn's lattice, displaced or not, and on random
//! Delaunay tetrahedra, of which 99 % are in fours. Pairs of tetrahedra still lock, by 7 to 81 %.

mod element_graph;
mod matching;
mod rings;

use super::{ElementId, Mesh, Simplex, neighbours};
use crate::math::Vector;
use element_graph::Dual;
use rings::Ring;

/// Disjoint patches of elements: every element is in one of them.
///
/// Patches stand in the order of their first elements, elements in a patch in ascending order, so that what is near in the
/// mesh's own order stays near.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patches {
    /// Patch p is `members[start[p]..start[p + 1]]`; nothing where patch p is element p.
    start: Vec<u32>,
    members: Vec<ElementId>,
}

impl Patches {
    /// Each element by itself.
    #[must_use]
    pub fn alone(n_elements: usize) -> Self {
        let n = n_elements as u32;
        Self { start: vec![], members: (0..n).map(ElementId).collect() }
    }

    /// What keeps a mesh from locking: pairs in the plane, groups of up to four elements in space; what finds no partner
    /// stays in smaller ones. The elements of a patch are connected through facets, so it has at most 4 nodes in the plane
    /// and 7 in space.
    ///
    /// ```
    /// use ballistic_gel::mesh::{Block, ElementId, Patches, Split, block, uniform};
    ///
    /// let axis = || uniform(0.0, 1.0, 0.5);
    /// let mesh = block(Block { planes: [axis(), axis(), axis()], split: Split::Centred, faces: vec![] });
    /// let patches = Patches::grouped(&mesh);
    /// assert!(patches.iter().all(|elements| elements.len() == 4));
    /// ```
    #[must_use]
    pub fn grouped<const D: usize>(mesh: &Mesh<D>) -> Self {
        Self::among((&mesh.rest, &mesh.elements), &neighbours::<D>(&mesh.elements))
    }

    /// The same of elements between nodes there, where the neighbours are known.
    ///
    /// # Panics
    /// Unless they are those of so many elements.
    #[must_use]
    pub fn among<const D: usize>(
        (nodes, elements): (&[Vector<D>], &[Simplex]),
        across: &[[Option<ElementId>; 4]],
    ) -> Self {
        assert_eq!(elements.len(), across.len(), "each element has its neighbours");
        let (alone, dual) = (Self::alone(elements.len()), Dual::new((nodes, elements), across));
        if D == 2 { alone.paired(&dual) } else { alone.quadrupled(&dual, &rings::rings(elements, across, &dual)) }
    }

    /// Of single elements pairs that share a facet; what finds no partner stays alone.
    fn paired<const D: usize>(&self, dual: &Dual<D>) -> Self {
        self.joined(&matching::pair(dual, vec![None; self.len()]))
    }

    /// Of single elements rings of four, then pairs of pairs; what is left over stays in groups of one to three.
    fn quadrupled<const D: usize>(&self, dual: &Dual<D>, rings: &[Ring]) -> Self {
        let mut mates = vec![None; self.len()];
        for &[a, b, c, d] in rings {
            matching::marry(&mut mates, a, b);
            matching::marry(&mut mates, c, d);
        }
        let pairs = self.joined(&matching::pair(dual, mates));
        let patch = pairs.patch_of_elements();
        let mut mates = vec![None; pairs.len()];
        for [a, b, c, d] in rings.iter().map(|ring| ring.map(|e| patch[e.index()])) {
            if a == b && c == d {
                matching::marry(&mut mates, a, c);
            }
        }
        pairs.joined(&matching::pair(&dual.joined(&pairs, &patch), mates))
    }

    /// Number of patches.
    #[must_use]
    pub fn len(&self) -> usize {
        if self.start.is_empty() { self.members.len() } else { self.start.len() - 1 }
    }

    /// Whether there are no patches.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The elements of a patch.
    #[must_use]
    pub fn of(&self, patch: usize) -> &[ElementId] {
        match self.start.get(patch..patch + 2) {
            Some(ends) => &self.members[ends[0] as usize..ends[1] as usize],
            None => std::slice::from_ref(&self.members[patch]),
        }
    }

    /// The elements of each patch.
    pub fn iter(&self) -> impl Iterator<Item = &[ElementId]> {
        (0..self.len()).map(|p| self.of(p))
    }

    /// Elements of the largest patch.
    #[must_use]
    pub fn largest(&self) -> usize {
        self.iter().map(<[ElementId]>::len).max().unwrap_or(0)
    }

    /// The mesh with the elements of a patch one after another, patch by patch, and the patches of that mesh.
    #[must_use]
    pub fn gathered<const D: usize>(self, mesh: Mesh<D>) -> (Mesh<D>, Self) {
        let mesh = mesh.reordered(&self.members);
        let members = (0..self.members.len() as u32).map(ElementId).collect();
        (mesh, Self { start: self.start, members })
    }

    /// The patch that each element is in.
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

    /// What is left of each where only these elements, ascending, are left, numbered anew.
    #[must_use]
    pub fn left(&self, kept: &[ElementId]) -> Self {
        let patch = self.patch_of_elements();
        let mut of = vec![vec![]; self.len()];
        for (new, old) in (0..).map(ElementId).zip(kept) {
            of[patch[old.index()].index()].push(new);
        }
        of.retain(|elements| !elements.is_empty());
        of.sort_unstable();
        let mut left = Self { start: vec![0], members: Vec::with_capacity(kept.len()) };
        for elements in &of {
            left.members.extend(elements);
            left.start.push(left.members.len() as u32);
        }
        left
    }

    /// Patches with their mates; they must stand in the order of their first elements.
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
