//! What of a triangulation is inside: an odd number of edges away from the far field.

use super::delaunay::{Triangle, Triangles};
use spade::Triangulation;

/// The triangles that an odd number of constraint edges separates from the outside, in the order of the triangulation.
pub(super) fn inside(triangles: &Triangles) -> impl Iterator<Item = Triangle<'_>> {
    let mut parity = vec![None; triangles.num_all_faces()];
    let mut open = vec![];
    for edge in triangles.convex_hull() {
        // An edge of the hull has the far field on its left.
        let face = edge.rev().face();
        if parity[face.index()].replace(edge.as_undirected().is_constraint_edge()).is_none() {
            open.push(face);
        }
    }
    while let Some(face) = open.pop().and_then(|face| face.as_inner()) {
        let is_inside = parity[face.index()] == Some(true);
        for edge in face.adjacent_edges() {
            let next = edge.rev().face();
            if !next.is_outer() && parity[next.index()].is_none() {
                parity[next.index()] = Some(is_inside != edge.as_undirected().is_constraint_edge());
                open.push(next);
            }
        }
    }
    triangles.inner_faces().filter(move |face| parity[face.index()] == Some(true))
}
