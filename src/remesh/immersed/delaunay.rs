//! Delaunay triangulation of points.

use crate::geometry::morton_order;
use crate::remesh::RemeshError;
use crate::remesh::triangle::PlanarPoint;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

/// Site: a point with its index.
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
type SiteTriangulation = DelaunayTriangulation<DelaunaySite>;

/// Computes the Delaunay triangulation of points; four cocircular points are divided by their Morton order.
///
/// # Errors
/// [`RemeshError`] if two points coincide, or one is beyond exact predicates.
pub(super) fn of_points(points: &[PlanarPoint]) -> Result<Vec<[usize; 3]>, RemeshError> {
    let mut triangles = SiteTriangulation::new();
    for i in morton_order(points) {
        add(&mut triangles, i as usize, &points[i as usize])?;
    }
    Ok(triangles.inner_faces().map(|triangle| triangle.vertices().map(|v| v.data().number)).collect())
}

fn add(triangles: &mut SiteTriangulation, number: usize, point: &PlanarPoint) -> Result<(), RemeshError> {
    let before = triangles.num_vertices();
    let failed = |_| RemeshError::Place { place: (*point).into() };
    triangles.insert(DelaunaySite { place: place(point), number }).map_err(failed)?;
    if triangles.num_vertices() == before {
        return Err(RemeshError::Coincident { place: (*point).into() });
    }
    Ok(())
}

/// Flushes coordinates too small for exact predicates to zero.
fn place(p: &PlanarPoint) -> Point2<f64> {
    let [x, y] = [p[0], p[1]].map(|x| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x });
    Point2::new(x, y)
}
