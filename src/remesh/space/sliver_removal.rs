//! A flat tetrahedron at the surface is cut off, where nothing else makes it better.

use super::edge_star::Ring;
use super::tet_mesh::{Complex, Tet};
use super::{EDGES, cube};

/// What has no more than this quality is flat: a third of what wears a mesh.
const FLAT: f64 = 0.1;
/// The volume of what is cut off at most, in cubes of the target length.
const THIN: f64 = 0.01;

/// Whether a tetrahedron is flat, has two facets at the surface, whose edge belongs to no other, and a cut along its other two faces
/// leaves the body what it is: the edge opposite is inside. Where two held planes meet nothing is cut off.
pub(super) fn is_flat(complex: &Complex, (t, tet): (u32, &Tet)) -> bool {
    let size = tet.iter().map(|p| complex.points[*p as usize].size).fold(f64::INFINITY, f64::min);
    let is_thin = complex.growth(&[*tet], &[]).abs() <= THIN * size * size * size;
    complex.shape(t) <= cube(FLAT) && is_thin && EDGES.iter().any(|edge| is_bare(complex, tet, *edge))
}

fn is_bare(complex: &Complex, tet: &Tet, [i, j]: [usize; 2]) -> bool {
    let [a, b] = [tet[i], tet[j]];
    let alone = complex.star(a).filter(|(_, other)| other.contains(&b)).count() == 1;
    let [p, q] = [a, b].map(|point| &complex.points[point as usize]);
    let held = (0..3).filter(|axis| p.held[*axis] && q.held[*axis]).count();
    if !alone || held > 1 || p.ends & q.ends != 0 {
        return false;
    }
    let mut others = tet.iter().filter(|point| **point != a && **point != b);
    let [Some(c), Some(d)] = [others.next(), others.next()] else { return false };
    Ring::of(complex, *c, *d).is_some_and(|ring| !ring.is_open)
}
