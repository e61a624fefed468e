//! Simplices that fill the cells of a rectilinear grid.

use super::{NodeId, Simplex, Tree, signed_volume};
use crate::math::Vector;
use std::collections::HashMap;

/// How a cell is filled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Split {
    /// Around a node in its middle: crossed triangles; in space the body-centred cubic lattice, whose tetrahedra join
    /// the middles of two neighbouring cells to an edge of their common face.
    Centred,
    /// Along one diagonal: two triangles, or the six tetrahedra of Kuhn, one for each order of the axes.
    Kuhn,
    /// Centred, in cells that become larger away from the origin; of a grid that is filled everywhere.
    Tree(Tree),
}

/// A rectilinear grid, some of whose cells are filled.
pub struct Grid<const D: usize> {
    /// Planes along each axis, ascending, m.
    pub planes: [Vec<f64>; D],
    /// Whether the cell at these indices is filled.
    pub filled: Box<dyn Fn([usize; D]) -> bool>,
}

/// A lattice point in half cells: even at planes, odd in the middle between two.
pub(super) type Half<const D: usize> = [usize; D];

/// Nodes and simplices as they are found.
pub(super) struct Builder<'a, const D: usize> {
    planes: &'a [Vec<f64>; D],
    ids: HashMap<Half<D>, NodeId>,
    /// Positions of the nodes, m.
    pub points: Vec<Vector<D>>,
    /// The simplices.
    pub elements: Vec<Simplex>,
}

impl<const D: usize> Grid<D> {
    /// Node positions and positively oriented simplices.
    #[must_use]
    pub fn split(&self, split: Split) -> (Vec<Vector<D>>, Vec<Simplex>) {
        let mut builder = Builder::new(&self.planes);
        match split {
            Split::Centred => self.cells().into_iter().for_each(|cell| builder.centred(self, cell)),
            Split::Kuhn => self.cells().into_iter().for_each(|cell| builder.kuhn(cell)),
            Split::Tree(tree) => super::octree_templates::fill(&mut builder, &tree.leaves(&self.planes)),
        }
        (builder.points, builder.elements)
    }

    /// Filled cells along a Morton curve, so that neighbours are near in memory.
    fn cells(&self) -> Vec<[usize; D]> {
        let counts: [usize; D] = std::array::from_fn(|i| self.planes[i].len() - 1);
        let total: usize = counts.iter().product();
        let mut cells: Vec<[usize; D]> = (0..total)
            .map(|mut flat| {
                std::array::from_fn(|i| {
                    let index = flat % counts[i];
                    flat /= counts[i];
                    index
                })
            })
            .filter(|cell| (self.filled)(*cell))
            .collect();
        cells.sort_by_key(morton);
        cells
    }

    fn is_filled(&self, cell: [usize; D], axis: usize, up: bool) -> Option<[usize; D]> {
        let mut other = cell;
        other[axis] = if up { cell[axis] + 1 } else { cell[axis].checked_sub(1)? };
        (other[axis] + 1 < self.planes[axis].len() && (self.filled)(other)).then_some(other)
    }
}

/// Interleaved bits of the indices.
pub(super) fn morton<const D: usize>(cell: &[usize; D]) -> u128 {
    (0..32).fold(0, |code, bit| {
        cell.iter()
            .enumerate()
            .fold(code, |code, (axis, index)| code | (((index >> bit & 1) as u128) << (bit * D + axis)))
    })
}

impl<'a, const D: usize> Builder<'a, D> {
    fn new(planes: &'a [Vec<f64>; D]) -> Self {
        Self { planes, ids: HashMap::new(), points: vec![], elements: vec![] }
    }

    fn node(&mut self, half: Half<D>) -> NodeId {
        let planes = self.planes;
        *self.ids.entry(half).or_insert_with(|| {
            self.points.push(Vector::<D>::from_fn(|i, _| {
                let at = half[i] / 2;
                if half[i].is_multiple_of(2) { planes[i][at] } else { 0.5 * (planes[i][at] + planes[i][at + 1]) }
            }));
            NodeId(self.points.len() as u32 - 1)
        })
    }

