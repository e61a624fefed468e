//! Displacements of the nodes of the leaves of the cluster tree.

use super::surface_motion::{NodePlaces, SurfaceMotion};
use crate::geometry::BoundingBox;
use crate::math::Vector;
use crate::mesh::NodeId;
use std::ops::Range;

/// Displacements of the leaves.
#[derive(Debug)]
pub(super) struct LeafMotions<const D: usize> {
    /// Range of each cluster in the lists of nodes, empty if it is no leaf.
    ranges: Vec<Range<usize>>,
    nodes: Vec<NodeId>,
    /// Reference places of the nodes of each leaf, m.
    references: Vec<Vector<D>>,
    /// Box around the displacements of the nodes of each leaf from their references, m.
    displacements: Vec<BoundingBox<D>>,
}

impl<const D: usize> LeafMotions<D> {
    /// Box of displacements of nodes at their references.
    const AT_REFERENCE: BoundingBox<D> = BoundingBox {
        low: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
        high: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
    };

    /// Creates the motion of leaves with these nodes, which are at their references.
    pub fn new<'a>(leaves: impl Iterator<Item = &'a [NodeId]>, at: &SurfaceMotion<'_, impl NodePlaces<D>>) -> Self {
        let (mut ranges, mut nodes) = (vec![], vec![]);
        for own in leaves {
            ranges.push(nodes.len()..nodes.len() + own.len());
            nodes.extend_from_slice(own);
        }
        Self {
            references: nodes.iter().map(|node| at.nodes.place(*node)).collect(),
            displacements: vec![Self::AT_REFERENCE; ranges.len()],
            ranges,
            nodes,
        }
    }

    /// Measures the displacements of a leaf.
    pub fn measure(&mut self, leaf: usize, at: &SurfaceMotion<'_, impl NodePlaces<D>>) {
        let range = self.ranges[leaf].clone();
        let (mut all, mut sum) = (BoundingBox::NONE, Vector::<D>::zeros());
        for (node, reference) in self.nodes[range.clone()].iter().zip(&self.references[range]) {
            let displacement = at.nodes.place(*node) - reference;
            all = all.with(&displacement);
            sum += displacement;
        }
        // A box leaves out what is not a number.
        let is_known = sum.iter().all(|sum| sum.is_finite());
        self.displacements[leaf] = if is_known { all } else { BoundingBox::about(&Vector::zeros(), f64::INFINITY) };
    }

    /// Makes the places of the nodes of a leaf its references.
    pub fn set_reference(&mut self, leaf: usize, at: &SurfaceMotion<'_, impl NodePlaces<D>>) {
        let range = self.ranges[leaf].clone();
        for (node, reference) in self.nodes[range.clone()].iter().zip(&mut self.references[range]) {
            *reference = at.nodes.place(*node);
        }
        self.displacements[leaf] = Self::AT_REFERENCE;
    }

    /// Returns the extent of the displacements of the nodes of a leaf, m.
    pub fn spread(&self, leaf: usize) -> f64 {
        let BoundingBox { low, high } = &self.displacements[leaf];
        (high - low).norm()
    }

    /// Returns the box around the displacements of the nodes of one leaf less those of another, m.
    #[inline]
    pub fn relative(&self, [a, b]: [usize; 2]) -> BoundingBox<D> {
        let (a, b) = (&self.displacements[a], &self.displacements[b]);
        BoundingBox { low: a.low - b.high, high: a.high - b.low }
    }

    /// Returns a bound of the displacements of two leaves relative to each other since they were these, m.
    #[inline]
    pub fn relative_since(&self, leaves: [usize; 2], since: &BoundingBox<D>) -> f64 {
        let now = self.relative(leaves);
        (now.high - since.low).sup(&(since.high - now.low)).norm()
    }
}
