//! Background mesh: the quadtree over the square around a body, and the triangulation of its cell centres.

use super::super::{DeformedMesh, RemeshError};
use super::delaunay;
use super::quadtree::{RootSquare, leaves};
use super::size_field::SizeField;
use crate::geometry::BoundingBox;
use crate::math::Vector;

/// Cell of the quadtree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BackgroundCell {
    /// Centre, m.
    pub middle: Vector<2>,
    /// Edge, m.
    pub edge: f64,
}

/// Triangulation of a square.
#[derive(Debug, Clone, PartialEq)]
pub struct BackgroundMesh {
    /// Points, m: the cell centres, then the corners of the square.
    pub points: Vec<Vector<2>>,
    /// Edge of the cell of each point, m; 0 for the corners of the square.
    pub size: Vec<f64>,
    /// Triangles, positively oriented.
    pub triangles: Vec<[usize; 3]>,
}

/// Least distance, in greatest sizes, between the body and the edge of the square: the body is cut out of cells on both
/// sides of its boundary.
const MARGIN: f64 = 2.0;

/// Builds the 2:1 balanced quadtree. Cells that meet the body are no larger than the least target size in them, the
/// others as large as the balance permits. The edge of the square is the least size times a power of two: the finest
/// cells have exactly that size.
///
/// # Errors
/// [`RemeshError::TooMany`] if there would be more than `most` cells.
pub fn cells(old: &DeformedMesh<'_, 2>, size: &[f64], most: usize) -> Result<Vec<BackgroundCell>, RemeshError> {
    let field = SizeField::new(old, size);
    let tree = leaves(&square(old, size), |middle, half| field.least(middle, half).or(Some(f64::INFINITY)), most)?;
    Ok(tree.into_iter().map(|(middle, edge)| BackgroundCell { middle, edge }).collect())
}

/// Square about the centre of the body.
fn square(old: &DeformedMesh<'_, 2>, size: &[f64]) -> RootSquare {
    let BoundingBox { low, high } = BoundingBox::around(old.position);
    let [least, greatest] = [size.iter().copied().fold(f64::MAX, f64::min), size.iter().copied().fold(0.0, f64::max)];
    let wanted = (high - low).max() + 2.0 * MARGIN * greatest;
    let mut edge = least;
    while edge < wanted {
        edge *= 2.0;
    }
    RootSquare { corner: 0.5 * (low + high) - Vector::<2>::repeat(0.5 * edge), edge }
}

/// Computes the Delaunay triangulation of the cell centres and the corners of their square.
///
/// # Errors
/// [`RemeshError`] if a point is beyond exact predicates.
pub fn triangulated(cells: &[BackgroundCell]) -> Result<BackgroundMesh, RemeshError> {
    let mut points: Vec<Vector<2>> = cells.iter().map(|cell| cell.middle).collect();
    let mut size: Vec<f64> = cells.iter().map(|cell| cell.edge).collect();
    let around = cells
        .iter()
        .fold(BoundingBox::NONE, |all, cell| all.joined(&BoundingBox::about(&cell.middle, 0.5 * cell.edge)));
    for [x, y] in
        [[around.low, around.low], [around.high, around.low], [around.high, around.high], [around.low, around.high]]
    {
        points.push(Vector::<2>::new(x[0], y[1]));
        size.push(0.0);
    }
    let triangles = delaunay::of_points(&points)?;
    Ok(BackgroundMesh { points, size, triangles })
}
