//! 2:1 balanced quadtree over the square around the body: cells no larger than the target size in them.

use super::triangle::PlanarPoint;
use super::{RemeshError, at_most};
use std::collections::HashSet;

/// Greatest depth: cells of a 2^30th of the edge of the root square.
const DEEPEST: u32 = 30;

/// Square cell of edge `edge` × 2⁻ˡᵉᵛᵉˡ, by its index among those of its level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct QuadCell {
    level: u32,
    at: [u32; 2],
}

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
    let mut leaves = HashSet::new();
    let mut wanted = vec![];
    let mut open = vec![QuadCell { level: 0, at: [0, 0] }];
    while let Some(cell) = open.pop() {
        at_most((leaves.len() + open.len()) as f64, most)?;
        let (middle, edge) = cell.place(square);
        match least(&middle, 0.5 * edge) {
            Some(size) if size < edge && cell.level < DEEPEST => open.extend(cell.children()),
            Some(_) => {
                leaves.insert(cell);
                wanted.push(cell);
            }
            None => drop(leaves.insert(cell)),
        }
    }
    let mut found: Vec<(PlanarPoint, f64)> =
        balanced(leaves, wanted, most)?.into_iter().map(|cell| cell.place(square)).collect();
    found.retain(|(middle, edge)| least(middle, 0.5 * edge).is_some());
    Ok(found)
}

/// Balances the leaves: no two that share an edge differ by more than a level. Returns them in order.
fn balanced(
    mut leaves: HashSet<QuadCell>,
    mut waiting: Vec<QuadCell>,
    most: usize,
) -> Result<Vec<QuadCell>, RemeshError> {
    while let Some(cell) = waiting.pop() {
        if !leaves.contains(&cell) {
            continue;
        }
        let over = |next: QuadCell| (0..=next.level).map(|up| next.above(up)).find(|above| leaves.contains(above));
        let large = cell.beside().filter_map(over).find(|leaf| leaf.level + 1 < cell.level);
        if let Some(leaf) = large {
            leaves.remove(&leaf);
            leaves.extend(leaf.children());
            at_most(leaves.len() as f64, most)?;
            waiting.push(cell);
            waiting.extend(leaf.children());
        }
    }
    let mut sorted: Vec<QuadCell> = leaves.into_iter().collect();
    sorted.sort_unstable();
    Ok(sorted)
}

impl QuadCell {
    fn place(self, square: &RootSquare) -> (PlanarPoint, f64) {
        let edge = square.edge / f64::from(1_u32 << self.level);
        let middle = |i: usize| square.corner[i] + (f64::from(self.at[i]) + 0.5) * edge;
        (PlanarPoint::new(middle(0), middle(1)), edge)
    }

    fn children(self) -> [Self; 4] {
        let [a, b] = self.at.map(|i| 2 * i);
        [[a, b], [a + 1, b], [a, b + 1], [a + 1, b + 1]].map(|at| Self { level: self.level + 1, at })
    }

    /// Ancestor of the cell, `up` levels above.
    fn above(self, up: u32) -> Self {
        Self { level: self.level - up, at: self.at.map(|i| i >> up) }
    }

    /// Edge neighbours of the same level.
    fn beside(self) -> impl Iterator<Item = Self> {
        let [a, b] = self.at;
        let around = [[a.wrapping_sub(1), b], [a + 1, b], [a, b.wrapping_sub(1)], [a, b + 1]];
        around.into_iter().filter(move |at| at.iter().all(|i| i >> self.level == 0)).map(move |at| Self { at, ..self })
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
