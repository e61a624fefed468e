//! Orthtree: the one quadtree and octree. Cells are halved along every axis, and balanced 2:1.

use std::collections::HashSet;

/// Cell: a cube of 2^level finest cells along each edge, by its index among those of its level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct OrthCell<const D: usize> {
    /// Number of halvings down to the finest cells.
    pub level: usize,
    /// Index along each axis.
    pub at: [usize; D],
}

/// Decision on a cell of a subdivision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CellDivision {
    /// The cell is divided.
    Divide,
    /// The cell is a leaf.
    Leaf,
    /// The subdivision ends here.
    Stop,
}

/// Neighbours that the balance considers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CellContact {
    /// Cells that share a face (in the plane an edge).
    Faces,
    /// Cells that touch, even in a corner.
    Corners,
}

/// Neighbour of a leaf across one of its faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FaceNeighbour<const D: usize> {
    /// No neighbour: the face is on the boundary.
    Outside,
    /// One leaf of equal or larger size.
    Leaf(OrthCell<D>),
    /// Several smaller leaves.
    Smaller,
}

/// Leaves of a subdivision of a box.
#[derive(Debug, Clone)]
pub(crate) struct OrthTree<const D: usize> {
    /// Leaves of the box.
    pub leaves: HashSet<OrthCell<D>>,
    /// Number of finest cells along each axis of the box.
    counts: [usize; D],
    /// Level of the root cells.
    coarsest: usize,
}

/// Subdivides the root cells of level `coarsest` that fill a box of `counts` finest cells, one after the other. `decide`
/// takes each cell and the number of cells that wait.
pub(crate) fn subdivide<const D: usize>(
    counts: [usize; D],
    coarsest: usize,
    mut decide: impl FnMut(OrthCell<D>, usize) -> CellDivision,
) {
    for at in cell_indices(counts.map(|count| count >> coarsest)) {
        let mut open = vec![OrthCell { level: coarsest, at }];
        while let Some(cell) = open.pop() {
            match decide(cell, open.len()) {
                CellDivision::Divide => open.extend(cell.children()),
                CellDivision::Leaf => {}
                CellDivision::Stop => return,
            }
        }
    }
}

impl<const D: usize> OrthCell<D> {
    /// Centre, in half finest cells.
    pub fn centre(&self) -> [usize; D] {
        self.at.map(|i| (2 * i + 1) << self.level)
    }

    /// Half the edge, in half finest cells.
    pub fn reach(&self) -> isize {
        1 << self.level
    }

    /// Returns the 2^D cells of half the edge that fill the cell.
    fn children(self) -> impl Iterator<Item = Self> {
        cell_indices([2; D])
            .map(move |half| Self { level: self.level - 1, at: std::array::from_fn(|i| 2 * self.at[i] + half[i]) })
    }

    /// Ancestor of the cell at a higher level.
    fn ancestor(self, level: usize) -> Self {
        Self { level, at: self.at.map(|i| i >> (level - self.level)) }
    }
}

impl<const D: usize> OrthTree<D> {
    /// Starts a tree without leaves over a box of `counts` finest cells, with root cells of level `coarsest`.
    pub fn new(counts: [usize; D], coarsest: usize) -> Self {
        Self { leaves: HashSet::new(), counts, coarsest }
    }

    /// Leaves along a Morton curve.
    pub fn in_order(&self) -> Vec<OrthCell<D>> {
        let mut cells: Vec<OrthCell<D>> = self.leaves.iter().copied().collect();
        cells.sort_by_cached_key(|cell| morton_code(&cell.at.map(|i| i << cell.level)));
        cells
    }

    /// Corners of all leaves, in half finest cells.
    pub fn corners(&self) -> HashSet<[usize; D]> {
        let corner =
            |cell: &OrthCell<D>, end: [usize; D]| std::array::from_fn(|i| (2 * (cell.at[i] + end[i])) << cell.level);
        self.leaves.iter().flat_map(|cell| cell_indices([2; D]).map(move |end| corner(cell, end))).collect()
    }

    /// Neighbour of a leaf across its lower or upper face along an axis.
    pub fn face_neighbour(&self, cell: &OrthCell<D>, axis: usize, up: bool) -> FaceNeighbour<D> {
        let mut offset = [1; D];
        offset[axis] = if up { 2 } else { 0 };
        let Some(next) = self.neighbour(cell, offset) else { return FaceNeighbour::Outside };
        self.leaf_over(next).map_or(FaceNeighbour::Smaller, FaceNeighbour::Leaf)
    }

