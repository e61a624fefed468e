//! Motion of the leaves of the cluster tree: the displacements of their corners, and the cones of their normals.

use super::cluster_tree::ClusterTree;
use super::facet::outward_normal;
use super::surface_motion::SurfaceMotion;
use crate::geometry::BoundingBox;
use crate::math::{Vector, Vector3, embed};
use crate::mesh::{ElementId, NodeId};

/// Cone of the unit normals of a leaf and of the facets around its nodes. Angles are measured by chords: two unit
/// vectors are at a right angle if the chord between them is √2.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalCone {
    /// Mean normal.
    pub axis: Vector3,
    /// Greatest chord from the mean to a normal.
    pub chord: f64,
    /// Greatest sum of two edges over twice the area of a facet, 1/m, a bound of how fast a normal turns; in the plane
    /// the reciprocal length.
    pub sharpness: f64,
}

/// Motion of the leaves.
#[derive(Debug)]
pub(super) struct LeafMotions<const D: usize> {
    /// Reference places of the corners of each leaf, m.
    references: Vec<Vector<D>>,
    /// Box around the displacements of the corners of each leaf from their references, m.
    displacements: Vec<BoundingBox<D>>,
    cones: Vec<NormalCone>,
    normals: Vec<Vector3>,
}

impl<const D: usize> LeafMotions<D> {
    /// Box of displacements of corners at their references.
    const AT_REFERENCE: BoundingBox<D> = BoundingBox {
        low: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
        high: Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[0.0; D]])),
    };

    /// Creates the motion of leaves whose corners are at their references.
    pub fn new(tree: &ClusterTree, at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>) -> Self {
        let unknown = NormalCone { axis: Vector3::zeros(), chord: f64::INFINITY, sharpness: f64::INFINITY };
        let mut motions = Self {
            references: tree.corners.iter().map(|node| (at.place)(*node)).collect(),
            displacements: vec![Self::AT_REFERENCE; tree.clusters.len()],
            cones: vec![unknown; tree.clusters.len()],
            normals: vec![],
        };
        (0..tree.clusters.len())
            .filter(|cluster| tree.clusters[*cluster].halves.is_none())
            .for_each(|leaf| motions.measure_cone(tree, leaf, at));
        motions
    }

    /// Measures a leaf.
    pub fn measure(
        &mut self,
        tree: &ClusterTree,
        leaf: usize,
        at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>,
    ) {
        let corners = tree.clusters[leaf].corners.clone();
        let pairs = tree.corners[corners.clone()].iter().zip(&self.references[corners]);
        self.displacements[leaf] = pairs.fold(BoundingBox::NONE, |all, (node, reference)| {
            let displacement = (at.place)(*node) - reference;
            BoundingBox { low: all.low.inf(&displacement), high: all.high.sup(&displacement) }
        });
        self.measure_cone(tree, leaf, at);
    }

    /// Measures the cone of a leaf.
    fn measure_cone(
        &mut self,
        tree: &ClusterTree,
        leaf: usize,
        at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>,
    ) {
        self.normals.clear();
        let (mut sum, mut sharpness) = (Vector3::zeros(), 0.0_f64);
        for facet in tree.around(leaf) {
            let (across, edges) = area_vector::<D>(at, *facet);
            let area = across.norm();
            let normal = across / area;
            sum += normal;
            // A number that is not one stays, so that nothing is proved.
            sharpness = if edges / area <= sharpness { sharpness } else { edges / area };
            self.normals.push(normal);
        }
        let axis = sum / sum.norm();
        let greatest = self.normals.iter().map(|normal| (normal - axis).norm_squared());
        let chord = greatest.fold(0.0_f64, |all, one| if one <= all { all } else { one }).sqrt();
        self.cones[leaf] = NormalCone { axis, chord, sharpness };
    }

    /// Makes the places of the corners of a leaf its references.
    pub fn set_reference(&mut self, tree: &ClusterTree, leaf: usize, place: impl Fn(NodeId) -> Vector<D>) {
        let corners = tree.clusters[leaf].corners.clone();
        for (node, reference) in tree.corners[corners.clone()].iter().zip(&mut self.references[corners]) {
            *reference = place(*node);
        }
        self.displacements[leaf] = Self::AT_REFERENCE;
    }

    /// Returns the cone of a measured leaf.
    pub fn cone(&self, leaf: usize) -> &NormalCone {
        &self.cones[leaf]
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

/// Returns the normal of a facet out of the gel, twice its area or its length long, and what bounds its change: the sum of
/// two edges, or 1.
fn area_vector<const D: usize>(
    at: &SurfaceMotion<'_, impl Fn(NodeId) -> Vector<D>>,
    facet: ElementId,
) -> (Vector3, f64) {
    let nodes = &at.surface.facets[facet.index()];
    let (a, b) = (embed(&(at.place)(nodes[0])), embed(&(at.place)(nodes[1])));
    if D == 2 {
        return (outward_normal::<D>(&[a, b, b]), 1.0);
    }
    let c = embed(&(at.place)(nodes[2]));
    (outward_normal::<D>(&[a, b, c]), (b - a).norm() + (c - a).norm())
}

impl NormalCone {
    /// Returns a bound of the chord by which a normal turns while its corners travel this far, m.
    ///
    /// The area vector N of a triangle with the edges e₁, e₂ changes by |ΔN| ≤ 2s(|e₁| + |e₂|) + 4s², so that with the
    /// sharpness q = (|e₁| + |e₂|)/|N| and q² ≥ 4/|N| it is x = |ΔN|/|N| ≤ (1 + qs)² − 1. The chord between the unit
    /// vectors is at most 2|ΔN|/(|N| + |N′|) ≤ 2x/(2 − x).
    pub fn turn(&self, travel: f64) -> f64 {
        let change = (1.0 + self.sharpness * travel).powi(2) - 1.0;
        if change < 1.0 { 2.0 * change / (2.0 - change) } else { f64::INFINITY }
    }

    /// Returns the travel of its corners, m, up to which no normal turns by more than a chord.
    pub fn travel(&self, chord: f64) -> f64 {
        let change = (2.0 * chord / (2.0 + chord)).min(1.0);
        ((1.0 + change).sqrt() - 1.0) / self.sharpness
    }

    /// Returns the chord that is left until normals of two cones can be at a right angle.
    pub fn room(&self, other: &Self) -> f64 {
        std::f64::consts::SQRT_2 - self.chord - other.chord - (self.axis - other.axis).norm()
    }
}
