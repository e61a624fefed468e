//! Snapping of points near the boundary of an immersed body onto it, which avoids slivers.

use super::super::boundary_loops::{BoundaryFeature, features};
use super::super::triangle::{PlanarPoint, distance as apart};
use super::super::{DeformedMesh, NodeOrigin, RemeshError};
use super::background::BackgroundMesh;
use super::boundary::{BoundaryLocation, ImmersedBoundary};
use super::delaunay;
use crate::geometry::{BoundingBox, Bvh};
use crate::math::Vector;

/// Distance, in cell edges, below which a point is snapped to the boundary. A cut is then at least 0.2 edges away from
/// its ends. With less, slivers remain (without snapping meshes failed after 3 to 18 remeshes); at 0.5 two points
/// opposite each other across the boundary meet in one place.
const SNAP: f64 = 0.3;
/// Least distance, in cell edges, between points on the boundary, and from these to other points. On a straight
/// boundary snapped points are at least 0.65 apart: the limit acts at bends and beside features.
const SPACE: f64 = 0.5;

/// Triangulation with the boundary of the body snapped into it.
#[derive(Debug, Clone, PartialEq)]
pub struct ImmersedMesh {
    /// Points, m.
    pub points: Vec<Vector<2>>,
    /// Origins: points on the boundary come from its nodes and edges.
    pub origin: Vec<NodeOrigin>,
    /// Signed distances from the boundary, m; 0 on it.
    pub distance: Vec<f64>,
    /// Triangles, positively oriented.
    pub triangles: Vec<[usize; 3]>,
}

/// Candidate location of a point on the boundary.
struct SnapCandidate {
    place: BoundaryLocation,
    size: f64,
    /// True for a candidate that is accepted regardless of neighbours.
    always: bool,
}

/// Snaps the triangulation. Boundary features become points, then points near the boundary move to its nearest
/// location, the nearest first; those without room there are left out. All points are triangulated again, so that no
/// triangle is inverted.
///
/// # Errors
/// [`RemeshError`] if a point is beyond exact predicates.
pub fn snapped(
    (old, size): (&DeformedMesh<'_, 2>, &[f64]),
    background: &BackgroundMesh,
    distance: &[f64],
) -> Result<ImmersedMesh, RemeshError> {
    let is_near = |p: usize| distance[p].abs() < SNAP * background.size[p];
    let (mut close, far): (Vec<usize>, Vec<usize>) = (0..background.points.len()).partition(|p| is_near(*p));
    close.sort_by(|a, b| distance[*a].abs().total_cmp(&distance[*b].abs()).then(a.cmp(b)));
    let places = accepted_locations(&snap_candidates((old, size), background, &close));
    let near = Bvh::points(places.iter().map(|place| place.at));
    let has_room = |p: &usize| {
        let (point, reach) = (&background.points[*p], SPACE * background.size[*p]);
        !near.any(&BoundingBox::about(point, reach), |i| apart(&places[i].at, point) < reach)
    };
    let free: Vec<usize> = far.into_iter().filter(has_room).collect();
    let points: Vec<PlanarPoint> =
        places.iter().map(|place| place.at).chain(free.iter().map(|p| background.points[*p])).collect();
    let origin = places.iter().map(|place| place.origin).chain(free.iter().map(|_| NodeOrigin::Inside)).collect();
    let distance = places.iter().map(|_| 0.0).chain(free.iter().map(|p| distance[*p])).collect();
    let triangles = delaunay::of_points(&points)?;
    Ok(ImmersedMesh { points, origin, distance, triangles })
}

/// Candidate locations on the boundary: features of any mesh, then corners of the current configuration, then the
/// nearest locations of the close points.
fn snap_candidates(
    (old, size): (&DeformedMesh<'_, 2>, &[f64]),
    background: &BackgroundMesh,
    close: &[usize],
) -> Vec<SnapCandidate> {
    let boundary = ImmersedBoundary::of(old);
    let of_feature = |(node, feature)| SnapCandidate {
        place: boundary.node(node),
        size: size[node],
        always: feature == BoundaryFeature::Always,
    };
    let mut snap_candidates: Vec<SnapCandidate> = features(old).map(of_feature).collect();
    snap_candidates.sort_by_key(|wish| !wish.always);
    let of_point = |p: &usize| {
        let place = boundary.nearest_location(&background.points[*p])?;
        Some(SnapCandidate { place, size: background.size[*p], always: false })
    };
    snap_candidates.extend(close.iter().filter_map(of_point));
    snap_candidates
}

/// Locations of the candidates with enough distance to all earlier ones.
fn accepted_locations(snap_candidates: &[SnapCandidate]) -> Vec<BoundaryLocation> {
    let near = Bvh::points(snap_candidates.iter().map(|wish| wish.place.at));
    let mut is_granted = vec![false; snap_candidates.len()];
    for (i, wish) in snap_candidates.iter().enumerate() {
        let reach = SPACE * wish.size;
        let is_taken = |j: usize| is_granted[j] && apart(&snap_candidates[j].place.at, &wish.place.at) < reach;
        is_granted[i] = wish.always || !near.any(&BoundingBox::about(&wish.place.at, reach), is_taken);
    }
    snap_candidates
        .iter()
        .zip(is_granted)
        .filter(|(_, accepted_locations)| *accepted_locations)
        .map(|(wish, _)| wish.place)
        .collect()
}
