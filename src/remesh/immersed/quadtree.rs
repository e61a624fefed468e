//! Quadtree over the square around the body, 2:1 balanced: cells no larger than the target size in them.

use crate::geometry::{CellContact, CellDivision, OrthCell, OrthTree, subdivide};
use crate::remesh::RemeshError;
use crate::remesh::error::at_most;
use crate::remesh::triangle::PlanarPoint;
use std::cmp::Reverse;

/// Greatest depth: cells of a 2^30th of the edge of the root square.
const DEEPEST: usize = 30;

/// Root square of the quadtree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RootSquare {
    /// Lower corner, m.
    pub corner: PlanarPoint,
    /// Edge, m.
    pub edge: f64,
}

/// Centres and edges, m, of the leaves of a 2:1 balanced quadtree. A cell is divided while it is larger than the least
/// size in it. `least` gives that size for a centre and half an edge, m; none where no leaves are wanted.
///
/// # Errors
/// [`RemeshError::TooMany`] as soon as there are more than `most` leaves: the sizes of far-flung fragments ask for any
/// number.
pub(super) fn leaves(
    square: &RootSquare,
    least: impl Fn(&PlanarPoint, f64) -> Option<f64>,
    most: usize,
) -> Result<Vec<(PlanarPoint, f64)>, RemeshError> {
    let mut tree = OrthTree::new([1 << DEEPEST; 2], DEEPEST);
    let (mut wanted, mut checked) = (vec![], Ok(()));
    subdivide([1 << DEEPEST; 2], DEEPEST, |cell, waiting| {
        checked = at_most((tree.leaves.len() + waiting) as f64, most);
        if checked.is_err() {
            return CellDivision::Stop;
        }
        let (middle, edge) = square.place(&cell);
        let size = least(&middle, 0.5 * edge);
        if size.is_some_and(|size| size < edge) && cell.level > 0 {
            return CellDivision::Divide;
        }
        if size.is_some() {
            wanted.push(cell);
        }
        tree.leaves.insert(cell);
        CellDivision::Leaf
    });
    checked?;
    let balanced = tree.balance(wanted, CellContact::Faces, most);
    balanced.map_err(|points| RemeshError::TooMany { points: points as f64, most })?;
    let mut sorted: Vec<OrthCell<2>> = tree.leaves.into_iter().collect();
    sorted.sort_unstable_by_key(|cell| (Reverse(cell.level), cell.at));
    let mut found: Vec<(PlanarPoint, f64)> = sorted.iter().map(|cell| square.place(cell)).collect();
    found.retain(|(middle, edge)| least(middle, 0.5 * edge).is_some());
    Ok(found)
}

impl RootSquare {
    /// Centre and edge, m, of a cell.
    fn place(&self, cell: &OrthCell<2>) -> (PlanarPoint, f64) {
        let edge = self.edge / f64::from(1_u32 << (DEEPEST - cell.level));
        let middle = |i: usize| self.corner[i] + (cell.at[i] as f64 + 0.5) * edge;
        (PlanarPoint::new(middle(0), middle(1)), edge)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: RootSquare = RootSquare { corner: PlanarPoint::new(0.0, 0.0), edge: 1.0 };

    #[test]
    fn leaves_fill_the_square_and_are_as_small_as_asked() {
        let away =
            |p: &PlanarPoint, half: f64| ((p[0] - half).max(0.0).powi(2) + (p[1] - half).max(0.0).powi(2)).sqrt();
        let found = leaves(&UNIT, |p, half| Some(0.01 + 0.3 * away(p, half)), 10_000).unwrap();
        let area: f64 = found.iter().map(|(_, edge)| edge * edge).sum();
        assert!((area - 1.0).abs() < 1e-12);
        assert!(found.iter().all(|(p, edge)| *edge <= 0.01 + 0.3 * away(p, 0.5 * edge)));
        let finest = found.iter().map(|(_, edge)| *edge).fold(1.0, f64::min);
        assert_eq!(finest, 1.0 / 128.0);
    }

    #[test]
    fn neighbours_are_at_most_one_level_apart() {
        let size = |p: &PlanarPoint, half: f64| {
            let holds = (p - PlanarPoint::new(0.3, 0.3)).abs().max() <= half;
            Some(if holds { 0.002 } else { 1.0 })
        };
        let found = leaves(&UNIT, size, 1000).unwrap();
        assert!(matches!(leaves(&UNIT, size, found.len() - 1), Err(RemeshError::TooMany { .. })));
        let touch = |(p, a): &(PlanarPoint, f64), (q, b): &(PlanarPoint, f64)| {
            let gap = (p - q).abs() - PlanarPoint::repeat(0.5 * (a + b));
            gap.max() < 1e-12 && gap.min() < -1e-12
        };
        for leaf in &found {
            let worst =
                found.iter().filter(|other| touch(leaf, other)).map(|other| other.1 / leaf.1).fold(1.0, f64::max);
            assert!(worst <= 2.0, "{leaf:?}");
        }
        assert!(found.len() > 20);
    }

    #[test]
    fn no_leaves_stand_where_none_are_wanted() {
        let found = leaves(&UNIT, |p, half| (p[0] - half < 0.5).then_some(0.125), 1000).unwrap();
        assert_eq!(found.len(), 32);
    }
}
