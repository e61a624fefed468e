//! Rigid body bounded by a closed triangulated surface.

use super::crossing::find_crossing;
use super::exact::ExactDistance;
use super::field::DistanceGrid;
use super::mass::{MassProperties, mass_properties};
use super::surface::{SurfaceError, TriangleSurface};
use super::tips::find_tips;
use super::winding::find_fault;
use crate::geometry::{Gap, SharpEnd, SignedDistance};
use crate::math::{Tensor3, Vector3};
use std::fmt;

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
    exact: ExactDistance,
    field: DistanceGrid,
    volume: f64,
    inertia: Tensor3,
    centre: Vector3,
    inner_radius: f64,
    tips: Vec<SharpEnd>,
}

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
        if let Some(at) = find_crossing(&surface, &inertia) {
            return Err(SurfaceError::Crossing { at: given(at) });
        }
        let bounds = surface.bounds();
        let exact = ExactDistance::new(surface);
        let distance = |p: &Vector3| exact.gap(p).distance;
        let field = DistanceGrid::new(bounds, distance);
        if let Some((fault, at)) = find_fault(&exact.tree, &field, distance) {
            return Err(fault.error(given(at)));
        }
        let (volume, inertia, centre) = (volume * (scale * scale * scale), inertia * (scale * scale), centre * scale);
        let inner_radius = exact.greatest_depth(&field);
        let tips = find_tips(&exact, inner_radius);
        Ok(Self { exact, field, volume, inertia, centre, inner_radius, tips })
    }

    /// Centre of mass in the frame of the file, m; the body's frame has its origin there.
    #[must_use]
    pub fn centre(&self) -> Vector3 {
        self.centre
    }

    /// Returns true if the surface was given inside out.
    #[must_use]
    pub fn was_turned(&self) -> bool {
        self.exact.surface.was_turned()
    }

    /// Corners of the surface, m.
    #[must_use]
    pub fn points(&self) -> &[Vector3] {
        &self.exact.surface.points
    }

    /// Triangles as indices of corners, outward oriented.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.exact.surface.triangles
    }

    /// Corners that may be sharper than the mesh.
    #[must_use]
    pub fn tips(&self) -> &[SharpEnd] {
        &self.tips
    }
}

impl SignedDistance for TriangulatedBody {
    fn gap(&self, point: &Vector3) -> Gap {
        self.field.far_bound(point).unwrap_or_else(|| self.exact.gap(point))
    }

    fn reach(&self, direction: &Vector3) -> f64 {
        self.exact.tree.reach(direction)
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
        self.exact.surface == other.exact.surface
    }
}

impl fmt::Debug for TriangulatedBody {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (triangles, volume) = (self.exact.surface.triangles.len(), self.volume);
        f.debug_struct("Solid").field("triangles", &triangles).field("volume", &volume).finish_non_exhaustive()
    }
}
