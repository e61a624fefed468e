//! Graded, 2:1 balanced quadtree or octree: the finest cells near the origin, larger ones away from it.

use super::structured::{HalfIndex, morton};
use std::collections::HashSet;

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

/// Octree cell: a cube of 2^level grid cells along each edge, by its index among those of its level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct OctreeCell<const D: usize> {
    pub level: usize,
    at: [usize; D],
}

/// Neighbour of a leaf across one of its faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceNeighbour<const D: usize> {
    /// No neighbour: the face is on the boundary.
    Outside,
    /// One leaf of equal or larger size.
    Leaf(OctreeCell<D>),
    /// Several smaller leaves.
    Smaller,
}

/// Leaves of the balanced octree: leaves that touch, even in a corner, differ by at most one level.
pub(super) struct OctreeLeaves<const D: usize> {
    cells: HashSet<OctreeCell<D>>,
    counts: [usize; D],
    coarsest: usize,
}

impl OctreeGrading {
    /// Number of leaves over the box of these planes before balancing; counting stops at `most`.
    #[must_use]
    pub fn count<const D: usize>(&self, planes: &[Vec<f64>; D], most: usize) -> usize {
        let mut count = 0;
        self.visit_leaves(planes, &mut |_| {
            count += 1;
            count < most
        });
        count
    }

    /// Balanced leaves over the box of these planes.
    ///
    /// # Panics
    /// Unless `coarsest` is a power of two that divides the number of cells along every axis.
    pub(super) fn leaves<const D: usize>(&self, planes: &[Vec<f64>; D]) -> OctreeLeaves<D> {
        let counts: [usize; D] = std::array::from_fn(|i| planes[i].len() - 1);
        let fits = self.coarsest.is_power_of_two() && counts.iter().all(|n| n.is_multiple_of(self.coarsest));
        assert!(fits, "the largest cells of a tree must fill its box: {} in {counts:?}", self.coarsest);
        let mut cells = HashSet::new();
        self.visit_leaves(planes, &mut |cell| cells.insert(cell));
        let mut leaves = OctreeLeaves { cells, counts, coarsest: self.coarsest.ilog2() as usize };
        leaves.balance();
        leaves
    }

    /// Visits the leaves of the unbalanced octree until `see` returns false.
    fn visit_leaves<const D: usize>(&self, planes: &[Vec<f64>; D], see: &mut impl FnMut(OctreeCell<D>) -> bool) {
        let level = self.coarsest.ilog2() as usize;
        let counts: [usize; D] = std::array::from_fn(|i| (planes[i].len() - 1) >> level);
        for at in indices(counts) {
            let mut open = vec![OctreeCell { level, at }];
            while let Some(cell) = open.pop() {
                if self.is_too_large(planes, &cell) {
                    open.extend(cell.children());
                } else if !see(cell) {
                    return;
                }
            }
        }
    }

    /// Returns true if a cell exceeds the size that the grading permits at its distance from the origin.
    fn is_too_large<const D: usize>(&self, planes: &[Vec<f64>; D], cell: &OctreeCell<D>) -> bool {
        let ends = |i: usize| [cell.at[i], cell.at[i] + 1].map(|n| planes[i][n << cell.level]);
        let edge = (0..D).map(|i| ends(i)[1] - ends(i)[0]).fold(0.0, f64::max);
        let away = |[low, high]: [f64; 2]| low.max(-high).max(0.0);
        let distance = (0..D).map(|i| away(ends(i)).powi(2)).sum::<f64>().sqrt();
        let growth = edge * (1.0 - 1.0 / (1_usize << cell.level) as f64);
        growth > self.slope * (distance - self.core).max(0.0)
    }
}

impl<const D: usize> OctreeCell<D> {
    /// Centre, in half grid cells.
    pub fn centre(&self) -> HalfIndex<D> {
        self.at.map(|i| (2 * i + 1) << self.level)
    }

    /// Half the edge, in half grid cells.
    pub fn reach(&self) -> isize {
        1 << self.level
    }

    /// Returns the 2^D cells of half the edge that fill the cell.
    fn children(self) -> impl Iterator<Item = Self> {
        indices([2; D])
            .map(move |half| Self { level: self.level - 1, at: std::array::from_fn(|i| 2 * self.at[i] + half[i]) })
    }

