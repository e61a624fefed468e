//! Target sizes between the nodes of the old mesh.

use crate::geometry::{BoundingBox, Bvh};
use crate::mesh::Simplex;
use crate::remesh::DeformedMesh;
use crate::remesh::triangle::{PlanarPoint, barycentric};

/// Target sizes on the elements of a deformed mesh.
pub(super) struct SizeField<'a> {
    x: &'a [PlanarPoint],
    size: &'a [f64],
    elements: &'a [Simplex],
    near: Bvh<2>,
}

impl<'a> SizeField<'a> {
    /// Builds the field from the sizes of the nodes, m.
    pub fn new(old: &DeformedMesh<'a, 2>, size: &'a [f64]) -> Self {
        let elements = &old.mesh.elements;
        let bounds: Vec<BoundingBox<2>> =
            elements.iter().map(|e| BoundingBox::around(e[..3].iter().map(|n| &old.position[n.index()]))).collect();
        Self { x: old.position, size, near: Bvh::new(&bounds), elements }
    }

    /// Least target size on the elements about a square, m. Each element is evaluated at the centre, clamped to its
    /// nodal sizes. None where there are no elements.
    pub fn least(&self, middle: &PlanarPoint, half: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        self.near.any(&BoundingBox::about(middle, half), |e| {
            let (barycentric, sizes) = (self.barycentric(e, middle), self.sizes(e));
            let [low, high] = [sizes.iter().copied().fold(f64::MAX, f64::min), sizes.into_iter().fold(0.0, f64::max)];
            let there: f64 = sizes.iter().zip(barycentric).map(|(h, share)| h * share).sum();
            let there = if there.is_finite() { there.clamp(low, high) } else { low };
            least = Some(least.map_or(there, |least| least.min(there)));
            there < 2.0 * half
        });
        least
    }

    fn barycentric(&self, e: usize, point: &PlanarPoint) -> [f64; 3] {
        barycentric([0, 1, 2].map(|k| &self.x[self.elements[e][k].index()]), point)
    }

    fn sizes(&self, e: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| self.size[self.elements[e][k].index()])
    }
}
