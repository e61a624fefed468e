//! Exact integrals over the overlap of a new and an old element.

use super::barycentric::DeformedElement;
use super::overlap_moments::OverlapMoments;
use super::polygon::PolygonClipper;
use super::polyhedron::PolyhedronClipper;

/// Computes overlaps of elements and their integrals.
#[derive(Debug, Clone, Default)]
pub(super) struct OverlapIntegrator {
    polygons: PolygonClipper,
    polyhedra: PolyhedronClipper,
}

impl OverlapIntegrator {
    /// Integrals over the overlap of an upright old element and a new one; none if they do not overlap.
    ///
    /// `heights` are the densities at the corners of the old element times its measure, kg.
    pub fn moments<const D: usize>(
        &mut self,
        old: &DeformedElement<D>,
        heights: &[f64; 4],
        new: &DeformedElement<D>,
    ) -> Option<OverlapMoments> {
        let in_old = old.weights_of(new)?;
        if D == 2 {
            return self.polygons.moments(&in_old, heights);
        }
        self.polyhedra.moments(&in_old, &new.weights_of(old)?, heights)
    }
}
