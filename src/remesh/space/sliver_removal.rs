//! Removal of slivers at the surface where no other operation improves them.

use super::edge_star::EdgeStar;
use super::limits::{EDGES, cube};
use super::tet_mesh::{TetMesh, Tetrahedron};

/// Quality up to which a tetrahedron is a sliver: a third of that which counts as distorted.
const FLAT: f64 = 0.1;
/// Greatest volume that is cut off, in cubes of the target length.
const THIN: f64 = 0.01;

/// Returns true if a tetrahedron is a removable sliver: its two surface facets share an edge of no other element, and
/// the opposite edge is interior, so that the cut preserves the topology. Where two held planes meet nothing is
/// removed.
pub(super) fn is_removable_sliver(complex: &TetMesh, (t, tet): (u32, &Tetrahedron)) -> bool {
    let size = tet.iter().map(|p| complex.points[*p as usize].size).fold(f64::INFINITY, f64::min);
    let is_thin = complex.growth(&[*tet], &[]).abs() <= THIN * size * size * size;
    complex.shape(t) <= cube(FLAT) && is_thin && EDGES.iter().any(|edge| is_bare(complex, tet, *edge))
}

fn is_bare(complex: &TetMesh, tet: &Tetrahedron, [i, j]: [usize; 2]) -> bool {
    let [a, b] = [tet[i], tet[j]];
    let alone = complex.star(a).filter(|(_, other)| other.contains(&b)).count() == 1;
    let [p, q] = [a, b].map(|point| &complex.points[point as usize]);
    let held = (0..3).filter(|axis| p.held[*axis] && q.held[*axis]).count();
    if !alone || held > 1 || p.ends & q.ends != 0 {
        return false;
    }
    let mut others = tet.iter().filter(|point| **point != a && **point != b);
    let [Some(c), Some(d)] = [others.next(), others.next()] else { return false };
    EdgeStar::of(complex, *c, *d).is_some_and(|ring| !ring.is_open)
}
