//! Mesh under construction from the points of a lattice, and the faces of its cells.

use super::{NodeId, Simplex, signed_volume};
use crate::math::Vector;
use std::collections::HashMap;

/// Lattice point in half cells: even coordinates lie on planes, odd ones midway between two.
pub(super) type HalfIndex<const D: usize> = [usize; D];

/// Accumulator of nodes and simplices; a lattice point becomes a node at its first use.
pub(super) struct MeshBuilder<'a, const D: usize> {
    planes: &'a [Vec<f64>; D],
    ids: HashMap<HalfIndex<D>, NodeId>,
    /// Positions of the nodes, m.
    pub points: Vec<Vector<D>>,
    /// Elements.
    pub elements: Vec<Simplex>,
}

impl<'a, const D: usize> MeshBuilder<'a, D> {
    /// Starts a mesh without nodes.
    pub fn new(planes: &'a [Vec<f64>; D]) -> Self {
        Self { planes, ids: HashMap::new(), points: vec![], elements: vec![] }
    }

    /// Returns the node at a lattice point, creating it at first use.
    fn node_at(&mut self, half: HalfIndex<D>) -> NodeId {
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
    pub fn add_simplex(&mut self, corners: &[HalfIndex<D>]) {
        let mut nodes = [NodeId::default(); 4];
        for (node, corner) in nodes.iter_mut().zip(corners) {
            *node = self.node_at(*corner);
        }
        if signed_volume(&self.points, &nodes) < 0.0 {
            nodes.swap(0, 1);
        }
        self.elements.push(nodes);
    }
}

/// Lattice point moved along an axis.
pub(super) fn shifted<const D: usize>(mut half: HalfIndex<D>, axis: usize, by: isize) -> HalfIndex<D> {
    half[axis] = half[axis].wrapping_add_signed(by);
    half
}

/// The four edges of a square face, or in the plane the face itself; given are its centre and half its edge.
pub(super) fn face_edges<const D: usize>(face: HalfIndex<D>, axis: usize, reach: isize) -> Vec<[HalfIndex<D>; 2]> {
    let others: Vec<usize> = (0..D).filter(|i| *i != axis).collect();
    let ends = |half: HalfIndex<D>, along: usize| [shifted(half, along, -reach), shifted(half, along, reach)];
    match others[..] {
        [a] => vec![ends(face, a)],
        [a, b] => {
            ends(face, a).map(|side| ends(side, b)).into_iter().chain(ends(face, b).map(|side| ends(side, a))).collect()
        }
        _ => unreachable!("a face has one or two directions"),
    }
}
