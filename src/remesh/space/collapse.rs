//! Edge collapse.

use super::edge_star::{EdgeStar, fan};
use super::limits::EDGES;
use super::surface_criteria::SurfaceCriteria;
use super::tet_mesh::{MeshOperation, TetMesh, Tetrahedron};

/// Collapses point `a` onto point `b` if all new tetrahedra are better than `enough`; returns their quality and the
/// operation.
///
/// A surface point moves along a flat surface only. Its target must be held in all directions in which it is held
/// itself, and a point at the end of a loaded face moves along that end. The link condition (Dey et al. 1999) forbids a
/// collapse that would weld the mesh. It concerns points with the edge and another neighbour in common but no
/// tetrahedron with all three. It also concerns points that face the same edge without a tetrahedron with both, and
/// points that the surface joins to a third one without a facet with all three.
pub(super) fn collapse_onto(
    complex: &TetMesh,
    (a, b): (u32, u32),
    enough: f64,
    flat: &SurfaceCriteria<'_>,
) -> Option<(f64, MeshOperation)> {
    let [from, to] = [a, b].map(|point| &complex.points[point as usize]);
    let is_held_less = (0..3).all(|axis| to.held[axis] || !from.held[axis]);
    let leaves_end = from.ends & !to.ends != 0;
    if !is_held_less || leaves_end || (from.is_on_surface && !to.is_on_surface) {
        return None;
    }
    let change = change(complex, (a, b), from.is_on_surface);
    let worst = complex.worst_new(&change.new, enough);
    if worst <= enough {
        return None;
    }
    let ring = EdgeStar::of(complex, a, b)?;
    let stays = !from.is_on_surface || (ring.is_open && flat.can_collapse(complex, a, b));
    let stays = stays && satisfies_link_condition(complex, (a, b), &ring) && !share_chord(complex, (a, b), &ring);
    // The volume of a held point is not returned elsewhere.
    let points: &[u32] = if from.held.contains(&true) { &[] } else { &[b] };
    stays.then(|| flat.correct_volume(complex, (worst, change), (points, enough))).flatten()
}

fn change(complex: &TetMesh, (a, b): (u32, u32), is_on_surface: bool) -> MeshOperation {
    let drawn = |tet: Tetrahedron| tet.map(|point| if point == a { b } else { point });
    let gone: Vec<u32> = complex.star(a).map(|(t, _)| t).collect();
    let new: Vec<Tetrahedron> =
        complex.star(a).filter(|(_, tet)| !tet.contains(&b)).map(|(_, tet)| drawn(tet)).collect();
    let swept = if is_on_surface { complex.growth(&new, &gone) } else { 0.0 };
    MeshOperation { gone, new, swept, moved: None }
}

/// Returns true if both ends face a chord of the edge star. New tetrahedra would be inverted there, unless the mesh
/// overlaps itself.
fn share_chord(complex: &TetMesh, (a, b): (u32, u32), ring: &EdgeStar) -> bool {
    let of = |end: u32| {
        let faced =
            move |tet: Tetrahedron| EDGES.map(|[i, j]| [tet[i], tet[j]]).into_iter().filter(move |e| !e.contains(&end));
        let chords = complex.star(end).flat_map(move |(_, tet)| faced(tet)).filter(|edge| ring.is_chord(*edge));
        chords.map(|[p, q]| [p.min(q), p.max(q)])
    };
    of(a).any(|chord| of(b).any(|other| other == chord))
}

/// Link condition: returns true if all common neighbours of both ends are on the edge star. Surface neighbours of both
/// must be the third points of the two facets of the edge. Where one end is held less than the other no further common
/// surface neighbour may exist: a facet might become part of a held face.
fn satisfies_link_condition(complex: &TetMesh, (a, b): (u32, u32), ring: &EdgeStar) -> bool {
    let ends = [ring.points[0], *ring.points.last().unwrap_or(&a)];
    let joined = if ring.is_open { [a, b].map(|point| fan(complex, point)) } else { [vec![], vec![]] };
    let welds = |p: &u32| joined.iter().all(|fan| fan.iter().any(|edge| edge.contains(p)));
    let alike = complex.points[a as usize].held == complex.points[b as usize].held;
    let is_free = |p: &u32| !complex.points[*p as usize].is_on_surface || (alike && !welds(p));
    let is_allowed = |p: &u32| ring.points.contains(p) && (!ring.is_open || ends.contains(p) || is_free(p));
    let mut next_to_a: Vec<u32> = complex.star(a).flat_map(|(_, tet)| tet).filter(|p| *p != a && *p != b).collect();
    next_to_a.sort_unstable();
    next_to_a.dedup();
    let mut next_to_b = complex.star(b).flat_map(|(_, tet)| tet).filter(|p| *p != a && *p != b);
    next_to_b.all(|p| next_to_a.binary_search(&p).is_err() || is_allowed(&p))
}

#[cfg(test)]
mod tests {
    use super::super::tests::around_an_edge;
    use super::*;

    #[test]
    fn an_edge_across_the_ring_that_both_ends_face_is_seen() {
        let shares = |more: &[Tetrahedron]| {
            let complex = around_an_edge(4, more);
            share_chord(&complex, (4, 5), &EdgeStar::of(&complex, 4, 5).unwrap())
        };
        assert!(!shares(&[]) && !shares(&[[4, 2, 0, 6]]));
        assert!(shares(&[[4, 2, 0, 6], [2, 5, 0, 7]]));
    }
}
