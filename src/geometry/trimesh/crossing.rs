//! Self-intersection test of a triangulated surface.

use super::surface::TriangleSurface;
use super::tree::TriangleTree;
use crate::math::{Tensor3, Vector3};

/// Round-off limit of a crossing, as a part of the size of the body.
const ROUND_OFF: f64 = 1e-7;

/// Finds a point where an edge of the surface crosses the interior of a triangle that shares no corner with it. If two
/// triangles cross, an edge of one crosses the other, unless they are coplanar.
///
/// Candidates are found with boxes along the principal axes of the body. Boxes along the axes of the file would all
/// overlap for an oblique needle made of triangles of its full length (33 000 of them: 3.5 s, with principal axes 0.3
/// s).
pub(super) fn find_crossing(surface: &TriangleSurface, inertia: &Tensor3) -> Option<Vector3> {
    let slack = ROUND_OFF * surface.size();
    let axes = inertia.symmetric_eigen().eigenvectors.transpose();
    let tree = TriangleTree::new(surface.corners().map(|corners| corners.map(|p| axes * p)));
    let mut found = None;
    for (n, triangle) in surface.triangles.iter().enumerate() {
        for i in 0..3 {
            // Visit each edge once.
            if surface.across[n][i] < n as u32 || found.is_some() {
                continue;
            }
            let ends = [triangle[(i + 1) % 3], triangle[(i + 2) % 3]];
            let [a, b] = ends.map(|end| surface.points[end as usize]);
            tree.visit_near(&[axes * a, axes * b], &mut |other, _| {
                let corners = surface.triangles[other as usize];
                if found.is_none() && !corners.iter().any(|corner| ends.contains(corner)) {
                    found = crossing_point(&corners.map(|corner| surface.points[corner as usize]), &a, &b, slack);
                }
            });
        }
    }
    found
}

/// Point where the segment from `a` to `b` crosses the interior of a triangle by more than `slack` on every side.
fn crossing_point(corners: &[Vector3; 3], a: &Vector3, b: &Vector3, slack: f64) -> Option<Vector3> {
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).try_normalize(0.0)?;
    let (before, behind) = (normal.dot(&(a - corners[0])), normal.dot(&(b - corners[0])));
    if before * behind >= 0.0 || before.abs().min(behind.abs()) <= slack {
        return None;
    }
    let at = a + (b - a) * (before / (before - behind));
    let inside = (0..3).all(|i| {
        let along = corners[(i + 1) % 3] - corners[i];
        normal.dot(&along.cross(&(at - corners[i]))) > slack * along.norm()
    });
    inside.then_some(at)
}
