//! The constrained Delaunay triangulation of the part that is filled anew.

use super::RemeshError;
use super::boundary_loops::Surface;
use super::bounds::{Bounds, along_curve};
use super::box_tree::Near;
use super::carve::inside;
use super::point_insertion::{NEW, Part, scatter};
use super::point_set::Cloud;
use super::triangle::{Point, circumcircle, distance};
use spade::handles::{FaceHandle, FixedVertexHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Triangles with a circumscribed circle of more than this many target sizes get a point in its middle. With points no nearer
/// than 0.6 sizes, angles are then at least asin(0.6 / 1.8) = 19° away from the boundary.
pub(super) const WIDE: f64 = 0.9;
/// Rounds in which points are put into wide triangles: a body of the size of one cell needs two or three.
const ROUNDS: usize = 10;

/// A point and its number in the cloud.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site {
    place: Point2<f64>,
    number: usize,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.place
    }
}

/// The triangulation of sites.
pub(super) type Triangles = ConstrainedDelaunayTriangulation<Site>;
/// A triangle of it.
pub(super) type Triangle<'a> = FaceHandle<'a, InnerTag, Site, (), CdtEdge<()>, ()>;

/// A part that is being filled.
struct Filling<'a> {
    triangles: Triangles,
    limits: &'a Surface,
    part: &'a Part<'a>,
    /// The points it started from, and how many points there were.
    sites: &'a [usize],
    near: Near<2>,
    first_new: usize,
}

/// The triangles between these edges, over the sites and the points that wide triangles get.
///
/// # Errors
/// If two points are in one place, or an edge meets another or a point.
pub(super) fn triangulate(
    sites: &[usize],
    limits: &Surface,
    part: &Part<'_>,
    cloud: &mut Cloud,
) -> Result<Vec<[usize; 3]>, RemeshError> {
    let near = Near::points(sites.iter().map(|&p| cloud.position[p]));
    let triangles = insert(sites, limits, cloud)?;
    let mut filling = Filling { triangles, limits, part, sites, near, first_new: cloud.position.len() };
    for _ in 0..ROUNDS {
        if !filling.divide_wide(cloud)? {
            break;
        }
    }
    Ok(inside(&filling.triangles).map(|t| numbers(&t)).collect())
}

/// The Delaunay triangulation of points; four on a circle are divided by the order in which they stand along a curve.
///
/// # Errors
/// If two points are in one place, or one is beyond exact predicates.
pub(super) fn of_points(points: &[Point]) -> Result<Vec<[usize; 3]>, RemeshError> {
    let mut triangles = Triangles::new();
    for i in along_curve(points) {
        add(&mut triangles, i as usize, &points[i as usize])?;
    }
    Ok(triangles.inner_faces().map(|t| numbers(&t)).collect())
}

fn insert(sites: &[usize], limits: &Surface, cloud: &Cloud) -> Result<Triangles, RemeshError> {
    let places: Vec<Point> = sites.iter().map(|&p| cloud.position[p]).collect();
    let mut triangles = Triangles::new();
    let mut handles = vec![None; cloud.position.len()];
    for i in along_curve(&places) {
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

fn add(triangles: &mut Triangles, number: usize, point: &Point) -> Result<FixedVertexHandle, RemeshError> {
    let before = triangles.num_vertices();
    let failed = |_| RemeshError::Place { place: (*point).into() };
    let handle = triangles.insert(Site { place: place(point), number }).map_err(failed)?;
    if triangles.num_vertices() == before {
        return Err(RemeshError::Coincident { place: (*point).into() });
    }
    Ok(handle)
}

/// Coordinates too small for exact predicates are zero.
fn place(p: &Point) -> Point2<f64> {
    let [x, y] = [p[0], p[1]].map(|x| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x });
    Point2::new(x, y)
}

impl Filling<'_> {
    /// Puts points into the middles of wide circles, the widest first; whether there were any.
    fn divide_wide(&mut self, cloud: &mut Cloud) -> Result<bool, RemeshError> {
        let mut wide: Vec<(f64, Point, f64)> =
            inside(&self.triangles).filter_map(|t| self.widest(&numbers(&t), cloud)).collect();
        wide.sort_by(|a, b| b.0.total_cmp(&a.0));
        let candidates: Vec<(Point, f64)> = wide.into_iter().map(|(_, middle, size)| (middle, size)).collect();
        let taken = cloud.position[self.first_new..].to_vec();
        let numbers = scatter(&candidates, &taken, cloud, self.limits);
        numbers.iter().try_for_each(|&number| add(&mut self.triangles, number, &cloud.position[number]).map(drop))?;
        Ok(!numbers.is_empty())
    }

    /// The width of a triangle in sizes, the middle of its circle and the size there, m, if it is wide and there is room.
    fn widest(&self, corners: &[usize; 3], cloud: &Cloud) -> Option<(f64, Point, f64)> {
        let (middle, radius) = circumcircle(corners.map(|n| &cloud.position[n]));
        let least = corners.iter().map(|&n| cloud.size[n]).fold(f64::MAX, f64::min);
        // Sizes are looked up only where the circle could be wide.
        let size = (radius > 0.5 * WIDE * least).then(|| self.part.size(&middle)).flatten()?;
        // Behind an edge of the part there may be points inside the circle.
        let reach = NEW * size;
        let is_taken = |i: usize| distance(&cloud.position[self.sites[i]], &middle) < reach;
        (radius > WIDE * size && !self.near.any(&Bounds::about(&middle, reach), is_taken)).then_some((
            radius / size,
            middle,
            size,
        ))
    }
}

fn numbers(triangle: &Triangle<'_>) -> [usize; 3] {
    triangle.vertices().map(|v| v.data().number)
}

impl Surface {
    /// The edges around what is filled anew.
    pub fn around(edges: Vec<[usize; 2]>, cloud: &Cloud) -> Self {
        Self { near: Near::segments(&edges, &cloud.position), edges, lost: vec![], cleared: 0.0 }
    }
}
