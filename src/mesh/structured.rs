//! Simplicial meshes of rectilinear grids: centred (body-centred cubic) and Kuhn splits, and 2:1 balanced octrees.

use super::builder::{MeshBuilder, face_edges, shifted};
use super::{OctreeGrading, Simplex};
use crate::geometry::{cell_indices, morton_code};
use crate::math::Vector;

/// Subdivision of a cell into simplices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CellSplit {
    /// Around a node at the cell centre: crossed triangles; in space the body-centred cubic lattice, whose tetrahedra
    /// join the centres of two neighbouring cells to an edge of their common face.
    Centred,
    /// Kuhn triangulation along one diagonal: two triangles, or six tetrahedra, one for each order of the axes.
    Kuhn,
    /// Centred split of a graded octree whose cells grow away from the origin; the grid must be filled everywhere.
    Tree(OctreeGrading),
}

/// Rectilinear grid with a predicate for its filled cells.
pub struct RectilinearGrid<const D: usize> {
    /// Planes along each axis, ascending, m.
    pub planes: [Vec<f64>; D],
    /// Predicate: true for the indices of a filled cell.
    pub filled: Box<dyn Fn([usize; D]) -> bool>,
}

impl<const D: usize> RectilinearGrid<D> {
    /// Returns node positions and positively oriented simplices.
    #[must_use]
    pub fn split(&self, split: CellSplit) -> (Vec<Vector<D>>, Vec<Simplex>) {
        let mut builder = MeshBuilder::new(&self.planes);
        match split {
            CellSplit::Centred => self.filled_cells().into_iter().for_each(|cell| builder.add_centred_cell(self, cell)),
            CellSplit::Kuhn => self.filled_cells().into_iter().for_each(|cell| builder.add_kuhn_cell(cell)),
            CellSplit::Tree(tree) => super::octree_templates::fill(&mut builder, &tree.leaves(&self.planes)),
        }
        (builder.points, builder.elements)
    }

    /// Filled cells along a Morton curve: neighbours are close in memory.
    fn filled_cells(&self) -> Vec<[usize; D]> {
        let counts: [usize; D] = std::array::from_fn(|i| self.planes[i].len() - 1);
        let mut cells: Vec<[usize; D]> = cell_indices(counts).filter(|cell| (self.filled)(*cell)).collect();
        cells.sort_by_key(morton_code);
        cells
    }

    /// Returns the filled neighbour across the lower or upper face along an axis.
    fn filled_neighbour(&self, cell: [usize; D], axis: usize, up: bool) -> Option<[usize; D]> {
        let mut other = cell;
        other[axis] = if up { cell[axis] + 1 } else { cell[axis].checked_sub(1)? };
        (other[axis] + 1 < self.planes[axis].len() && (self.filled)(other)).then_some(other)
    }
}

impl<const D: usize> MeshBuilder<'_, D> {
    /// Adds the Kuhn simplices of a cell: one for each order in which the axes lead from the low to the high corner.
    fn add_kuhn_cell(&mut self, cell: [usize; D]) {
        for order in axis_orders::<D>() {
            let mut corner = cell.map(|i| 2 * i);
            let mut corners = vec![corner];
            for axis in order {
                corner[axis] += 2;
                corners.push(corner);
            }
            self.add_simplex(&corners);
        }
    }

    /// Adds the centred simplices of a cell. The edges of each face (in the plane the face itself) are joined to the
    /// cell centre and, in space, to the centre of the neighbour. At the boundary the centre of the face replaces that
    /// of the neighbour.
    fn add_centred_cell(&mut self, grid: &RectilinearGrid<D>, cell: [usize; D]) {
        let middle = cell.map(|i| 2 * i + 1);
        for axis in 0..D {
            for up in [false, true] {
                let neighbour = grid.filled_neighbour(cell, axis, up);
                if D == 3 && neighbour.is_some() && !up {
                    continue;
                }
                let face = shifted(middle, axis, if up { 1 } else { -1 });
                let beyond = neighbour.map_or(face, |other| other.map(|i| 2 * i + 1));
                for edge in face_edges(face, axis, 1) {
                    let [a, b] = edge;
                    let corners = [middle, a, b, beyond];
                    self.add_simplex(&corners[..=D]);
                }
            }
        }
    }
}

fn axis_orders<const D: usize>() -> Vec<[usize; D]> {
    let all: &[[usize; 3]] = match D {
        2 => &[[0, 1, 2], [1, 0, 2]],
        _ => &[[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]],
    };
    all.iter().map(|order| std::array::from_fn(|i| order[i])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Mesh, uniform};
    use super::*;

    fn volume<const D: usize>(mesh: &Mesh<D>) -> f64 {
        mesh.elements.iter().map(|e| mesh.measure(e)).sum()
    }

    #[test]
    fn every_split_fills_the_box_and_has_its_boundary() {
        let axis = |n: f64| uniform(0.0, n, 1.0);
        for (split, triangles, tets, edges, faces) in [
            (CellSplit::Centred, 24, 2 * 6 * 3 * 4 + 6 * 4 * 2 - 6 * 4 * 2, 10, 22 * 4),
            (CellSplit::Kuhn, 12, 36, 10, 22 * 2),
        ] {
            let plane = RectilinearGrid { planes: [axis(3.0), axis(2.0)], filled: Box::new(|_| true) };
            let (points, elements) = plane.split(split);
            let mesh = Mesh::<2>::new(points, elements);
            assert_eq!((mesh.elements.len(), mesh.facets.len()), (triangles, edges));
            assert!((volume(&mesh) - 6.0).abs() < 1e-12);
            let space = RectilinearGrid { planes: [axis(3.0), axis(2.0), axis(1.0)], filled: Box::new(|_| true) };
            let (points, elements) = space.split(split);
            let mesh = Mesh::<3>::new(points, elements);
            assert_eq!(mesh.facets.len(), faces);
            assert!((volume(&mesh) - 6.0).abs() < 1e-12);
            if split == CellSplit::Kuhn {
                assert_eq!(mesh.elements.len(), tets);
            }
        }
    }

    #[test]
    fn empty_cells_leave_a_hole() {
        let ring = RectilinearGrid {
            planes: [uniform(0.0, 3.0, 1.0), uniform(0.0, 3.0, 1.0)],
            filled: Box::new(|cell: [usize; 2]| cell != [1, 1]),
        };
        let (points, elements) = ring.split(CellSplit::Centred);
        let mesh = Mesh::<2>::new(points, elements);
        assert!((volume(&mesh) - 8.0).abs() < 1e-12);
        assert_eq!(mesh.facets.len(), 16);
    }
}
