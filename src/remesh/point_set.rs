//! Point set of a new mesh under construction: old nodes first, under their old indices, then new points.

use super::{DeformedMesh, NodeOrigin, ProposedMesh};
use crate::math::Vector;
use crate::mesh::{NodeId, Simplex};

/// Points, with a mark for those chosen for the new mesh.
#[derive(Debug, Clone)]
pub(super) struct PointSet {
    /// Positions, m.
    pub position: Vec<Vector<2>>,
    /// Target sizes, m.
    pub size: Vec<f64>,
    /// Marks of the chosen points.
    pub chosen: Vec<bool>,
    origin: Vec<NodeOrigin>,
}

impl PointSet {
    /// Builds the set from the nodes of the old mesh, none of them chosen.
    pub fn new(old: &DeformedMesh<'_, 2>, size: &[f64]) -> Self {
        let nodes = 0..old.position.len() as u32;
        Self {
            position: old.position.to_vec(),
            size: size.to_vec(),
            chosen: vec![false; old.position.len()],
            origin: nodes.map(|n| NodeOrigin::Kept(NodeId(n))).collect(),
        }
    }

    /// Adds a new chosen point and returns its index.
    pub fn add(&mut self, position: Vector<2>, size: f64, origin: NodeOrigin) -> usize {
        self.position.push(position);
        self.size.push(size);
        self.chosen.push(true);
        self.origin.push(origin);
        self.position.len() - 1
    }

    /// Returns true if a new point is on an edge both of whose ends are held along an axis.
    pub fn stays(&self, point: usize, axis: usize, held: &[[bool; 2]]) -> bool {
        let NodeOrigin::Surface(ends, _) = self.origin[point] else { return false };
        ends.iter().all(|end| held[end.index()][axis])
    }

    /// Builds the mesh of these elements. Its nodes are the points that they use, old ones first and in their old
    /// order.
    pub fn proposal(&self, elements: &[[usize; 3]]) -> ProposedMesh<2> {
        let mut number = vec![u32::MAX; self.position.len()];
        elements.iter().flatten().for_each(|&point| number[point] = 0);
        let used: Vec<usize> = (0..number.len()).filter(|&point| number[point] == 0).collect();
        used.iter().zip(0..).for_each(|(&point, n)| number[point] = n);
        let simplex = |e: &[usize; 3]| -> Simplex {
            let [a, b, c] = e.map(|point| NodeId(number[point]));
            [a, b, c, NodeId::default()]
        };
        ProposedMesh {
            position: used.iter().map(|&point| self.position[point]).collect(),
            origin: used.iter().map(|&point| self.origin[point]).collect(),
            elements: elements.iter().map(simplex).collect(),
            over: vec![],
            cleared: 0.0,
        }
    }
}
