//! Steps of an immersed remesh, and their order.

use super::background::{BackgroundCell, BackgroundMesh, cells, triangulated};
use super::boundary::ImmersedBoundary;
use super::cut;
use super::request::{MAX_POINTS, check};
use super::snap::{ImmersedMesh, snapped};
use crate::remesh::triangle::PlanarPoint;
use crate::remesh::{DeformedMesh, ProposedMesh, RemeshError, boundary_loops};

/// Results of all steps of an immersed remesh.
#[derive(Debug, Clone, PartialEq)]
pub struct ImmersionSteps {
    /// Quadtree over the square around the body.
    pub cells: Vec<BackgroundCell>,
    /// Delaunay triangulation of the cell centres.
    pub background: BackgroundMesh,
    /// Signed distance of its points from the old boundary, m, negative in the body.
    pub distance: Vec<f64>,
    /// Triangulation with the points near the boundary snapped onto it.
    pub immersed: ImmersedMesh,
    /// New mesh, cut out of the triangulation.
    pub proposal: ProposedMesh<2>,
}

/// Remeshes a plane body with these target sizes, m, by node. Only features of the old mesh stay: corners and ends of
/// held boundaries.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions.
pub fn immerse(old: &DeformedMesh<'_, 2>, size: &[f64]) -> Result<ImmersionSteps, RemeshError> {
    check(old, size)?;
    let cells = cells(old, size, MAX_POINTS)?;
    let background = triangulated(&cells)?;
    let distance = distances(old, &background.points);
    let immersed = snapped((old, size), &background, &distance)?;
    let proposal = cut_out(old, &immersed);
    Ok(ImmersionSteps { cells, background, distance, immersed, proposal })
}

/// Signed distances of points from the deformed boundary, m. The winding number gives the sign: overlaps are inside.
#[must_use]
pub fn distances(old: &DeformedMesh<'_, 2>, points: &[PlanarPoint]) -> Vec<f64> {
    let boundary = ImmersedBoundary::of(old);
    points.iter().map(|p| boundary.signed_distance(p)).collect()
}

/// Cuts the body out: triangles inside, and the inner parts of triangles cut by the zero level of the interpolated
/// distance.
///
/// An edge is cut where it crosses the old boundary, nearest to the zero of the interpolant: both coincide for a
/// straight boundary, and are O(h²κ) apart otherwise. A quadrilateral is divided by the diagonal with the better worst
/// triangle.
#[must_use]
pub fn cut_out(old: &DeformedMesh<'_, 2>, immersed: &ImmersedMesh) -> ProposedMesh<2> {
    cut::cut_out(&ImmersedBoundary::of(old), immersed)
}

/// Greatest relative change of area by cutting: a chord c across a turn θ leaves out c²θ/8 at most, and chords are
/// diagonals of cells, c² = 2h². This is the O(h²κ) of the paper.
#[must_use]
pub fn rounding(old: &DeformedMesh<'_, 2>, size: &[f64]) -> f64 {
    let lost: f64 = boundary_loops::turns(old).map(|(node, turn)| 0.25 * size[node] * size[node] * turn).sum();
    let area: f64 = old.mesh.elements.iter().map(|e| crate::mesh::signed_volume(old.position, e)).sum();
    lost / area
}
