//! What is around an edge, and around a point of the surface.

use super::tet_mesh::{Complex, Tet};

/// The tetrahedra around an edge in order: each has two neighbours on the ring, those at the surface one.
#[derive(Debug, Clone)]
pub(super) struct Ring {
    /// In order around the edge from its first to its second end, counter-clockwise.
    pub tets: Vec<u32>,
    /// The points opposite the edge, in order; of an open ring one more than tetrahedra.
    pub points: Vec<u32>,
    /// Whether the edge is on the surface.
    pub is_open: bool,
}

/// The other two points of a tetrahedron with this edge, counter-clockwise around it.
fn opposite(tet: &Tet, a: u32, b: u32) -> Option<[u32; 2]> {
    let i = tet.iter().position(|&point| point == a)?;
    let j = tet.iter().position(|&point| point == b)?;
    let mut rest = (0..4).filter(|k| *k != i && *k != j);
    let (k, l) = (rest.next()?, rest.next()?);
    // (i, j, k, l) is an even permutation of 0…3 or its last two change places.
    let inversions = [(i, j), (i, k), (i, l), (j, k), (j, l)].iter().filter(|(p, q)| p > q).count();
    Some(if inversions % 2 == 0 { [tet[k], tet[l]] } else { [tet[l], tet[k]] })
}

impl Ring {
    /// Around this edge, if it is one and its tetrahedra are one fan.
    pub fn of(complex: &Complex, a: u32, b: u32) -> Option<Self> {
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

    /// Whether an edge is between points of the ring that are not beside each other on it.
    pub fn is_chord(&self, [p, q]: [u32; 2]) -> bool {
        let place = |point| self.points.iter().position(|other| *other == point);
        let (Some(p), Some(q)) = (place(p), place(q)) else { return false };
        let apart = p.abs_diff(q);
        apart > 1 && (self.is_open || apart + 1 < self.points.len())
    }
}

/// The facets of the surface around a point, by their other two points, outward oriented.
pub(super) fn fan(complex: &Complex, a: u32) -> Vec<[u32; 2]> {
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
