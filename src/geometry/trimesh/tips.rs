//! Tips: corners of a body that may be sharper than the mesh.

use super::exact::ExactDistance;
use super::inner::inner_point;
use crate::geometry::SharpEnd;

/// Limit of a sharp corner: the depth of a point below it in the body, as a part of its distance from the corner. Cones
/// of 35° half-angle or more (sin 35° = 0.574; the corner of a cube has 0.577) are stopped by the nodes and facets of a
/// mesh. Steel cones at 8 m/s sink at most 0.52 cells into a facet; with 30° 0.63 cells, with 25° 1.8. Corners of a
/// cube and rims of a cylinder must not be tips: the removal of penetration then adds 5 to 20 % of the energy.
const BLUNT: f64 = 0.57;
/// Least distance between tips, in radii of the greatest inscribed ball: one tip for a small flat end, several along a
/// blade.
const APART: f64 = 0.25;
/// Tolerance for neighbours as far from the centre as a corner: single precision displaces the corners of a rim by that
/// much.
const LEVEL: f64 = 1.0 - 1e-5;
/// Greatest number of tips; those furthest from the centre are kept.
const MOST: usize = 64;

/// Finds the tips: sharp corners that are no nearer to the centre of mass than their neighbours. `inner_radius` is that
/// of the greatest inscribed ball, m.
pub(super) fn find_tips(solid: &ExactDistance, inner_radius: f64) -> Vec<SharpEnd> {
    let points = &solid.surface.points;
    let mut furthest = vec![0.0_f64; points.len()];
    for triangle in &solid.surface.triangles {
        let far = triangle.map(|i| points[i as usize].norm()).into_iter().fold(0.0, f64::max);
        for i in triangle {
            furthest[*i as usize] = furthest[*i as usize].max(far);
        }
    }
    let mut outermost: Vec<usize> = (0..points.len()).filter(|i| points[*i].norm() >= LEVEL * furthest[*i]).collect();
    outermost.sort_by(|a, b| points[*b].norm().total_cmp(&points[*a].norm()));
    let mut alone: Vec<usize> = vec![];
    for corner in outermost {
        let away = |other: &usize| (points[*other] - points[corner]).norm() >= APART * inner_radius;
        if alone.iter().all(away) {
            alone.push(corner);
        }
    }
    alone.into_iter().filter_map(|corner| tip(solid, inner_radius, corner)).take(MOST).collect()
}

/// Returns the corner with its inner point if it is sharp at the scale of the coarsest mesh allowed, or of one up to
/// eight times finer.
fn tip(solid: &ExactDistance, inner_radius: f64, corner: usize) -> Option<SharpEnd> {
    let end = solid.surface.points[corner];
    let inward = -solid.normals.corners[corner].try_normalize(0.0)?;
    let sharp = |depth: f64| -solid.gap(&(end + inward * depth)).distance < BLUNT * depth;
    let sharp = [1.0, 0.5, 0.25, 0.125].iter().any(|part| sharp(part * inner_radius));
    let inner = sharp.then(|| inner_point(solid, inner_radius, &end, &inward))??;
    Some(SharpEnd { end, inner })
}
