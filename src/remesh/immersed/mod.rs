//! The mesh of the paper: the body immersed in a triangulation of the square around it, and cut out of it (figure 6).
//!
//! Each step is a function whose result can be drawn: [`cells`], [`triangulated`], [`distances`], [`snapped`], [`cut_out`].

mod background;
mod boundary;
mod cut;
mod snap;
#[cfg(test)]
mod tests;

pub use background::{Background, Cell, cells, triangulated};
pub use snap::{Immersed, snapped};

use super::point_insertion::Part;
use super::triangle::Point;
use super::{Moved, Proposal, RemeshError, Rules, boundary_loops, check};
use boundary::Boundary;

/// Every step on the way to an immersed mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// The quadtree over the square around the body.
    pub cells: Vec<Cell>,
    /// The Delaunay triangulation of the middles of its cells.
    pub background: Background,
    /// Signed distance of its points from the old boundary, m, negative in the body.
    pub distance: Vec<f64>,
    /// The triangulation with points near the boundary moved onto it.
    pub immersed: Immersed,
    /// What is cut out of it: the new mesh.
    pub proposal: Proposal<2>,
}

/// A new mesh of a plane body with these target sizes, m, by node: nothing of the old one stays but its features (corners, ends of
/// what is held).
///
/// # Errors
/// If sizes or positions are no numbers to mesh with.
pub fn immerse(old: &Moved<'_, 2>, size: &[f64], rules: &Rules) -> Result<Steps, RemeshError> {
    check(old, size, rules)?;
    let cells = cells(old, (size, rules.most))?;
    let background = triangulated(&cells)?;
    let distance = distances(old, &background.points);
    let immersed = snapped((old, size), &background, &distance)?;
    let proposal = cut_out(old, &immersed);
    Ok(Steps { cells, background, distance, immersed, proposal })
}

/// Signed distances of points from the boundary of a body where it is, m: the sign is that of the winding number, so that an
/// overlap is inside.
#[must_use]
pub fn distances(old: &Moved<'_, 2>, points: &[Point]) -> Vec<f64> {
    let boundary = Boundary::of(old);
    points.iter().map(|p| boundary.signed_distance(p)).collect()
}

/// The mesh of the body: triangles inside, and what the zero of the linear interpolant of the distance leaves of those that it
/// cuts.
///
/// A cut goes through the edge where that crosses the old boundary, nearest to the zero of the interpolant: both are the
/// same where the boundary is straight, and O(h²κ) apart where it is not. A quadrilateral is divided by the diagonal with the
/// better worst triangle.
#[must_use]
pub fn cut_out(old: &Moved<'_, 2>, immersed: &Immersed) -> Proposal<2> {
    cut::cut_out(&Boundary::of(old), immersed)
}

/// By how much cutting may change the area of a body, as a share of it: a chord c across a turn θ leaves out c²θ/8 at most, and
/// chords are diagonals of cells, c² = 2h². This is the O(h²κ) of the paper.
#[must_use]
pub fn rounding(old: &Moved<'_, 2>, size: &[f64]) -> f64 {
    let lost: f64 = boundary_loops::turns(old).map(|(node, turn)| 0.25 * size[node] * size[node] * turn).sum();
    let area: f64 = old.mesh.elements.iter().map(|e| crate::mesh::signed_volume(old.position, e)).sum();
    lost / area
}

/// The whole old mesh with its sizes.
fn whole<'a>(old: &Moved<'a, 2>, size: &'a [f64]) -> Part<'a> {
    Part::new(old, size, old.mesh.elements.clone())
}
