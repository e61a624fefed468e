//! An edge is drawn together to one of its ends.

use super::EDGES;
use super::edge_star::{Ring, fan};
use super::surface_criteria::Flat;
use super::tet_mesh::{Change, Complex, Tet};

/// Draws point `a` to point `b`, if all that comes is better than `enough`; and how good it is.
///
/// A point of the surface goes along the surface only, where that is flat, and to a point that is held wherever it is held
/// itself, and along the end of a loaded face from there. Two points that have the edge and another neighbour in common, but no
/// tetrahedron with all three, would weld what is not one; so would two that face the same edge, but in no tetrahedron with both; and
/// so would two that the surface joins to a third one, but by no facet with all three (the link condition; Dey and others 1999).
pub(super) fn onto(complex: &Complex, (a, b): (u32, u32), enough: f64, flat: &Flat<'_>) -> Option<(f64, Change)> {
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
    let ring = Ring::of(complex, a, b)?;
    let stays = !from.is_on_surface || (ring.is_open && flat.spares(complex, a, b));
    let stays = stays && links_alike(complex, (a, b), &ring) && !share_chord(complex, (a, b), &ring);
    // What is held does not shrink: its volume is not given back elsewhere.
    let points: &[u32] = if from.held.contains(&true) { &[] } else { &[b] };
    stays.then(|| flat.level(complex, (worst, change), (points, enough))).flatten()
}

fn change(complex: &Complex, (a, b): (u32, u32), is_on_surface: bool) -> Change {
    let drawn = |tet: Tet| tet.map(|point| if point == a { b } else { point });
    let gone: Vec<u32> = complex.star(a).map(|(t, _)| t).collect();
    let new: Vec<Tet> = complex.star(a).filter(|(_, tet)| !tet.contains(&b)).map(|(_, tet)| drawn(tet)).collect();
    let swept = if is_on_surface { complex.growth(&new, &gone) } else { 0.0 };
    Change { gone, new, swept, moved: None }
}

/// Whether both ends face an edge across the ring. In a mesh that does not lie over itself what comes would be inside out then.
fn share_chord(complex: &Complex, (a, b): (u32, u32), ring: &Ring) -> bool {
    let of = |end: u32| {
        let faced = move |tet: Tet| EDGES.map(|[i, j]| [tet[i], tet[j]]).into_iter().filter(move |e| !e.contains(&end));
        let chords = complex.star(end).flat_map(move |(_, tet)| faced(tet)).filter(|edge| ring.is_chord(*edge));
        chords.map(|[p, q]| [p.min(q), p.max(q)])
    };
    of(a).any(|chord| of(b).any(|other| other == chord))
}

/// Whether all points next to both are on the ring around the edge; those that the surface joins to both are the third points of its
/// two facets only, and where one end is held less than the other no further point of the surface is: a facet might become one of a
/// held face.
fn links_alike(complex: &Complex, (a, b): (u32, u32), ring: &Ring) -> bool {
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
        let shares = |more: &[Tet]| {
            let complex = around_an_edge(4, more);
            share_chord(&complex, (4, 5), &Ring::of(&complex, 4, 5).unwrap())
        };
        assert!(!shares(&[]) && !shares(&[[4, 2, 0, 6]]));
        assert!(shares(&[[4, 2, 0, 6], [2, 5, 0, 7]]));
    }
}
