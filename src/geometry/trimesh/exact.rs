//! Exact signed distance to a closed triangulated surface.

use super::closest::TriangleFeature;
use super::field::DistanceGrid;
use super::normals::PseudoNormals;
use super::surface::TriangleSurface;
use super::tree::TriangleTree;
use crate::geometry::Gap;
use crate::math::Vector3;

/// Round-off limit: nearer to an edge or corner than this part of the size, the direction from it is meaningless.
const ROUND_OFF: f64 = 1e-12;

/// Exact signed distance to a surface: the nearest triangle, and the side by its pseudonormals.
#[derive(Clone)]
pub(super) struct ExactDistance {
    pub surface: TriangleSurface,
    pub normals: PseudoNormals,
    pub tree: TriangleTree,
    size: f64,
}

impl ExactDistance {
    /// Builds the search tree and the pseudonormals of a surface.
    pub fn new(surface: TriangleSurface) -> Self {
        let (tree, normals, size) = (TriangleTree::new(surface.corners()), PseudoNormals::of(&surface), surface.size());
        Self { surface, normals, tree, size }
    }

    /// Exact φ and its gradient.
    pub fn gap(&self, p: &Vector3) -> Gap {
        let found = self.tree.nearest(p);
        let outward = self.normals.at(&self.surface, found.triangle, found.closest.feature);
        let arm = p - found.closest.point;
        if found.closest.feature == TriangleFeature::Face {
            return Gap { distance: outward.dot(&arm), normal: outward };
        }
        let (sign, distance) = (1.0_f64.copysign(arm.dot(&outward)), arm.norm());
        if distance <= ROUND_OFF * self.size {
            // An edge between two coincident sheets has no normal of its own.
            let normal = outward.try_normalize(0.0).unwrap_or(self.normals.faces[found.triangle as usize]);
            return Gap { distance: sign * distance, normal };
        }
        Gap { distance: sign * distance, normal: arm * (sign / distance) }
    }

    /// Depth of the deepest point found by pattern search (axis and diagonal steps) from the deepest grid node: at most
    /// √3/2 cells less than the greatest depth.
    pub fn greatest_depth(&self, field: &DistanceGrid) -> f64 {
        const SMALLEST: f64 = 1e-2;
        let depth = |p: &Vector3| -self.gap(p).distance;
        let mut at = field.deepest();
        let (mut best, mut step) = (depth(&at), 0.5 * field.cell());
        while step > SMALLEST * field.cell() {
            let sides =
                (0..27).map(|i| Vector3::from([i % 3, i / 3 % 3, i / 9].map(|n| f64::from(n) - 1.0)) * step + at);
            match sides.map(|p| (depth(&p), p)).find(|(found, _)| *found > best) {
                Some(found) => (best, at) = found,
                None => step *= 0.5,
            }
        }
        best
    }
}
