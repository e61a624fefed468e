//! Carving of a triangulation: removal of the triangles outside the body.

use super::delaunay::{SiteTriangulation, TriangleFace};
use spade::Triangulation;

/// Iterates over the triangles inside the body: an odd number of constraint edges separates them from the outside.
pub(super) fn inside_triangles(triangles: &SiteTriangulation) -> impl Iterator<Item = TriangleFace<'_>> {
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
