//! Tangential smoothing: a surface point slides along the surface to improve its tetrahedra.

use super::edge_star::fan;
use super::limits::{GAIN, STANDING};
use super::smooth::{WAYS, target_position};
use super::surface_criteria::{SurfaceCriteria, is_along, twice_area};
use super::tet_mesh::{TetMesh, Tetrahedron, gradient};
use crate::math::Vector;
use crate::remesh::NodeOrigin;

/// Area vector, relative to a squared target length, below which it vanishes: the surface around the point is a plane
/// that holds it.
const PLANE: f64 = 1e-9;

/// Slides a surface point if its worst tetrahedron improves.
///
/// The point moves in its free directions and across the area vector of its facets, which conserves the volume
/// (Lindstrom & Turk 1998). It leaves its facets by at most [`SurfaceCriteria::slide`] and does not enter a body deeper
/// than points may stand; `cleared` projects out of bodies.
pub(super) fn slide(
    complex: &mut TetMesh,
    point: u32,
    (flat, cleared): (&SurfaceCriteria<'_>, &dyn Fn(&Vector<3>) -> Vector<3>),
) -> bool {
    if !complex.points[point as usize].is_on_surface || complex.points[point as usize].ends != 0 {
        return false;
    }
    let star: Vec<(u32, Tetrahedron)> = complex.star(point).collect();
    let worst = complex.worst_of(star.iter().map(|(t, _)| *t));
    let here = *complex.x(point);
    let way = along(complex, (point, target_position(complex, point, &star) - here), &star);
    let depth = |x: &Vector<3>| (cleared(x) - x).norm();
    let most = depth(&here).max(STANDING * complex.points[point as usize].size);
    let best = WAYS
        .map(|part| (complex.worst_at(point, &(here + way * part)), here + way * part))
        .into_iter()
        .filter(|(_, x)| stays(complex, (point, x), flat) && depth(x) <= most)
        .fold((worst, here), |best, next| if next.0 > best.0 { next } else { best });
    let is_better = best.0 > worst.max(GAIN * worst) + 1e-6;
    let origin = if is_better { made_of(complex, (point, &best.1)) } else { None };
    origin.map(|origin| complex.slide(point, (best.1, origin))).is_some()
}

/// Projects a displacement onto the free directions that conserve the volume.
fn along(complex: &TetMesh, (point, way): (u32, Vector<3>), star: &[(u32, Tetrahedron)]) -> Vector<3> {
    let own = &complex.points[point as usize];
    let free = |v: Vector<3>| complex.project_to_free(point, own.x + v) - own.x;
    let area = free(star.iter().map(|(_, tet)| gradient(complex, tet, point)).sum());
    let way = free(way);
    if area.norm() < PLANE * own.size * own.size {
        return way;
    }
    way - area * (way.dot(&area) / area.norm_squared())
}

/// Returns true if a surface point at `x` is near the planes of its facets, and none of them turns far.
fn stays(complex: &TetMesh, (point, x): (u32, &Vector<3>), flat: &SurfaceCriteria<'_>) -> bool {
    let own = &complex.points[point as usize];
    fan(complex, point).iter().all(|[u, v]| {
        let [old, new] = [&own.x, x].map(|apex| twice_area(apex, [complex.x(*u), complex.x(*v)]));
        is_along(&new, &old) && (x - own.x).dot(&old).abs() <= flat.slide * own.size * old.norm()
    })
}

/// Origin of a point displaced towards one of its surface neighbours of at least equal constraints: a blend along the
/// edge that it is nearest to.
fn made_of(complex: &TetMesh, (point, x): (u32, &Vector<3>)) -> Option<NodeOrigin> {
    let own = &complex.points[point as usize];
    let way = x - own.x;
    let towards = |p: u32| {
        let edge = complex.x(p) - own.x;
        let part = (way.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        ((way - edge * part).norm(), part, p)
    };
    let holds = |p: &u32| (0..3).all(|axis| complex.points[*p as usize].held[axis] || !own.held[axis]);
    let around = fan(complex, point).into_iter().flatten().filter(holds).map(towards);
    let nearest = around.reduce(|best, next| if next.0 < best.0 { next } else { best });
    let (_, part, other) = nearest.filter(|(off, ..)| *off < way.norm()).unwrap_or((0.0, 0.0, point));
    NodeOrigin::blend(&[(own.origin, 1.0 - part), (complex.points[other as usize].origin, part)])
}
