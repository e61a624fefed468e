//! Graded, 2:1 balanced quadtree or octree: the finest cells near the origin, larger ones away from it.

use crate::geometry::{CellContact, CellDivision, OrthCell, OrthTree, subdivide};

/// Grading of an octree over a rectilinear grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OctreeGrading {
    /// Edge of the largest cells in grid cells: a power of two that divides the number of cells along every axis.
    pub coarsest: usize,
    /// Distance from the origin within which cells stay as fine as the grid, m.
    pub core: f64,
    /// Permitted growth of an edge beyond that of the grid, per length of distance from the core.
    pub slope: f64,
}

impl OctreeGrading {
    /// Number of leaves over the box of these planes before balancing; counting stops at `most`.
    #[must_use]
    pub fn count<const D: usize>(&self, planes: &[Vec<f64>; D], most: usize) -> usize {
        let mut count = 0;
        self.subdivide(planes, |_| {
            count += 1;
            count < most
        });
        count
    }

    /// Balanced leaves over the box of these planes: leaves that touch, even in a corner, differ by at most one level.
    ///
    /// # Panics
    /// Unless `coarsest` is a power of two that divides the number of cells along every axis.
    pub(super) fn leaves<const D: usize>(&self, planes: &[Vec<f64>; D]) -> OrthTree<D> {
        let counts: [usize; D] = std::array::from_fn(|i| planes[i].len() - 1);
        let fits = self.coarsest.is_power_of_two() && counts.iter().all(|n| n.is_multiple_of(self.coarsest));
        assert!(fits, "the largest cells of a tree must fill its box: {} in {counts:?}", self.coarsest);
        let mut tree = OrthTree::new(counts, self.coarsest.ilog2() as usize);
        self.subdivide(planes, |cell| tree.leaves.insert(cell));
        let balanced = tree.balance(tree.in_order(), CellContact::Corners, usize::MAX);
        balanced.expect("there is no limit");
        tree
    }

    /// Visits the leaves of the unbalanced octree until `see` returns false.
    fn subdivide<const D: usize>(&self, planes: &[Vec<f64>; D], mut see: impl FnMut(OrthCell<D>) -> bool) {
        let counts = std::array::from_fn(|i| planes[i].len() - 1);
        subdivide(counts, self.coarsest.ilog2() as usize, |cell, _| {
            if self.is_too_large(planes, &cell) {
                CellDivision::Divide
            } else if see(cell) {
                CellDivision::Leaf
            } else {
                CellDivision::Stop
            }
        });
    }

    /// Returns true if a cell exceeds the size that the grading permits at its distance from the origin.
    fn is_too_large<const D: usize>(&self, planes: &[Vec<f64>; D], cell: &OrthCell<D>) -> bool {
        let ends = |i: usize| [cell.at[i], cell.at[i] + 1].map(|n| planes[i][n << cell.level]);
        let edge = (0..D).map(|i| ends(i)[1] - ends(i)[0]).fold(0.0, f64::max);
        let away = |[low, high]: [f64; 2]| low.max(-high).max(0.0);
        let distance = (0..D).map(|i| away(ends(i)).powi(2)).sum::<f64>().sqrt();
        let growth = edge * (1.0 - 1.0 / (1_usize << cell.level) as f64);
        growth > self.slope * (distance - self.core).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::uniform;
    use super::*;

    fn levels<const D: usize>(tree: &OrthTree<D>) -> Vec<usize> {
        let count = |level: usize| tree.leaves.iter().filter(|cell| cell.level == level).count();
        (0..=4).map(count).collect()
    }

    fn cells_of_the_grid<const D: usize>(leaves: &OrthTree<D>) -> usize {
        levels(leaves).iter().enumerate().map(|(level, n)| n << (D * level)).sum()
    }

    #[test]
    fn leaves_fill_the_box_once() {
        for (core, slope) in [(0.0, 1e9), (0.0, 0.3), (2.5, 1e9), (100.0, 1.0)] {
            let tree = OctreeGrading { coarsest: 8, core, slope };
            let flat = tree.leaves(&[uniform(0.0, 32.0, 1.0), uniform(-16.0, 0.0, 1.0)]);
            let solid = tree.leaves(&[uniform(-8.0, 8.0, 1.0), uniform(-16.0, 16.0, 1.0), uniform(-16.0, 0.0, 1.0)]);
            assert_eq!((cells_of_the_grid(&flat), cells_of_the_grid(&solid)), (32 * 16, 16 * 32 * 16));
        }
    }

    #[test]
    fn cells_grow_with_their_distance_from_the_core() {
        let (core, slope) = (3.0, 0.25);
        let planes = [uniform(-64.0, 64.0, 1.0), uniform(-64.0, 0.0, 1.0)];
        let leaves = OctreeGrading { coarsest: 16, core, slope }.leaves(&planes);
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
        let leaves = OctreeGrading { coarsest: 4, core: 100.0, slope: 1.0 }
            .leaves(&[uniform(0.0, 8.0, 1.0), uniform(0.0, 4.0, 1.0)]);
        assert_eq!(levels(&leaves), [32, 0, 0, 0, 0]);
    }

    #[test]
    fn cells_are_counted_no_further_than_asked() {
        let tree = OctreeGrading { coarsest: 4, core: 100.0, slope: 1.0 };
        let planes = [uniform(0.0, 8.0, 1.0), uniform(0.0, 4.0, 1.0)];
        assert_eq!((tree.count(&planes, 1000), tree.count(&planes, 10)), (32, 10));
    }
}