    /// Adds the simplex with these corners, positively oriented.
    pub fn simplex(&mut self, corners: &[Half<D>]) {
        let mut nodes = [NodeId::default(); 4];
        for (node, corner) in nodes.iter_mut().zip(corners) {
            *node = self.node(*corner);
        }
        if signed_volume(&self.points, &nodes) < 0.0 {
            nodes.swap(0, 1);
        }
        self.elements.push(nodes);
    }

    /// One simplex for each order in which the axes can be walked from the low to the high corner.
    fn kuhn(&mut self, cell: [usize; D]) {
        for order in orders::<D>() {
            let mut corner = cell.map(|i| 2 * i);
            let mut corners = vec![corner];
            for axis in order {
                corner[axis] += 2;
                corners.push(corner);
            }
            self.simplex(&corners);
        }
    }

    /// Per face of the cell: its edges (in the plane: itself) joined to the cell's middle and, in space, to the middle
    /// of the neighbour, or of the face where there is no neighbour.
    fn centred(&mut self, grid: &Grid<D>, cell: [usize; D]) {
        let middle = cell.map(|i| 2 * i + 1);
        for axis in 0..D {
            for up in [false, true] {
                let neighbour = grid.is_filled(cell, axis, up);
                if D == 3 && neighbour.is_some() && !up {
                    continue;
                }
                let face = shifted(middle, axis, if up { 1 } else { -1 });
                let beyond = neighbour.map_or(face, |other| other.map(|i| 2 * i + 1));
                for edge in face_edges(face, axis, 1) {
                    let [a, b] = edge;
                    let corners = [middle, a, b, beyond];
                    self.simplex(&corners[..=D]);
                }
            }
        }
    }
}

pub(super) fn shifted<const D: usize>(mut half: Half<D>, axis: usize, by: isize) -> Half<D> {
    half[axis] = half[axis].wrapping_add_signed(by);
    half
}

/// The four edges of a square face, or a face of the plane itself, given by its middle and half its edge.
pub(super) fn face_edges<const D: usize>(face: Half<D>, axis: usize, reach: isize) -> Vec<[Half<D>; 2]> {
    let others: Vec<usize> = (0..D).filter(|i| *i != axis).collect();
    let ends = |half: Half<D>, along: usize| [shifted(half, along, -reach), shifted(half, along, reach)];
    match others[..] {
        [a] => vec![ends(face, a)],
        [a, b] => {
            ends(face, a).map(|side| ends(side, b)).into_iter().chain(ends(face, b).map(|side| ends(side, a))).collect()
        }
        _ => unreachable!("a face has one or two directions"),
    }
}

fn orders<const D: usize>() -> Vec<[usize; D]> {
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
        for (split, triangles, tets, edges, faces) in
            [(Split::Centred, 24, 2 * 6 * 3 * 4 + 6 * 4 * 2 - 6 * 4 * 2, 10, 22 * 4), (Split::Kuhn, 12, 36, 10, 22 * 2)]
        {
            let plane = Grid { planes: [axis(3.0), axis(2.0)], filled: Box::new(|_| true) };
            let (points, elements) = plane.split(split);
            let mesh = Mesh::<2>::new(points, elements);
            assert_eq!((mesh.elements.len(), mesh.facets.len()), (triangles, edges));
            assert!((volume(&mesh) - 6.0).abs() < 1e-12);
            let space = Grid { planes: [axis(3.0), axis(2.0), axis(1.0)], filled: Box::new(|_| true) };
            let (points, elements) = space.split(split);
            let mesh = Mesh::<3>::new(points, elements);
            assert_eq!(mesh.facets.len(), faces);
            assert!((volume(&mesh) - 6.0).abs() < 1e-12);
            if split == Split::Kuhn {
                assert_eq!(mesh.elements.len(), tets);
            }
        }
    }

    #[test]
    fn empty_cells_leave_a_hole() {
        let ring = Grid {
            planes: [uniform(0.0, 3.0, 1.0), uniform(0.0, 3.0, 1.0)],
            filled: Box::new(|cell: [usize; 2]| cell != [1, 1]),
        };
        let (points, elements) = ring.split(Split::Centred);
        let mesh = Mesh::<2>::new(points, elements);
        assert!((volume(&mesh) - 8.0).abs() < 1e-12);
        assert_eq!(mesh.facets.len(), 16);
    }
}
