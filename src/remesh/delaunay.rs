//! Constrained Delaunay triangulation of the open region.

use super::RemeshError;
use super::boundary_resampling::NewBoundary;
use super::point_insertion::{NEW, OpenRegion, scatter};
use super::point_set::PointSet;
use super::triangle::{PlanarPoint, circumcircle, distance};
use crate::geometry::{BoundingBox, Bvh, morton_order};
use spade::handles::{FaceHandle, FixedVertexHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Circumradius, in target sizes, above which a triangle gets a point at its circumcentre. With points no nearer than
/// 0.6 sizes, angles away from the boundary are then at least asin(0.6 / 1.8) = 19°.
pub(super) const WIDE: f64 = 0.9;
/// Greatest number of refinement rounds: a body of the size of one cell needs two or three.
const ROUNDS: usize = 10;

/// Site: a point with its index in the point set.
#[derive(Debug, Clone, Copy)]
struct DelaunaySite {
    place: Point2<f64>,
    number: usize,
}

impl HasPosition for DelaunaySite {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

/// Triangulation of sites.
type SiteTriangulation = ConstrainedDelaunayTriangulation<DelaunaySite>;
/// Face of the triangulation.
type TriangleFace<'a> = FaceHandle<'a, InnerTag, DelaunaySite, (), CdtEdge<()>, ()>;

/// Refinement of an open region.
struct FillRefinement<'a> {
    triangles: SiteTriangulation,
    limits: &'a NewBoundary,
    part: &'a OpenRegion<'a>,
    /// Initial sites, and the initial number of points.
    sites: &'a [usize],
    near: Bvh<2>,
    first_new: usize,
}

/// Triangulates the region between edges over the sites, and refines wide triangles.
///
/// # Errors
/// [`RemeshError`] if two points coincide, or an edge meets another edge or a point.
pub(super) fn triangulate(
    sites: &[usize],
    limits: &NewBoundary,
    part: &OpenRegion<'_>,
    cloud: &mut PointSet,
) -> Result<Vec<[usize; 3]>, RemeshError> {
    let near = Bvh::points(sites.iter().map(|&p| cloud.position[p]));
    let triangles = insert(sites, limits, cloud)?;
    let mut filling = FillRefinement { triangles, limits, part, sites, near, first_new: cloud.position.len() };
    for _ in 0..ROUNDS {
        if !filling.divide_wide(cloud)? {
            break;
        }
    }
    Ok(inside_triangles(&filling.triangles).map(|t| numbers(&t)).collect())
}

/// Computes the Delaunay triangulation of points; four cocircular points are divided by their Morton order.
///
/// # Errors
/// [`RemeshError`] if two points coincide, or one is beyond exact predicates.
pub(super) fn of_points(points: &[PlanarPoint]) -> Result<Vec<[usize; 3]>, RemeshError> {
    let mut triangles = SiteTriangulation::new();
    for i in morton_order(points) {
        add(&mut triangles, i as usize, &points[i as usize])?;
    }
    Ok(triangles.inner_faces().map(|t| numbers(&t)).collect())
}

/// Iterates over the triangles inside the body: an odd number of constraint edges separates them from the outside.
fn inside_triangles(triangles: &SiteTriangulation) -> impl Iterator<Item = TriangleFace<'_>> {
    let mut parity = vec![None; triangles.num_all_faces()];
    let mut open = vec![];
    for edge in triangles.convex_hull() {
        // An edge of the hull has the far field on its left.
        let face = edge.rev().face();
        if parity[face.index()].replace(edge.as_undirected().is_constraint_edge()).is_none() {
            open.push(face);
        }
    }
    while let Some(face) = open.pop().and_then(|face| face.as_inner()) {
        let is_inside = parity[face.index()] == Some(true);
        for edge in face.adjacent_edges() {
            let next = edge.rev().face();
            if !next.is_outer() && parity[next.index()].is_none() {
                parity[next.index()] = Some(is_inside != edge.as_undirected().is_constraint_edge());
                open.push(next);
            }
        }
    }
    triangles.inner_faces().filter(move |face| parity[face.index()] == Some(true))
}

