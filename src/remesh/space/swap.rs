//! Edge removal and face flips: other tetrahedra between the same points.

use super::edge_star::EdgeStar;
use super::surface_criteria::SurfaceCriteria;
use super::tet_mesh::{MeshOperation, TetMesh, Tetrahedron};
use crate::mesh::FACES;

/// Greatest number of points around an edge that is removed.
const MOST: usize = 9;

/// Optimal triangulation of the polygon around an edge: the worst tetrahedron with either end is best. Dynamic
/// programming over parts of the polygon (Klincsek 1980).
struct SwapTable {
    /// Worst shape and point between, by first and last point of a part.
    best: [[(f64, usize); MOST]; MOST],
}

impl SwapTable {
    fn of(complex: &TetMesh, edge: (u32, u32), points: &[u32]) -> Self {
        let mut table = Self { best: [[(f64::INFINITY, 0); MOST]; MOST] };
        for width in 2..points.len() {
            for first in 0..points.len() - width {
                table.best[first][first + width] = table.part(complex, edge, (points, first, first + width));
            }
        }
        table
    }

    /// Best triangles of a part of the polygon, given those of its own parts.
    fn part(&self, complex: &TetMesh, edge: (u32, u32), (points, first, last): (&[u32], usize, usize)) -> (f64, usize) {
        (first + 1..last).fold((f64::NEG_INFINITY, first + 1), |found, middle| {
            let parts = self.best[first][middle].0.min(self.best[middle][last].0);
            let both = ends(edge, [first, middle, last].map(|k| points[k]));
            let worst = if parts > found.0 { parts.min(complex.worst_new(&both, found.0)) } else { found.0 };
            if worst > found.0 { (worst, middle) } else { found }
        })
    }

    fn collect(&self, edge: (u32, u32), points: &[u32], (first, last): (usize, usize), new: &mut Vec<Tetrahedron>) {
        if last - first < 2 {
            return;
        }
        let middle = self.best[first][last].1;
        new.extend(ends(edge, [first, middle, last].map(|k| points[k])));
        self.collect(edge, points, (first, middle), new);
        self.collect(edge, points, (middle, last), new);
    }
}

/// Tetrahedra above and below a triangle that is counter-clockwise around the edge.
fn ends((a, b): (u32, u32), [p, q, r]: [u32; 3]) -> [Tetrahedron; 2] {
    [[p, q, r, b], [p, r, q, a]]
}

/// Removes an edge if all new tetrahedra are better than `enough`; returns their quality and the operation. At the
/// surface only where it is flat and no loaded face may end.
pub(super) fn remove_edge(
    complex: &TetMesh,
    (a, b): (u32, u32),
    enough: f64,
    flat: &SurfaceCriteria<'_>,
) -> Option<(f64, MeshOperation)> {
    let ring = EdgeStar::of(complex, a, b)?;
    let n = ring.points.len();
    let [first, last] = [ring.points[0], ring.points[n - 1]];
    if !(3..=MOST).contains(&n) {
        return None;
    }
    let is_end = complex.points[a as usize].ends & complex.points[b as usize].ends != 0;
    if ring.is_open && (is_end || !flat.can_flip_edge(complex, (a, b), (first, last))) {
        return None;
    }
    let table = SwapTable::of(complex, (a, b), &ring.points);
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
    let change = MeshOperation { gone: ring.tets, new, swept, moved: None };
    // The volume of held points is not returned elsewhere.
    let is_held = [a, b].iter().all(|p| complex.points[*p as usize].held.contains(&true));
    let points: &[u32] = if is_held { &[] } else { &[first, last, a, b] };
    flat.correct_volume(complex, (worst, change), (points, enough))
}

/// Returns true if an edge or triangle across the star, each between two of the tetrahedra in `new`, exists already
/// elsewhere: in a mesh that overlaps itself.
fn is_there_already(complex: &TetMesh, ring: &EdgeStar, new: &[Tetrahedron]) -> bool {
    let is_face = |[p, q, r]: [u32; 3]| complex.star(p).any(|(_, tet)| tet.contains(&q) && tet.contains(&r));
    let is_edge = |[p, q]: [u32; 2]| ring.is_chord([p, q]) && are_joined(complex, p, q);
    new.iter()
        .step_by(2)
        .any(|[p, q, r, _]| is_face([*p, *q, *r]) || [[*p, *q], [*q, *r], [*r, *p]].map(is_edge).contains(&true))
}

/// Replaces a face between two tetrahedra by an edge (2–3 flip) if the three new tetrahedra are better than `enough`.
pub(super) fn flip_face(complex: &TetMesh, (t, k): (u32, usize), enough: f64) -> Option<(f64, MeshOperation)> {
    let tet = complex.tet(t)?;
    // Counter-clockwise seen from the opposite corner.
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
    (worst > enough)
        .then(|| (worst, MeshOperation { gone: vec![t, other], new: new.to_vec(), ..MeshOperation::default() }))
}

/// Returns true if two points are joined by an edge.
pub(super) fn are_joined(complex: &TetMesh, a: u32, b: u32) -> bool {
    complex.star(a).any(|(_, tet)| tet.contains(&b))
}

#[cfg(test)]
mod tests {
    use super::super::tests::around_an_edge;
    use super::*;

    #[test]
    fn no_edge_and_no_triangle_comes_that_is_there_already() {
        let flat = SurfaceCriteria { sag: 0.0, slide: 0.0, planes: true, volume: 0.0, swept: 0.0, cleared: None };
        let taken = |n: u32, more: &[Tetrahedron]| remove_edge(&around_an_edge(n, more), (n, n + 1), 0.0, &flat);
        let (_, change) = taken(4, &[]).unwrap();
        assert!(change.new.iter().all(|tet| tet.contains(&0) && tet.contains(&2)), "by the shorter diagonal");
        assert!(taken(4, &[[0, 2, 6, 7]]).is_none() && taken(4, &[[3, 2, 6, 7]]).is_some());
        assert!(taken(3, &[]).is_some() && taken(3, &[[0, 1, 2, 5]]).is_none());
    }
}