    /// Divides leaves that touch a leaf of less than half their edge. The result is independent of the order. Only
    /// `waiting` leaves, and those that are divided for them, count as small.
    ///
    /// # Errors
    /// Number of leaves, as soon as there are more than `most`.
    pub fn balance(&mut self, mut waiting: Vec<OrthCell<D>>, contact: CellContact, most: usize) -> Result<(), usize> {
        while let Some(cell) = waiting.pop() {
            if !self.leaves.contains(&cell) {
                continue;
            }
            let around = self.leaves_around(cell, contact).find(|leaf| leaf.level > cell.level + 1);
            if let Some(leaf) = around {
                self.leaves.remove(&leaf);
                self.leaves.extend(leaf.children());
                if self.leaves.len() > most {
                    return Err(self.leaves.len());
                }
                waiting.push(cell);
                waiting.extend(leaf.children());
            }
        }
        Ok(())
    }

    /// Iterates over the leaves of equal or larger size around a cell.
    fn leaves_around(&self, cell: OrthCell<D>, contact: CellContact) -> impl Iterator<Item = OrthCell<D>> + '_ {
        let counts = move |offset: &[usize; D]| {
            contact == CellContact::Corners || offset.iter().filter(|step| **step != 1).count() == 1
        };
        let around = cell_indices([3; D]).filter(counts).filter_map(move |offset| self.neighbour(&cell, offset));
        around.filter_map(|next| self.leaf_over(next))
    }

    /// Cell of the same level at index `at + offset − 1`, if it is in the box.
    fn neighbour(&self, cell: &OrthCell<D>, offset: [usize; D]) -> Option<OrthCell<D>> {
        let mut at = cell.at;
        for (i, index) in at.iter_mut().enumerate() {
            *index = (*index + offset[i]).checked_sub(1).filter(|index| *index < self.counts[i] >> cell.level)?;
        }
        Some(OrthCell { level: cell.level, at })
    }

    /// Leaf that contains a cell; none if the cell is divided.
    fn leaf_over(&self, cell: OrthCell<D>) -> Option<OrthCell<D>> {
        (cell.level..=self.coarsest).map(|level| cell.ancestor(level)).find(|above| self.leaves.contains(above))
    }
}

/// All indices below `counts`, the first axis fastest.
pub(crate) fn cell_indices<const D: usize>(counts: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    (0..counts.iter().product()).map(move |mut flat: usize| {
        counts.map(|count| {
            let index = flat % count;
            flat /= count;
            index
        })
    })
}

/// Morton code: the interleaved bits of the indices.
pub(crate) fn morton_code<const D: usize>(cell: &[usize; D]) -> u128 {
    (0..32).fold(0, |code, bit| {
        cell.iter()
            .enumerate()
            .fold(code, |code, (axis, index)| code | (((index >> bit & 1) as u128) << (bit * D + axis)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tree over a box that is divided to the finest cells at the upper corner of its first root cell only.
    fn corner_tree<const D: usize>(counts: [usize; D], coarsest: usize) -> OrthTree<D> {
        let mut tree = OrthTree::new(counts, coarsest);
        subdivide(counts, coarsest, |cell, _| {
            if cell.level > 0 && cell.at == [(1 << (coarsest - cell.level)) - 1; D] {
                return CellDivision::Divide;
            }
            tree.leaves.insert(cell);
            CellDivision::Leaf
        });
        tree
    }

    fn volume<const D: usize>(tree: &OrthTree<D>) -> usize {
        tree.leaves.iter().map(|cell| 1 << (D * cell.level)).sum()
    }

    fn is_balanced<const D: usize>(tree: &OrthTree<D>, contact: CellContact) -> bool {
        tree.leaves.iter().all(|cell| tree.leaves_around(*cell, contact).all(|leaf| leaf.level <= cell.level + 1))
    }

    #[test]
    fn leaves_fill_the_box_and_no_two_that_touch_are_two_levels_apart() {
        for contact in [CellContact::Faces, CellContact::Corners] {
            let (mut flat, mut solid) = (corner_tree([48, 16], 4), corner_tree([8, 16, 8], 3));
            flat.balance(flat.in_order(), contact, usize::MAX).unwrap();
            solid.balance(solid.in_order(), contact, usize::MAX).unwrap();
            assert_eq!((volume(&flat), volume(&solid)), (48 * 16, 8 * 16 * 8));
            assert!(is_balanced(&flat, contact) && is_balanced(&solid, contact), "{contact:?}");
        }
    }

    #[test]
    fn the_balance_stops_at_the_greatest_number_of_leaves() {
        let start = corner_tree([48, 16], 4);
        let mut whole = start.clone();
        whole.balance(whole.in_order(), CellContact::Corners, usize::MAX).unwrap();
        assert!(whole.leaves.len() > start.leaves.len());
        let mut limited = start.clone();
        let found = limited.balance(limited.in_order(), CellContact::Corners, whole.leaves.len() - 1);
        assert_eq!(found, Err(whole.leaves.len()));
    }

    #[test]
    fn a_subdivision_stops_when_it_is_told_to() {
        let mut seen = 0;
        subdivide([1 << 40, 1 << 40, 1 << 40], 20, |_, _| {
            seen += 1;
            if seen < 10 { CellDivision::Leaf } else { CellDivision::Stop }
        });
        assert_eq!(seen, 10);
    }
}
