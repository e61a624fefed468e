//! The quadtree over the square around a body, and the triangulation of its middles.

use super::super::bounds::Bounds;
use super::super::quadtree::{Square, leaves};
use super::super::{Moved, RemeshError, delaunay};
use super::whole;
use crate::math::Vector;

/// A cell of the quadtree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Its middle, m.
    pub middle: Vector<2>,
    /// Its edge, m.
    pub edge: f64,
}

/// A triangulation of a square.
#[derive(Debug, Clone, PartialEq)]
pub struct Background {
    /// Its points, m: the middles of the cells, and the corners of the square after them.
    pub points: Vec<Vector<2>>,
    /// The edge of the cell of each point, m; 0 for the corners of the square.
    pub size: Vec<f64>,
    /// Its triangles, positively oriented.
    pub triangles: Vec<[usize; 3]>,
}

/// Greatest sizes between the body and the edge of the square, at least: the body is cut out of cells on both sides of its boundary.
const MARGIN: f64 = 2.0;

/// The quadtree, balanced 2:1: cells that meet the body are no larger than the least target size in them, the others as large as
/// the balance lets them. The edge of the square is the least size times a power of two: the finest cells have just that size.
///
/// # Errors
/// If there would be more than `most`.
pub fn cells(old: &Moved<'_, 2>, (size, most): (&[f64], usize)) -> Result<Vec<Cell>, RemeshError> {
    let part = whole(old, size);
    let tree = leaves(&square(old, size), |middle, half| part.least(middle, half).or(Some(f64::INFINITY)), most)?;
    Ok(tree.into_iter().map(|(middle, edge)| Cell { middle, edge }).collect())
}

/// The square about the middle of the body.
fn square(old: &Moved<'_, 2>, size: &[f64]) -> Square {
    let Bounds { low, high } = Bounds::around(old.position);
    let [least, greatest] = [size.iter().copied().fold(f64::MAX, f64::min), size.iter().copied().fold(0.0, f64::max)];
    let wanted = (high - low).max() + 2.0 * MARGIN * greatest;
    let mut edge = least;
    while edge < wanted {
        edge *= 2.0;
    }
    Square { corner: 0.5 * (low + high) - Vector::<2>::repeat(0.5 * edge), edge }
}

/// The Delaunay triangulation of the middles of the cells and the corners of the square that they fill.
///
/// # Errors
/// If a point is where exact predicates do not reach.
pub fn triangulated(cells: &[Cell]) -> Result<Background, RemeshError> {
    let mut points: Vec<Vector<2>> = cells.iter().map(|cell| cell.middle).collect();
    let mut size: Vec<f64> = cells.iter().map(|cell| cell.edge).collect();
    let around = cells.iter().fold(Bounds::NONE, |all, cell| all.joined(&Bounds::about(&cell.middle, 0.5 * cell.edge)));
    for [x, y] in
        [[around.low, around.low], [around.high, around.low], [around.high, around.high], [around.low, around.high]]
    {
        points.push(Vector::<2>::new(x[0], y[1]));
        size.push(0.0);
    }
    let triangles = delaunay::of_points(&points)?;
    Ok(Background { points, size, triangles })
}
