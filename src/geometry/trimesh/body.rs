//! Rigid body bounded by a closed triangulated surface.

mod closest;
mod crossing;
mod field;
mod inner;
mod mass;
mod normals;
mod surface;
mod tips;
mod tree;
mod winding;

use super::{Gap, SharpEnd, SignedDistance};
use crate::math::{Tensor3, Vector3};
use closest::TriangleFeature;
use field::DistanceGrid;
use mass::{MassProperties, mass_properties};
use normals::PseudoNormals;
use std::fmt;
pub use surface::{SurfaceError, TriangleSurface};
use tree::TriangleTree;

/// Body bounded by a closed triangulated surface, its centre of mass at the origin.
///
/// Up to an eighth of the longest side from the surface, and everywhere inside, φ is the exact distance to the
/// triangles. Further out a coarse grid gives a lower bound.
///
/// # Examples
/// ```
/// use ballistic_gel::geometry::{SignedDistance, TriangleSurface, TriangulatedBody};
/// use nalgebra::Vector3;
///
/// let [o, x, y, z] = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
/// let corner = TriangleSurface::new(&[[o, y, x], [o, z, y], [o, x, z], [x, y, z]]).expect("it is closed");
/// let corner = TriangulatedBody::new(corner, 2.0).expect("it does not cross itself");
/// assert!((corner.volume().expect("it is bounded") - 8.0 / 6.0).abs() < 1e-15);
/// assert!((corner.gap(&Vector3::zeros()).distance + 2.0 / 4.0 / 3.0_f64.sqrt()).abs() < 1e-15);
/// ```
#[derive(Clone)]
pub struct TriangulatedBody {
    surface: TriangleSurface,
    normals: PseudoNormals,
    tree: TriangleTree,
    field: DistanceGrid,
    size: f64,
    volume: f64,
    inertia: Tensor3,
    centre: Vector3,
    inner_radius: f64,
    tips: Vec<SharpEnd>,
}

/// Round-off limit: nearer to an edge or corner than this part of the size, the direction from it is meaningless.
const ROUND_OFF: f64 = 1e-12;

impl TriangulatedBody {
    /// Builds the body with this surface, `scale` metres per unit.
    ///
    /// # Errors
    /// [`SurfaceError`] if the surface crosses itself, parts of it overlap or lie on each other, or one is inside out.
    ///
    /// # Panics
    /// If the scale is not positive.
    pub fn new(mut surface: TriangleSurface, scale: f64) -> Result<Self, SurfaceError> {
        assert!(scale > 0.0, "the scale of a surface is positive");
        let MassProperties { volume, centre, inertia } = mass_properties(&surface);
        surface.points.iter_mut().for_each(|p| *p = (*p - centre) * scale);
        let given = |p: Vector3| (p / scale + centre).into();
        if let Some(at) = crossing::find_crossing(&surface, &inertia) {
            return Err(SurfaceError::Crossing { at: given(at) });
        }
        let (tree, normals, size) = (TriangleTree::new(surface.corners()), PseudoNormals::of(&surface), surface.size());
        let exact = |p: &Vector3| exact_gap(&surface, &normals, &tree, p, size).distance;
        let field = DistanceGrid::new(surface.bounds(), exact);
        if let Some((fault, at)) = winding::find_fault(&tree, &field, exact) {
            return Err(fault.error(given(at)));
        }
        let (volume, inertia, centre) = (volume * (scale * scale * scale), inertia * (scale * scale), centre * scale);
        let (inner_radius, tips) = (0.0, vec![]);
        let mut solid = Self { surface, normals, tree, field, size, volume, inertia, centre, inner_radius, tips };
        solid.inner_radius = solid.greatest_depth();
        solid.tips = tips::find_tips(&solid);
        Ok(solid)
    }

    /// Exact φ and its gradient.
    pub(super) fn exact(&self, p: &Vector3) -> Gap {
        exact_gap(&self.surface, &self.normals, &self.tree, p, self.size)
    }

    /// Centre of mass in the frame of the file, m; the body's frame has its origin there.
    #[must_use]
    pub fn centre(&self) -> Vector3 {
        self.centre
    }

    /// Returns true if the surface was given inside out.
    #[must_use]
    pub fn was_turned(&self) -> bool {
        self.surface.was_turned()
    }

    /// Corners of the surface, m.
    #[must_use]
    pub fn points(&self) -> &[Vector3] {
        &self.surface.points
    }

    /// Triangles as indices of corners, outward oriented.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.surface.triangles
    }

    /// Corners that may be sharper than the mesh.
    #[must_use]
    pub fn tips(&self) -> &[SharpEnd] {
        &self.tips
    }

    /// Depth of the deepest point found by pattern search (axis and diagonal steps) from the deepest grid node: at most
    /// √3/2 cells less than the greatest depth.
    fn greatest_depth(&self) -> f64 {
        const SMALLEST: f64 = 1e-2;
        let depth = |p: &Vector3| -self.exact(p).distance;
        let mut at = self.field.deepest();
        let (mut best, mut step) = (depth(&at), 0.5 * self.field.cell());
        while step > SMALLEST * self.field.cell() {
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

/// Exact signed distance to a surface of this size, and its gradient.
fn exact_gap(surface: &TriangleSurface, normals: &PseudoNormals, tree: &TriangleTree, p: &Vector3, size: f64) -> Gap {
    let found = tree.nearest(p);
    let outward = normals.at(surface, found.triangle, found.closest.feature);
    let arm = p - found.closest.point;
    if found.closest.feature == TriangleFeature::Face {
        return Gap { distance: outward.dot(&arm), normal: outward };
    }
    let (sign, distance) = (1.0_f64.copysign(arm.dot(&outward)), arm.norm());
    if distance <= ROUND_OFF * size {
        // An edge between two coincident sheets has no normal of its own.
        let normal = outward.try_normalize(0.0).unwrap_or(normals.faces[found.triangle as usize]);
        return Gap { distance: sign * distance, normal };
    }
    Gap { distance: sign * distance, normal: arm * (sign / distance) }
}

impl SignedDistance for TriangulatedBody {
    fn gap(&self, point: &Vector3) -> Gap {
        self.field.far_bound(point).unwrap_or_else(|| self.exact(point))
    }

    fn reach(&self, direction: &Vector3) -> f64 {
        self.tree.reach(direction)
    }

    fn specific_inertia(&self) -> Option<Tensor3> {
        Some(self.inertia)
    }

    fn specific_inertia_of_section(&self) -> Option<f64> {
        None
    }

    fn volume(&self) -> Option<f64> {
        Some(self.volume)
    }

    fn area_of_section(&self) -> Option<f64> {
        None
    }

    fn inner_radius(&self) -> f64 {
        self.inner_radius
    }
}

/// Two bodies are equal if their surfaces are.
impl PartialEq for TriangulatedBody {
    fn eq(&self, other: &Self) -> bool {
        self.surface == other.surface
    }
}

impl fmt::Debug for TriangulatedBody {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (triangles, volume) = (self.surface.triangles.len(), self.volume);
        f.debug_struct("Solid").field("triangles", &triangles).field("volume", &volume).finish_non_exhaustive()
    }
}
