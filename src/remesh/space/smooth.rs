//! A point inside goes where its tetrahedra are better.

use super::GAIN;
use super::tet_mesh::{Complex, Tet};
use crate::math::Vector;
use crate::mesh::FACES;

/// How much of the way to the middle of what is around it a point tries to go.
pub(super) const WAYS: [f64; 4] = [1.0, 0.6, 0.3, 0.1];

/// Moves a point, if the worst tetrahedron around it gets better.
pub(super) fn smooth(complex: &mut Complex, point: u32) -> bool {
    if complex.points[point as usize].is_on_surface {
        return false;
    }
    let star: Vec<(u32, Tet)> = complex.star(point).collect();
    let worst = complex.worst_of(star.iter().map(|(t, _)| *t));
    let here = *complex.x(point);
    let aim = aim(complex, point, &star);
    let moved = |way: f64| here + (aim - here) * way;
    let best = WAYS
        .map(|way| (complex.worst_at(point, &moved(way)), way))
        .into_iter()
        .fold((worst, 0.0), |best, next| if next.0 > best.0 { next } else { best });
    let is_better = best.0 > worst.max(GAIN * worst) + 1e-6;
    if is_better {
        complex.shift(point, moved(best.1));
    }
    is_better
}

/// Where a point should go: over each face around it stands the place that makes the best tetrahedron, and the worse the one
/// there is, the more that place counts.
pub(super) fn aim(complex: &Complex, point: u32, star: &[(u32, Tet)]) -> Vector<3> {
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

/// Parts of the way out of a body that a point of the surface tries to go.
const OUT: [f64; 3] = [1.0, 0.6, 0.3];
/// The part of their volume that the tetrahedra around it keep at least: they are compressed by as much.
const SQUEEZED: f64 = 0.95;

/// Moves a point of the surface out of a body, or some of the way, if its tetrahedra are better than `enough` then.
pub(super) fn clear(complex: &mut Complex, (point, x): (u32, Vector<3>), enough: f64) -> bool {
    let here = *complex.x(point);
    let bears = |x: &Vector<3>| complex.worst_at(point, x) > enough && complex.squeeze(point, x) > SQUEEZED;
    let way = OUT.map(|part| here + (x - here) * part).into_iter().find(bears);
    way.inspect(|x| complex.clear(point, *x)).is_some()
}
