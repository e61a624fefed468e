//! Cells of a 2:1 balanced quadtree or octree: the finest near the origin, larger away from it.

use super::structured::{Half, morton};
use std::collections::HashSet;

/// Which cells of a grid are joined to larger ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tree {
    /// Edge of the largest cells, in cells of the grid: a power of two that divides their number along every axis.
    pub coarsest: usize,
    /// Distance from the origin within which cells stay those of the grid, m.
    pub core: f64,
    /// An edge may be longer than that of the grid by so much per length of distance from the core.
    pub slope: f64,
}

/// A cube of 2^level cells of the grid along each edge, by its position among those of its level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Cell<const D: usize> {
    pub level: usize,
    at: [usize; D],
}

/// What is on the other side of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond<const D: usize> {
    /// Nothing: the face is on the boundary.
    Outside,
    /// One leaf, as large or larger.
    Leaf(Cell<D>),
    /// Several smaller leaves.
    Smaller,
}

/// The cells that fill the box; no two that touch, were it in a corner, are more than one level apart.
pub(super) struct Leaves<const D: usize> {
    cells: HashSet<Cell<D>>,
    counts: [usize; D],
    coarsest: usize,
}

impl Tree {
    /// Number of cells over the box of these planes before it is balanced, counted no further than `most`.
    #[must_use]
    pub fn count<const D: usize>(&self, planes: &[Vec<f64>; D], most: usize) -> usize {
        let mut count = 0;
        self.visit(planes, &mut |_| {
            count += 1;
            count < most
        });
        count
    }

    /// The balanced cells over the box of these planes.
    ///
    /// # Panics
    /// Unless `coarsest` is a power of two that divides the number of cells along every axis.
    pub(super) fn leaves<const D: usize>(&self, planes: &[Vec<f64>; D]) -> Leaves<D> {
        let counts: [usize; D] = std::array::from_fn(|i| planes[i].len() - 1);
        let fits = self.coarsest.is_power_of_two() && counts.iter().all(|n| n.is_multiple_of(self.coarsest));
        assert!(fits, "the largest cells of a tree must fill its box: {} in {counts:?}", self.coarsest);
        let mut cells = HashSet::new();
        self.visit(planes, &mut |cell| cells.insert(cell));
        let mut leaves = Leaves { cells, counts, coarsest: self.coarsest.ilog2() as usize };
        leaves.balance();
        leaves
    }

    /// Shows every cell that need not be divided until `see` has seen enough.
    fn visit<const D: usize>(&self, planes: &[Vec<f64>; D], see: &mut impl FnMut(Cell<D>) -> bool) {
        let level = self.coarsest.ilog2() as usize;
        let counts: [usize; D] = std::array::from_fn(|i| (planes[i].len() - 1) >> level);
        for at in indices(counts) {
            let mut open = vec![Cell { level, at }];
            while let Some(cell) = open.pop() {
                if self.is_too_large(planes, &cell) {
                    open.extend(cell.children());
                } else if !see(cell) {
                    return;
                }
            }
        }
    }

    fn is_too_large<const D: usize>(&self, planes: &[Vec<f64>; D], cell: &Cell<D>) -> bool {
        let ends = |i: usize| [cell.at[i], cell.at[i] + 1].map(|n| planes[i][n << cell.level]);
        let edge = (0..D).map(|i| ends(i)[1] - ends(i)[0]).fold(0.0, f64::max);
        let away = |[low, high]: [f64; 2]| low.max(-high).max(0.0);
        let distance = (0..D).map(|i| away(ends(i)).powi(2)).sum::<f64>().sqrt();
        let growth = edge * (1.0 - 1.0 / (1_usize << cell.level) as f64);
        growth > self.slope * (distance - self.core).max(0.0)
    }
}

impl<const D: usize> Cell<D> {
    /// Its middle.
    pub fn middle(&self) -> Half<D> {
        self.at.map(|i| (2 * i + 1) << self.level)
    }

    /// Half of its edge, in the units of its middle.
    pub fn reach(&self) -> isize {
        1 << self.level
    }

    fn children(self) -> impl Iterator<Item = Self> {
        indices([2; D])
            .map(move |half| Self { level: self.level - 1, at: std::array::from_fn(|i| 2 * self.at[i] + half[i]) })
    }

    /// The cell of a higher level that holds it.
    fn above(self, level: usize) -> Self {
        Self { level, at: self.at.map(|i| i >> (level - self.level)) }
    }
}

impl<const D: usize> Leaves<D> {
    /// The leaves along a Morton curve.
    pub fn in_order(&self) -> Vec<Cell<D>> {
        let mut cells: Vec<Cell<D>> = self.cells.iter().copied().collect();
        cells.sort_by_cached_key(|cell| morton(&cell.at.map(|i| i << cell.level)));
        cells
    }

    /// The corners of all leaves.
    pub fn corners(&self) -> HashSet<Half<D>> {
        let corner =
            |cell: &Cell<D>, end: [usize; D]| std::array::from_fn(|i| (2 * (cell.at[i] + end[i])) << cell.level);
        self.cells.iter().flat_map(|cell| indices([2; D]).map(move |end| corner(cell, end))).collect()
    }