    /// Ancestor of the cell at a higher level.
    fn ancestor(self, level: usize) -> Self {
        Self { level, at: self.at.map(|i| i >> (level - self.level)) }
    }
}

impl<const D: usize> OctreeLeaves<D> {
    /// Leaves along a Morton curve.
    pub fn in_order(&self) -> Vec<OctreeCell<D>> {
        let mut cells: Vec<OctreeCell<D>> = self.cells.iter().copied().collect();
        cells.sort_by_cached_key(|cell| morton(&cell.at.map(|i| i << cell.level)));
        cells
    }

    /// Corners of all leaves, in half grid cells.
    pub fn corners(&self) -> HashSet<HalfIndex<D>> {
        let corner =
            |cell: &OctreeCell<D>, end: [usize; D]| std::array::from_fn(|i| (2 * (cell.at[i] + end[i])) << cell.level);
        self.cells.iter().flat_map(|cell| indices([2; D]).map(move |end| corner(cell, end))).collect()
    }

    /// Neighbour of a leaf across its lower or upper face along an axis.
    pub fn face_neighbour(&self, cell: &OctreeCell<D>, axis: usize, up: bool) -> FaceNeighbour<D> {
        let mut offset = [1; D];
        offset[axis] = if up { 2 } else { 0 };
        let Some(next) = self.neighbour(cell, offset) else { return FaceNeighbour::Outside };
        self.leaf_over(next).map_or(FaceNeighbour::Smaller, FaceNeighbour::Leaf)
    }

    /// Cell of the same level at index `at + offset − 1`, if it is in the box.
    fn neighbour(&self, cell: &OctreeCell<D>, offset: [usize; D]) -> Option<OctreeCell<D>> {
        let mut at = cell.at;
        for (i, index) in at.iter_mut().enumerate() {
            *index = (*index + offset[i]).checked_sub(1).filter(|index| *index < self.counts[i] >> cell.level)?;
        }
        Some(OctreeCell { level: cell.level, at })
    }

    /// Leaf that contains a cell; none if the cell is divided.
    fn leaf_over(&self, cell: OctreeCell<D>) -> Option<OctreeCell<D>> {
        (cell.level..=self.coarsest).map(|level| cell.ancestor(level)).find(|above| self.cells.contains(above))
    }

    /// Divides leaves that touch a leaf of less than half their edge. The result is independent of the order.
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

/// All indices below `counts`, the first axis fastest.
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

    fn levels<const D: usize>(leaves: &OctreeLeaves<D>) -> Vec<usize> {
        let count = |level: usize| leaves.cells.iter().filter(|cell| cell.level == level).count();
        (0..=leaves.coarsest).map(count).collect()
    }

    fn is_balanced<const D: usize>(leaves: &OctreeLeaves<D>) -> bool {
        let near = |cell: &OctreeCell<D>| {
            let around: Vec<_> = indices([3; D]).filter_map(|offset| leaves.neighbour(cell, offset)).collect();
            around.into_iter().filter_map(|next| leaves.leaf_over(next)).all(|leaf| leaf.level <= cell.level + 1)
        };
        leaves.cells.iter().all(near)
    }

    fn cells_of_the_grid<const D: usize>(leaves: &OctreeLeaves<D>) -> usize {
        levels(leaves).iter().enumerate().map(|(level, n)| n << (D * level)).sum()
    }

    #[test]
    fn leaves_fill_the_box_once_and_no_two_that_touch_are_two_levels_apart() {
        for (core, slope) in [(0.0, 1e9), (0.0, 0.3), (2.5, 1e9), (100.0, 1.0)] {
            let tree = OctreeGrading { coarsest: 8, core, slope };
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
        assert_eq!(levels(&leaves), [32, 0, 0]);
    }

    #[test]
    fn cells_are_counted_no_further_than_asked() {
        let tree = OctreeGrading { coarsest: 4, core: 100.0, slope: 1.0 };
        let planes = [uniform(0.0, 8.0, 1.0), uniform(0.0, 4.0, 1.0)];
        assert_eq!((tree.count(&planes, 1000), tree.count(&planes, 10)), (32, 10));
    }
}
