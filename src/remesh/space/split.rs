//! Edge split: a new point at the midpoint of an edge.

use super::edge_star::EdgeStar;
use super::tet_mesh::{MeshOperation, MeshPoint, TetMesh, Tetrahedron};
use crate::math::Vector;
use crate::remesh::NodeOrigin;

/// Splits an edge at its midpoint if all new tetrahedra are better than `enough`. At the surface the new point is
/// projected by `cleared` if all are better than `good` then.
pub(super) fn split(
    complex: &mut TetMesh,
    (a, b): (u32, u32),
    (enough, good): (f64, f64),
    cleared: &dyn Fn(&Vector<3>) -> Vector<3>,
) -> bool {
    let Some(ring) = EdgeStar::of(complex, a, b) else { return false };
    let Some(middle) = midpoint(complex, (a, b), ring.is_open) else { return false };
    let m = complex.add_point(middle);
    let old: Vec<Tetrahedron> = ring.tets.iter().filter_map(|t| complex.tet(*t)).collect();
    let with = |end: u32| move |tet: &Tetrahedron| tet.map(|point| if point == end { m } else { point });
    let new: Vec<Tetrahedron> = old.iter().map(with(a)).chain(old.iter().map(with(b))).collect();
    let middle = *complex.x(m);
    let clear = if ring.is_open { complex.project_to_free(m, cleared(&middle)) } else { middle };
    let places = [(clear, enough.max(good)), (middle, enough)];
    for (place, enough) in places {
        complex.points[m as usize].x = place;
        if complex.worst_new(&new, enough) > enough {
            complex.cleared -= complex.growth(&new, &ring.tets);
            complex.apply(&MeshOperation { gone: ring.tets, new, ..MeshOperation::default() });
            return true;
        }
    }
    complex.remove_last_point();
    false
}

/// Midpoint of an edge, on the surface or inside.
fn midpoint(complex: &TetMesh, (a, b): (u32, u32), is_on_surface: bool) -> Option<MeshPoint> {
    let [a, b] = [a, b].map(|point| &complex.points[point as usize]);
    let origin =
        if is_on_surface { NodeOrigin::blend(&[(a.origin, 0.5), (b.origin, 0.5)])? } else { NodeOrigin::Inside };
    Some(MeshPoint {
        x: (a.x + b.x) * 0.5,
        rest: (a.rest + b.rest) * 0.5,
        size: 0.5 * (a.size + b.size),
        origin,
        held: std::array::from_fn(|axis| is_on_surface && a.held[axis] && b.held[axis]),
        ends: if is_on_surface { a.ends & b.ends } else { 0 },
        is_on_surface,
    })
}