    /// What a leaf meets along an axis.
    pub fn beyond(&self, cell: &Cell<D>, axis: usize, up: bool) -> Beyond<D> {
        let mut offset = [1; D];
        offset[axis] = if up { 2 } else { 0 };
        let Some(next) = self.neighbour(cell, offset) else { return Beyond::Outside };
        self.leaf_over(next).map_or(Beyond::Smaller, Beyond::Leaf)
    }

    /// The cell of the same level that is offset by so much less one along each axis, if it is in the box.
    fn neighbour(&self, cell: &Cell<D>, offset: [usize; D]) -> Option<Cell<D>> {
        let mut at = cell.at;
        for (i, index) in at.iter_mut().enumerate() {
            *index = (*index + offset[i]).checked_sub(1).filter(|index| *index < self.counts[i] >> cell.level)?;
        }
        Some(Cell { level: cell.level, at })
    }

    /// The leaf that holds a cell, unless the cell is divided.
    fn leaf_over(&self, cell: Cell<D>) -> Option<Cell<D>> {
        (cell.level..=self.coarsest).map(|level| cell.above(level)).find(|above| self.cells.contains(above))
    }

    /// Divides leaves that touch one of less than half their edge. The result does not depend on the order.
    fn balance(&mut self) {
        let mut waiting = self.in_order();
        while let Some(cell) = waiting.pop() {
            if !self.cells.contains(&cell) {
                continue;
            }
            let around = indices([3; D]).filter_map(|offset| self.neighbour(&cell, offset));
            let large = around.filter_map(|next| self.leaf_over(next)).find(|leaf| leaf.level > cell.level + 1);
            if let Some(leaf) = large {
                self.cells.remove(&leaf);
                self.cells.extend(leaf.children());
                waiting.push(cell);
                waiting.extend(leaf.children());
            }
        }
    }
}

/// All indices below these counts.
fn indices<const D: usize>(counts: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    (0..counts.iter().product()).map(move |mut flat: usize| {
        counts.map(|count| {
            let index = flat % count;
            flat /= count;
            index
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::uniform;
    use super::*;

    fn levels<const D: usize>(leaves: &Leaves<D>) -> Vec<usize> {
        let count = |level: usize| leaves.cells.iter().filter(|cell| cell.level == level).count();
        (0..=leaves.coarsest).map(count).collect()
    }

    fn is_balanced<const D: usize>(leaves: &Leaves<D>) -> bool {
        let near = |cell: &Cell<D>| {
            let around: Vec<_> = indices([3; D]).filter_map(|offset| leaves.neighbour(cell, offset)).collect();
            around.into_iter().filter_map(|next| leaves.leaf_over(next)).all(|leaf| leaf.level <= cell.level + 1)
        };
        leaves.cells.iter().all(near)
    }

    fn cells_of_the_grid<const D: usize>(leaves: &Leaves<D>) -> usize {
        levels(leaves).iter().enumerate().map(|(level, n)| n << (D * level)).sum()
    }

    #[test]
    fn leaves_fill_the_box_once_and_no_two_that_touch_are_two_levels_apart() {
        for (core, slope) in [(0.0, 1e9), (0.0, 0.3), (2.5, 1e9), (100.0, 1.0)] {
            let tree = Tree { coarsest: 8, core, slope };
            let flat = tree.leaves(&[uniform(0.0, 32.0, 1.0), uniform(-16.0, 0.0, 1.0)]);
            let solid = tree.leaves(&[uniform(-8.0, 8.0, 1.0), uniform(-16.0, 16.0, 1.0), uniform(-16.0, 0.0, 1.0)]);
            assert_eq!((cells_of_the_grid(&flat), cells_of_the_grid(&solid)), (32 * 16, 16 * 32 * 16));
            assert!(is_balanced(&flat) && is_balanced(&solid), "core {core}, slope {slope}");
        }
    }

    #[test]
    fn cells_grow_with_their_distance_from_the_core() {
        let (core, slope) = (3.0, 0.25);
        let planes = [uniform(-64.0, 64.0, 1.0), uniform(-64.0, 0.0, 1.0)];
        let leaves = Tree { coarsest: 16, core, slope }.leaves(&planes);
        for cell in leaves.in_order() {
            let nearest = |i: usize| {
                let [low, high] = [cell.at[i], cell.at[i] + 1].map(|n| planes[i][n << cell.level]);
                low.max(-high).max(0.0)
            };
            let edge = f64::from(1 << cell.level);
            assert!(edge - 1.0 <= slope * (nearest(0).hypot(nearest(1)) - core).max(0.0), "{cell:?}");
        }
        assert!(levels(&leaves).iter().all(|n| *n > 0), "{:?}", levels(&leaves));
    }

    #[test]
    fn a_core_as_large_as_the_box_leaves_the_grid_alone() {
        let leaves =
            Tree { coarsest: 4, core: 100.0, slope: 1.0 }.leaves(&[uniform(0.0, 8.0, 1.0), uniform(0.0, 4.0, 1.0)]);
        assert_eq!(levels(&leaves), [32, 0, 0]);
    }

    #[test]
    fn cells_are_counted_no_further_than_asked() {
        let tree = Tree { coarsest: 4, core: 100.0, slope: 1.0 };
        let planes = [uniform(0.0, 8.0, 1.0), uniform(0.0, 4.0, 1.0)];
        assert_eq!((tree.count(&planes, 1000), tree.count(&planes, 10)), (32, 10));
    }
}
