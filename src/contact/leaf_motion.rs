//! Displacements of the corners of the leaves of the cluster tree.

use super::cluster_tree::ClusterTree;
use super::surface_motion::{NodePaths, SurfaceMotion};
use crate::geometry::BoundingBox;
use crate::math::Vector;

/// Displacements of the leaves.
#[derive(Debug)]
pub(super) struct LeafMotions<const D: usize> {
    /// Reference places of the corners of each leaf, m.
    references: Vec<Vector<D>>,
    /// Box around the displacements of the corners of each leaf from their references, m.
    displacements: Vec<BoundingBox<D>>,
}

impl<const D: usize> LeafMotions<D> {
    /// Box of displacements of corners at their references.
    const AT_REFERENCE: BoundingBox<D> = BoundingBox {
        low: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
        high: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
    };

    /// Creates the motion of leaves whose corners are at their references.
    pub fn new(tree: &ClusterTree, at: &SurfaceMotion<'_, impl NodePaths<D>>) -> Self {
        Self {
            references: tree.corners.iter().map(|node| at.nodes.place(*node)).collect(),
            displacements: vec![Self::AT_REFERENCE; tree.clusters.len()],
        }
    }

    /// Measures the displacements of a leaf.
    pub fn measure(&mut self, tree: &ClusterTree, leaf: usize, at: &SurfaceMotion<'_, impl NodePaths<D>>) {
        let corners = tree.clusters[leaf].corners.clone();
        let pairs = tree.corners[corners.clone()].iter().zip(&self.references[corners]);
        self.displacements[leaf] = pairs.fold(BoundingBox::NONE, |all, (node, reference)| {
            let displacement = at.nodes.place(*node) - reference;
            BoundingBox { low: all.low.inf(&displacement), high: all.high.sup(&displacement) }
        });
    }

    /// Makes the places of the corners of a leaf its references.
    pub fn set_reference(&mut self, tree: &ClusterTree, leaf: usize, at: &SurfaceMotion<'_, impl NodePaths<D>>) {
        let corners = tree.clusters[leaf].corners.clone();
        for (node, reference) in tree.corners[corners.clone()].iter().zip(&mut self.references[corners]) {
            *reference = at.nodes.place(*node);
        }
        self.displacements[leaf] = Self::AT_REFERENCE;
    }

    /// Returns the extent of the displacements of the corners of a leaf, m.
    pub fn spread(&self, leaf: usize) -> f64 {
        let BoundingBox { low, high } = &self.displacements[leaf];
        (high - low).norm()
    }

    /// Returns the box around the displacements of the corners of one leaf less those of another, m.
    pub fn relative(&self, [a, b]: [usize; 2]) -> BoundingBox<D> {
        let (a, b) = (&self.displacements[a], &self.displacements[b]);
        BoundingBox { low: a.low - b.high, high: a.high - b.low }
    }

    /// Returns a bound of the displacements of two leaves relative to each other since they were these, m.
    pub fn relative_since(&self, leaves: [usize; 2], since: &BoundingBox<D>) -> f64 {
        let now = self.relative(leaves);
        (now.high - since.low).sup(&(since.high - now.low)).norm()
    }
}
