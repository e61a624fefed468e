//! Cone guard: it keeps the normals of each leaf within a cone whose width its pairs with other leaves allow.
//!
//! A normal turns only as far as the corners of its facet move, so that a leaf is measured again when the nodes around it
//! have travelled a part of its facets.

use super::cluster_tree::ClusterTree;
use super::facet::outward_normal;
use super::surface_motion::{NodePlaces, SurfaceMotion};
use crate::math::{Vector3, embed};

/// Cone of the unit normals of a leaf and of the facets around its nodes. Angles are measured by chords: two unit
/// vectors are at a right angle if the chord between them is √2.
#[derive(Debug, Clone, Copy)]
struct NormalCone {
    /// Axis of the cone.
    axis: Vector3,
    /// Greatest chord from the axis to a normal when they were measured.
    chord: f64,
    /// Greatest chord from the axis to a normal that the pairs of the leaf allow.
    limit: f64,
    /// Bound q of the turn of a normal by the displacement of its corners, 1/m.
    sharpness: f64,
}

/// Guard of the cones of all leaves.
#[derive(Debug)]
pub(super) struct ConeGuard {
    cones: Vec<NormalCone>,
    /// Places of the nodes around a leaf, a buffer.
    places: Vec<Vector3>,
}

impl ConeGuard {
    /// Creates the guard of a number of clusters, of which none is measured.
    pub fn new(n_clusters: usize) -> Self {
        let (axis, unknown) = (Vector3::zeros(), f64::INFINITY);
        let cone = NormalCone { axis, chord: unknown, limit: unknown, sharpness: unknown };
        Self { cones: vec![cone; n_clusters], places: vec![] }
    }

    /// Measures the normals of a leaf against its axis, or against a new axis without a limit.
    pub fn measure<const D: usize>(
        &mut self,
        tree: &ClusterTree,
        leaf: usize,
        at: &SurfaceMotion<'_, impl NodePlaces<D>>,
        has_new_axis: bool,
    ) {
        self.places.clear();
        for node in tree.rim(leaf) {
            self.places.push(embed(&at.nodes.place(*node)));
        }
        let place = |corner: u16| self.places[usize::from(corner)];
        let facets = tree.around(leaf).iter().map(|[a, b, c]| [place(*a), place(*b), place(*c)]);
        let cone = &mut self.cones[leaf];
        if has_new_axis {
            let sum: Vector3 = facets.clone().map(|facet| outward_normal::<D>(&facet).normalize()).sum();
            (cone.axis, cone.limit) = (sum.normalize(), f64::INFINITY);
        }
        cone.measure::<D>(facets);
    }

    /// Returns the chord that is left until a normal of a measured leaf is at its limit.
    pub fn chord_left(&self, leaf: usize) -> f64 {
        self.cones[leaf].limit - self.cones[leaf].chord
    }

    /// Returns the chord that is left until a normal of one measured leaf and one of another can be at a right angle.
    pub fn room(&self, [a, b]: [usize; 2]) -> f64 {
        let (a, b) = (&self.cones[a], &self.cones[b]);
        std::f64::consts::SQRT_2 - a.chord - b.chord - (a.axis - b.axis).norm()
    }

    /// Limits the chord from the axis of a measured leaf to a normal to that measured and a turn.
    pub fn limit(&mut self, leaf: usize, turn: f64) {
        let cone = &mut self.cones[leaf];
        cone.limit = cone.limit.min(cone.chord + turn);
    }

    /// Returns the travel of the nodes around a measured leaf up to which no normal turns past its limit, m.
    ///
    /// Corners that travel by s are displaced by r ≤ 2s relative to each other. The area vector N of a triangle with the
    /// edges e₁, e₂ changes by |ΔN| ≤ r(|e₁| + |e₂|) + r², so that with q ≥ (|e₁| + |e₂|)/|N| and thus q² ≥ 4/|N| it is
    /// x = |ΔN|/|N| ≤ (1 + qr/2)² − 1. The chord between the unit vectors is at most 2|ΔN|/(|N| + |N′|) ≤ 2x/(2 − x).
    pub fn travel_left(&self, leaf: usize) -> f64 {
        let cone = &self.cones[leaf];
        if cone.limit == f64::INFINITY {
            return f64::INFINITY;
        }
        // What is not a number allows nothing.
        let turn = (cone.limit - cone.chord).max(0.0);
        let change = (2.0 * turn / (2.0 + turn)).min(1.0);
        (0.999 * ((1.0 + change).sqrt() - 1.0) / cone.sharpness).max(0.0)
    }
}

impl NormalCone {
    /// Measures the normals of facets against the axis.
    ///
    /// The chord follows from |n − a|² = 2 − 2 n·a, with an error of 1e-8, and q from (|e₁| + |e₂|)² ≤ 2 (|e₁|² + |e₂|²)
    /// with the two shorter edges; an edge in the plane has q = 2/|N|. What is not a number makes both the greatest.
    fn measure<const D: usize>(&mut self, facets: impl Iterator<Item = [Vector3; 3]>) {
        let (mut least, mut sharpness, mut are_known) = (1.0_f64, 0.0_f64, true);
        for corners in facets {
            let normal = outward_normal::<D>(&corners);
            let (along, by_square) = (normal.dot(&self.axis), 1.0 / normal.norm_squared());
            least = least.min(along * along.abs() * by_square);
            let own = by_square * if D == 2 { 4.0 } else { 2.0 * shorter_squares(&corners) };
            sharpness = sharpness.max(own);
            are_known &= own.is_finite() && along.is_finite();
        }
        let cosine = least.signum() * least.abs().sqrt();
        self.chord = if are_known { (2.0 - 2.0 * cosine).max(0.0).sqrt() } else { f64::INFINITY };
        self.sharpness = if are_known { sharpness.sqrt() } else { f64::INFINITY };
    }
}

/// Returns the sum of the squares of the two shorter edges of a triangle, m².
#[inline]
fn shorter_squares([a, b, c]: &[Vector3; 3]) -> f64 {
    let [x, y, z] = [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()];
    x + y + z - x.max(y).max(z)
}