fn insert(sites: &[usize], limits: &NewBoundary, cloud: &PointSet) -> Result<SiteTriangulation, RemeshError> {
    let places: Vec<PlanarPoint> = sites.iter().map(|&p| cloud.position[p]).collect();
    let mut triangles = SiteTriangulation::new();
    let mut handles = vec![None; cloud.position.len()];
    for i in morton_order(&places) {
        let number = sites[i as usize];
        handles[number] = Some(add(&mut triangles, number, &cloud.position[number])?);
    }
    for edge in &limits.edges {
        let error = RemeshError::Blocked { edge: edge.map(|n| cloud.position[n].into()) };
        let [Some(from), Some(to)] = edge.map(|n| handles[n]) else { return Err(error) };
        triangles.try_add_constraint(from, to);
        if !triangles.exists_constraint(from, to) {
            return Err(error);
        }
    }
    Ok(triangles)
}

fn add(
    triangles: &mut SiteTriangulation,
    number: usize,
    point: &PlanarPoint,
) -> Result<FixedVertexHandle, RemeshError> {
    let before = triangles.num_vertices();
    let failed = |_| RemeshError::Place { place: (*point).into() };
    let handle = triangles.insert(DelaunaySite { place: place(point), number }).map_err(failed)?;
    if triangles.num_vertices() == before {
        return Err(RemeshError::Coincident { place: (*point).into() });
    }
    Ok(handle)
}

/// Flushes coordinates too small for exact predicates to zero.
fn place(p: &PlanarPoint) -> Point2<f64> {
    let [x, y] = [p[0], p[1]].map(|x| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x });
    Point2::new(x, y)
}

impl FillRefinement<'_> {
    /// Inserts circumcentres of wide triangles, the widest first. Returns true if any was inserted.
    fn divide_wide(&mut self, cloud: &mut PointSet) -> Result<bool, RemeshError> {
        let mut wide: Vec<(f64, PlanarPoint, f64)> =
            inside_triangles(&self.triangles).filter_map(|t| self.widest(&numbers(&t), cloud)).collect();
        wide.sort_by(|a, b| b.0.total_cmp(&a.0));
        let candidates: Vec<(PlanarPoint, f64)> = wide.into_iter().map(|(_, middle, size)| (middle, size)).collect();
        let taken = cloud.position[self.first_new..].to_vec();
        let numbers = scatter(&candidates, &taken, cloud, self.limits);
        numbers.iter().try_for_each(|&number| add(&mut self.triangles, number, &cloud.position[number]).map(drop))?;
        Ok(!numbers.is_empty())
    }

    /// Relative width of a wide triangle with room for a point, its circumcentre and the target size there, m.
    fn widest(&self, corners: &[usize; 3], cloud: &PointSet) -> Option<(f64, PlanarPoint, f64)> {
        let (middle, radius) = circumcircle(corners.map(|n| &cloud.position[n]));
        let least = corners.iter().map(|&n| cloud.size[n]).fold(f64::MAX, f64::min);
        // Sizes are interpolated only where the circle could be wide.
        let size = (radius > 0.5 * WIDE * least).then(|| self.part.size(&middle)).flatten()?;
        // Beyond an edge of the region there may be points inside the circle.
        let reach = NEW * size;
        let is_taken = |i: usize| distance(&cloud.position[self.sites[i]], &middle) < reach;
        (radius > WIDE * size && !self.near.any(&BoundingBox::about(&middle, reach), is_taken)).then_some((
            radius / size,
            middle,
            size,
        ))
    }
}

fn numbers(triangle: &TriangleFace<'_>) -> [usize; 3] {
    triangle.vertices().map(|v| v.data().number)
}

impl NewBoundary {
    /// Builds the boundary of the open region.
    pub fn around(edges: Vec<[usize; 2]>, cloud: &PointSet) -> Self {
        Self { near: Bvh::segments(&edges, &cloud.position), edges, lost: vec![], cleared: 0.0 }
    }
}
