//! A point of the surface goes along it to where its tetrahedra are better.

use super::edge_star::fan;
use super::smooth::{WAYS, aim};
use super::split::blend;
use super::surface_criteria::{Flat, is_along, twice_area};
use super::tet_mesh::{Complex, Tet, gradient};
use super::{GAIN, STANDING};
use crate::math::Vector;
use crate::remesh::Origin;

/// An area vector of less than this part of a squared target length is none: the surface around the point is a plane that holds it.
const PLANE: f64 = 1e-9;

/// Moves a point of the surface, if the worst tetrahedron around it gets better.
///
/// It goes in its free directions and across the area vector of its facets, so that the volume stays what it is (Lindstrom, Turk
/// 1998), and comes off them no further than [`Flat::slide`] says, nor deeper into a body than points may stand: `cleared` is the place
/// nearest to one that is in none.
pub(super) fn slide(
    complex: &mut Complex,
    point: u32,
    (flat, cleared): (&Flat<'_>, &dyn Fn(&Vector<3>) -> Vector<3>),
) -> bool {
    if !complex.points[point as usize].is_on_surface || complex.points[point as usize].ends != 0 {
        return false;
    }
    let star: Vec<(u32, Tet)> = complex.star(point).collect();
    let worst = complex.worst_of(star.iter().map(|(t, _)| *t));
    let here = *complex.x(point);
    let way = along(complex, (point, aim(complex, point, &star) - here), &star);
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

/// The part of a way that leaves held directions and the volume as they are.
fn along(complex: &Complex, (point, way): (u32, Vector<3>), star: &[(u32, Tet)]) -> Vector<3> {
    let own = &complex.points[point as usize];
    let free = |v: Vector<3>| complex.allowed(point, own.x + v) - own.x;
    let area = free(star.iter().map(|(_, tet)| gradient(complex, tet, point)).sum());
    let way = free(way);
    if area.norm() < PLANE * own.size * own.size {
        return way;
    }
    way - area * (way.dot(&area) / area.norm_squared())
}

/// Whether a point of the surface is near the planes of its facets there, and none of them is turned far.
fn stays(complex: &Complex, (point, x): (u32, &Vector<3>), flat: &Flat<'_>) -> bool {
    let own = &complex.points[point as usize];
    fan(complex, point).iter().all(|[u, v]| {
        let [old, new] = [&own.x, x].map(|apex| twice_area(apex, [complex.x(*u), complex.x(*v)]));
        is_along(&new, &old) && (x - own.x).dot(&old).abs() <= flat.slide * own.size * old.norm()
    })
}

/// What a point is made of that goes from where it is towards one of the points around it on the surface, held as it is at least:
/// the one that it comes nearest to the edge to.
fn made_of(complex: &Complex, (point, x): (u32, &Vector<3>)) -> Option<Origin> {
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
    blend([(&own.origin, 1.0 - part), (&complex.points[other as usize].origin, part)])
}
