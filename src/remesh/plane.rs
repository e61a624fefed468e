//! Local remeshing of a body in the plane.
//!
//! The old boundary and the old nodes stay where they are good, and so do the elements between them. The rest is
//! remeshed: long boundary edges are split and needless boundary nodes are left out. Centres of quadtree cells are
//! inserted where no point is near. A constrained Delaunay triangulation joins the points and is carved to the boundary.

use super::boundary_resampling::{NewBoundary, resample};
use super::mesher::check;
use super::point_insertion::{self, OpenRegion, QualityLimits};
use super::point_set::PointSet;
use super::quadtree::RootSquare;
use super::retained_region::{self, RegionDivision};
use super::{DeformedMesh, ProposedMesh, RemeshError, RemeshRules, delaunay};
use crate::geometry::BoundingBox;
use crate::math::Vector;

/// Proposes a mesh of a plane body with these target sizes, m, by node. The old mesh stays where it is good and of
/// these sizes.
///
/// The sizes should satisfy the growth limit of [`graded`](super::graded). Kept nodes come first and in their old order, then points
/// of the old boundary, then interior points; kept elements come first and in their old order, then new ones.
///
/// New boundary points are projected by `cleared` where that moves them little.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions, or if the boundary crosses or touches itself.
pub(super) fn propose(
    old: &DeformedMesh<'_, 2>,
    size: &[f64],
    rules: &RemeshRules,
    cleared: &dyn Fn(&Vector<2>) -> Vector<2>,
) -> Result<ProposedMesh<2>, RemeshError> {
    check(old, size, rules)?;
    let limits = QualityLimits { poor: rules.poor, good: rules.good };
    let worst = retained_region::worst(old);
    let mut cloud = PointSet::new(old, size);
    let surface = resample(old, &mut cloud, (rules, cleared))?;
    point_insertion::keep(old, &worst, &limits, &mut cloud, &surface);
    let parts = retained_region::divide_regions(old, &worst, &limits, &cloud, &surface);
    let filled = if parts.edges.is_empty() { vec![] } else { fill(old, (size, rules.most), &parts, &mut cloud)? };
    Ok(ProposedMesh { cleared: surface.cleared, ..cloud.proposal(&parts.joined(old, &filled)) })
}

/// Fills the open region with new elements.
fn fill(
    old: &DeformedMesh<'_, 2>,
    (size, most): (&[f64], usize),
    parts: &RegionDivision,
    cloud: &mut PointSet,
) -> Result<Vec<[usize; 3]>, RemeshError> {
    let open = parts.open.iter().map(|e| old.mesh.elements[e.index()]).collect();
    let part = OpenRegion::new(old, size, open);
    let around = NewBoundary::around(parts.edges.clone(), cloud);
    point_insertion::fill(&part, (&square(old), most), cloud, &around)?;
    let sites = sites(&part, &around, cloud, old.position.len());
    delaunay::triangulate(&sites, &around, &part, cloud)
}

/// Root square of the quadtree around the body.
fn square(old: &DeformedMesh<'_, 2>) -> RootSquare {
    let BoundingBox { low, high } = BoundingBox::around(old.position);
    RootSquare { corner: low, edge: (high - low).max() }
}

/// Sites of the triangulation of the open region: ends of its edges, and chosen interior points.
fn sites(part: &OpenRegion<'_>, around: &NewBoundary, cloud: &PointSet, n_old: usize) -> Vec<usize> {
    let mut is_site = vec![false; cloud.position.len()];
    part.nodes().chain(n_old..cloud.position.len()).for_each(|p| is_site[p] = cloud.chosen[p]);
    around.edges.iter().flatten().for_each(|&p| is_site[p] = true);
    (0..is_site.len()).filter(|&p| is_site[p]).collect()
}
