//! Other tetrahedra between the same points: an edge or a face is taken out and what was around it joined anew.

use super::edge_star::Ring;
use super::surface_criteria::Flat;
use super::tet_mesh::{Change, Complex, Tet};
use crate::mesh::FACES;

/// The most points around an edge that is taken out.
const MOST: usize = 9;

/// The best triangles between the points of a ring: those whose worst tetrahedron with either end of the edge is best.
/// Found for every part of the ring from smaller parts (Klincsek 1980).
struct Table {
    /// By first and last point of a part of the ring: its worst shape, and the point between.
    best: [[(f64, usize); MOST]; MOST],
}

impl Table {
    fn of(complex: &Complex, edge: (u32, u32), points: &[u32]) -> Self {
        let mut table = Self { best: [[(f64::INFINITY, 0); MOST]; MOST] };
        for width in 2..points.len() {
            for first in 0..points.len() - width {
                table.best[first][first + width] = table.part(complex, edge, (points, first, first + width));
            }
        }
        table
    }

    /// The best triangles of a part of the ring, those of its own parts being known.
    fn part(&self, complex: &Complex, edge: (u32, u32), (points, first, last): (&[u32], usize, usize)) -> (f64, usize) {
        (first + 1..last).fold((f64::NEG_INFINITY, first + 1), |found, middle| {
            let parts = self.best[first][middle].0.min(self.best[middle][last].0);
            let both = ends(edge, [first, middle, last].map(|k| points[k]));
            let worst = if parts > found.0 { parts.min(complex.worst_new(&both, found.0)) } else { found.0 };
            if worst > found.0 { (worst, middle) } else { found }
        })
    }

    fn collect(&self, edge: (u32, u32), points: &[u32], (first, last): (usize, usize), new: &mut Vec<Tet>) {
        if last - first < 2 {
            return;
        }
        let middle = self.best[first][last].1;
        new.extend(ends(edge, [first, middle, last].map(|k| points[k])));
        self.collect(edge, points, (first, middle), new);
        self.collect(edge, points, (middle, last), new);
    }
}

/// The tetrahedra over and under a triangle that is counter-clockwise around the edge.
fn ends((a, b): (u32, u32), [p, q, r]: [u32; 3]) -> [Tet; 2] {
    [[p, q, r, b], [p, r, q, a]]
}

/// Takes an edge out, if what comes is better than `enough`; and how good it is. At the surface only where that is flat
/// and no loaded face may end.
pub(super) fn without_edge(
    complex: &Complex,
    (a, b): (u32, u32),
    enough: f64,
    flat: &Flat<'_>,
) -> Option<(f64, Change)> {
    let ring = Ring::of(complex, a, b)?;
    let n = ring.points.len();
    let [first, last] = [ring.points[0], ring.points[n - 1]];
    if !(3..=MOST).contains(&n) {
        return None;
    }
    let is_end = complex.points[a as usize].ends & complex.points[b as usize].ends != 0;
    if ring.is_open && (is_end || !flat.turns(complex, (a, b), (first, last))) {
        return None;
    }
    let table = Table::of(complex, (a, b), &ring.points);
    let worst = table.best[0][n - 1].0;
    if worst <= enough {
        return None;
    }
    let mut new = vec![];
    table.collect((a, b), &ring.points, (0, n - 1), &mut new);
    if is_there_already(complex, &ring, &new) {
        return None;
    }
    let swept = if ring.is_open { complex.growth(&new, &ring.tets) } else { 0.0 };
    let change = Change { gone: ring.tets, new, swept, moved: None };
    // What is held does not shrink: its volume is not given back elsewhere.
    let is_held = [a, b].iter().all(|p| complex.points[*p as usize].held.contains(&true));
    let points: &[u32] = if is_held { &[] } else { &[first, last, a, b] };
    flat.level(complex, (worst, change), (points, enough))
}

/// Whether there is already, beside the ring, an edge or a triangle of those that come across it, each between two of the tetrahedra
/// in `new`: in a mesh that lies over itself.
fn is_there_already(complex: &Complex, ring: &Ring, new: &[Tet]) -> bool {
    let is_face = |[p, q, r]: [u32; 3]| complex.star(p).any(|(_, tet)| tet.contains(&q) && tet.contains(&r));
    let is_edge = |[p, q]: [u32; 2]| ring.is_chord([p, q]) && are_joined(complex, p, q);
    new.iter()
        .step_by(2)
        .any(|[p, q, r, _]| is_face([*p, *q, *r]) || [[*p, *q], [*q, *r], [*r, *p]].map(is_edge).contains(&true))
}

/// Puts an edge in the place of a face between two tetrahedra, if the three that come are better than `enough`.
pub(super) fn without_face(complex: &Complex, (t, k): (u32, usize), enough: f64) -> Option<(f64, Change)> {
    let tet = complex.tet(t)?;
    // Counter-clockwise seen from the corner opposite.
    let [a, c, b] = FACES[k].map(|corner| tet[corner]);
    let above = tet[k];
    let (other, below) = complex.star(a).find_map(|(other, nodes)| {
        let shares = other != t && nodes.contains(&b) && nodes.contains(&c);
        Some((other, *nodes.iter().find(|p| ![a, b, c].contains(p))?)).filter(|_| shares)
    })?;
    if are_joined(complex, above, below) {
        return None;
    }
    let new = [[below, above, a, b], [below, above, b, c], [below, above, c, a]];
    let worst = complex.worst_new(&new, enough);
    (worst > enough).then(|| (worst, Change { gone: vec![t, other], new: new.to_vec(), ..Change::default() }))
}

/// Whether two points have an edge.
pub(super) fn are_joined(complex: &Complex, a: u32, b: u32) -> bool {
    complex.star(a).any(|(_, tet)| tet.contains(&b))
}

#[cfg(test)]
mod tests {
    use super::super::tests::around_an_edge;
    use super::*;

    #[test]
    fn no_edge_and_no_triangle_comes_that_is_there_already() {
        let flat = Flat { sag: 0.0, slide: 0.0, planes: true, volume: 0.0, swept: 0.0, cleared: None };
        let taken = |n: u32, more: &[Tet]| without_edge(&around_an_edge(n, more), (n, n + 1), 0.0, &flat);
        let (_, change) = taken(4, &[]).unwrap();
        assert!(change.new.iter().all(|tet| tet.contains(&0) && tet.contains(&2)), "by the shorter diagonal");
        assert!(taken(4, &[[0, 2, 6, 7]]).is_none() && taken(4, &[[3, 2, 6, 7]]).is_some());
        assert!(taken(3, &[]).is_some() && taken(3, &[[0, 1, 2, 5]]).is_none());
    }
}
