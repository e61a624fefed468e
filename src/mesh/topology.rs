//! Connectivity of a mesh: boundary, face neighbours and node incidence. Positions are never read.

use super::{ElementId, Facet, NodeId, Simplex};

/// Boundary facets: those of one element only, in the order of the elements, outward oriented.
#[must_use]
pub fn boundary<const D: usize>(elements: &[Simplex]) -> Vec<Facet> {
    let sides = element_sides::<D>(elements);
    let mut outer: Vec<u32> =
        sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0].1).collect();
    outer.sort_unstable();
    outer.into_iter().map(|side| facet::<D>(&elements[side as usize / 4], side as usize % 4)).collect()
}

/// Boundary facets where the face neighbours are known; equal to [`boundary`].
#[must_use]
pub fn boundary_from_neighbours<const D: usize>(elements: &[Simplex], across: &[[Option<ElementId>; 4]]) -> Vec<Facet> {
    let bare = |(simplex, across): (&'_ Simplex, &'_ [Option<ElementId>; 4])| {
        let (simplex, across) = (*simplex, *across);
        (0..=D).filter(move |k| across[*k].is_none()).map(move |k| facet::<D>(&simplex, k))
    };
    elements.iter().zip(across).flat_map(bare).collect()
}

/// Lists the sides of all elements as (sorted facet, 4 × element + opposite node); equal facets are adjacent.
fn element_sides<const D: usize>(elements: &[Simplex]) -> Vec<(Facet, u32)> {
    let of = |(e, simplex)| (0..=D).map(move |k| (sorted::<D>(facet::<D>(simplex, k)), (4 * e + k) as u32));
    sort_by_bucket(&|| elements.iter().enumerate().flat_map(of), |side: &(Facet, u32)| side.0[0].index())
}

/// Sorts items by a leading integer key: a counting sort into buckets, then a comparison sort within each bucket.
///
/// # Panics
/// Unless `all` yields the same items at each call.
fn sort_by_bucket<T: Copy + Default + Ord, I: Iterator<Item = T>>(
    all: &dyn Fn() -> I,
    number: impl Fn(&T) -> usize,
) -> Vec<T> {
    let mut ends: Vec<u32> = vec![];
    for one in all() {
        let number = number(&one);
        ends.resize(ends.len().max(number + 1), 0);
        ends[number] += 1;
    }
    let mut first = 0;
    for end in &mut ends {
        (first, *end) = (first + *end, first);
    }
    let mut sorted = vec![T::default(); first as usize];
    for one in all() {
        let place = &mut ends[number(&one)];
        sorted[*place as usize] = one;
        *place += 1;
    }
    sorted.chunk_by_mut(|a, b| number(a) == number(b)).for_each(<[T]>::sort_unstable);
    sorted
}

/// Corners of the tetrahedron face opposite each corner, outward oriented.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Facet of a positively oriented simplex opposite one of its nodes, outward oriented.
pub(crate) fn facet<const D: usize>(simplex: &Simplex, opposite: usize) -> Facet {
    let facets: &[[usize; 3]] = match D {
        2 => &[[1, 2, 2], [2, 0, 0], [0, 1, 1]],
        _ => &FACES,
    };
    facets[opposite].map(|corner| simplex[corner])
}

/// Canonical form of a facet: its nodes in ascending order, independent of start and orientation.
pub(crate) fn sorted<const D: usize>(facet: Facet) -> Facet {
    let mut key = facet;
    key[..D].sort_unstable();
    if D == 2 {
        key[2] = key[1];
    }
    key
}

/// Face neighbours: the element across the facet opposite each node; none at the boundary.
#[must_use]
pub fn face_neighbours<const D: usize>(elements: &[Simplex]) -> Vec<[Option<ElementId>; 4]> {
    let mut across = vec![[None; 4]; elements.len()];
    for pair in element_sides::<D>(elements).chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 2) {
        let [(e, i), (f, j)] = [pair[0], pair[1]].map(|(_, side)| (side / 4, side as usize % 4));
        across[e as usize][i] = Some(ElementId(f));
        across[f as usize][j] = Some(ElementId(e));
    }
    across
}

/// Node incidence in compressed rows: the groups (elements, facets) that contain each node, in ascending order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeIncidence {
    start: Vec<u32>,
    members: Vec<ElementId>,
}

impl NodeIncidence {
    /// Builds the incidence of `n_nodes` nodes from the nodes of each group.
    pub fn new<'a>(n_nodes: usize, groups: impl Iterator<Item = &'a [NodeId]> + Clone) -> Self {
        let mut start = vec![0_u32; n_nodes + 1];
        for node in groups.clone().flatten() {
            start[node.index() + 1] += 1;
        }
        for i in 0..n_nodes {
            start[i + 1] += start[i];
        }
        let mut fill = start.clone();
        let mut members = vec![ElementId(0); start[n_nodes] as usize];
        for (id, group) in groups.enumerate() {
            for node in group {
                members[fill[node.index()] as usize] = ElementId(id as u32);
                fill[node.index()] += 1;
            }
        }
        Self { start, members }
    }

    /// Groups that contain a node.
    #[must_use]
    #[inline]
    pub fn of(&self, node: NodeId) -> &[ElementId] {
        &self.members[self.start[node.index()] as usize..self.start[node.index() + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_tetrahedra_share_one_face() {
        let ids = |a: [u32; 4]| a.map(NodeId);
        let elements = [ids([0, 1, 2, 3]), ids([1, 2, 3, 4])];
        let facets = boundary::<3>(&elements);
        assert_eq!(facets.len(), 6);
        assert!(!facets.iter().any(|f| sorted::<3>(*f) == [NodeId(1), NodeId(2), NodeId(3)]));
        assert_eq!(
            face_neighbours::<3>(&elements),
            [[Some(ElementId(1)), None, None, None], [None, None, None, Some(ElementId(0))]]
        );
        let star = NodeIncidence::new(5, elements.iter().map(|e| &e[..]));
        assert_eq!(star.of(NodeId(0)), [ElementId(0)]);
        assert_eq!(star.of(NodeId(3)), [ElementId(0), ElementId(1)]);
    }
}
