//! Star of an edge, and fan of a surface point.

use super::tet_mesh::{TetMesh, Tetrahedron};

/// Edge star: the tetrahedra around an edge in order. Each has two neighbours in the star; at the surface the two outer
/// ones have one.
#[derive(Debug, Clone)]
pub(super) struct EdgeStar {
    /// Tetrahedra in order around the edge from its first to its second end, counter-clockwise.
    pub tets: Vec<u32>,
    /// Points opposite the edge, in order; an open star has one more point than tetrahedra.
    pub points: Vec<u32>,
    /// True if the edge is on the surface.
    pub is_open: bool,
}

/// Other two points of a tetrahedron with this edge, counter-clockwise around it.
fn opposite(tet: &Tetrahedron, a: u32, b: u32) -> Option<[u32; 2]> {
    let i = tet.iter().position(|&point| point == a)?;
    let j = tet.iter().position(|&point| point == b)?;
    let mut rest = (0..4).filter(|k| *k != i && *k != j);
    let (k, l) = (rest.next()?, rest.next()?);
    // The tuple (i, j, k, l) is an even permutation of 0…3, or its last two entries are swapped.
    let inversions = [(i, j), (i, k), (i, l), (j, k), (j, l)].iter().filter(|(p, q)| p > q).count();
    Some(if inversions % 2 == 0 { [tet[k], tet[l]] } else { [tet[l], tet[k]] })
}

impl EdgeStar {
    /// Builds the star of an edge, if the edge exists and its tetrahedra form one fan.
    pub fn of(complex: &TetMesh, a: u32, b: u32) -> Option<Self> {
        let sides: Vec<(u32, [u32; 2])> =
            complex.star(a).filter_map(|(t, tet)| Some((t, opposite(&tet, a, b)?))).collect();
        let is_end = |side: &&(u32, [u32; 2])| !sides.iter().any(|(_, [_, q])| *q == side.1[0]);
        let open = sides.iter().find(is_end);
        let first = open.or(sides.first())?.1[0];
        let mut ring = Self { tets: vec![], points: vec![first], is_open: open.is_some() };
        let mut last = first;
        while ring.tets.len() < sides.len() {
            let (t, [_, next]) = sides.iter().find(|(_, [p, _])| *p == last)?;
            ring.tets.push(*t);
            last = *next;
            if last == first {
                break;
            }
            ring.points.push(last);
        }
        let is_whole = ring.tets.len() == sides.len() && (last == first) != ring.is_open;
        is_whole.then_some(ring)
    }

    /// Returns true if an edge joins two non-adjacent points of the star.
    pub fn is_chord(&self, [p, q]: [u32; 2]) -> bool {
        let place = |point| self.points.iter().position(|other| *other == point);
        let (Some(p), Some(q)) = (place(p), place(q)) else { return false };
        let apart = p.abs_diff(q);
        apart > 1 && (self.is_open || apart + 1 < self.points.len())
    }
}

/// Surface facets around a point, by their other two points, outward oriented.
pub(super) fn fan(complex: &TetMesh, a: u32) -> Vec<[u32; 2]> {
    let mut sides: Vec<([u32; 2], [u32; 2])> = vec![];
    for (_, tet) in complex.star(a) {
        for &b in tet.iter().filter(|&&b| b != a) {
            // Seen from b the other two stand clockwise about the facet's outward normal: (a, q, p) with b inside.
            let Some([p, q]) = opposite(&tet, a, b) else { continue };
            sides.push(([p.min(q), p.max(q)], [q, p]));
        }
    }
    sides.sort_unstable();
    sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0].1).collect()
}
