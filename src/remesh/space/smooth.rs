//! Smoothing: an interior point moves to improve its tetrahedra.

use super::limits::GAIN;
use super::tet_mesh::{TetMesh, Tetrahedron};
use crate::math::Vector;
use crate::mesh::FACES;

/// Trial fractions of the displacement to the target position.
pub(super) const WAYS: [f64; 4] = [1.0, 0.6, 0.3, 0.1];

/// Smooths a point if its worst tetrahedron improves.
pub(super) fn smooth(complex: &mut TetMesh, point: u32) -> bool {
    if complex.points[point as usize].is_on_surface {
        return false;
    }
    let star: Vec<(u32, Tetrahedron)> = complex.star(point).collect();
    let worst = complex.worst_of(star.iter().map(|(t, _)| *t));
    let here = *complex.x(point);
    let target_position = target_position(complex, point, &star);
    let moved = |way: f64| here + (target_position - here) * way;
    let best = WAYS
        .map(|way| (complex.worst_at(point, &moved(way)), way))
        .into_iter()
        .fold((worst, 0.0), |best, next| if next.0 > best.0 { next } else { best });
    let is_better = best.0 > worst.max(GAIN * worst) + 1e-6;
    if is_better {
        complex.move_point(point, moved(best.1));
    }
    is_better
}

/// Target position of a point: the mean of the best apexes over the faces around it, weighted by how poor their
/// tetrahedra are.
pub(super) fn target_position(complex: &TetMesh, point: u32, star: &[(u32, Tetrahedron)]) -> Vector<3> {
    let (mut sum, mut total) = (Vector::<3>::zeros(), 0.0);
    for (t, tet) in star {
        let Some(k) = tet.iter().position(|p| *p == point) else { continue };
        let [a, b, c] = FACES[k].map(|corner| complex.x(tet[corner]));
        let normal = (b - a).cross(&(c - a));
        if normal.norm() <= 0.0 {
            continue;
        }
        // The apex of a regular tetrahedron stands √(2/3) edges over its base, whose area is √3/4 of an edge squared.
        let height = (2.0 * normal.norm() / 3.0_f64.sqrt() * 2.0 / 3.0).sqrt();
        let ideal = (a + b + c) / 3.0 - normal * (height / normal.norm());
        let weight = 1.0 / (complex.shape(*t).max(0.0) + 0.01);
        sum += ideal * weight;
        total += weight;
    }
    sum / total
}

/// Trial fractions of the displacement of a surface point out of a body.
const OUT: [f64; 3] = [1.0, 0.6, 0.3];
/// Least part of their volume that the surrounding tetrahedra keep: their compression limit.
const SQUEEZED: f64 = 0.95;

/// Moves a surface point out of a body, fully or in part, if its tetrahedra stay better than `enough`.
pub(super) fn clear(complex: &mut TetMesh, (point, x): (u32, Vector<3>), enough: f64) -> bool {
    let here = *complex.x(point);
    let bears = |x: &Vector<3>| complex.worst_at(point, x) > enough && complex.volume_ratio(point, x) > SQUEEZED;
    let way = OUT.map(|part| here + (x - here) * part).into_iter().find(bears);
    way.inspect(|x| complex.clear(point, *x)).is_some()
}
