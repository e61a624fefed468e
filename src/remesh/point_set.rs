//! The points of a new mesh while it is made: those of the old mesh first, under their old numbers, then new ones.

use super::{Moved, Origin, Proposal};
use crate::math::Vector;
use crate::mesh::{NodeId, Simplex};

/// Points, and which of them the new mesh may use.
#[derive(Debug, Clone)]
pub(super) struct Cloud {
    /// Where they are, m.
    pub position: Vec<Vector<2>>,
    /// Target size there, m.
    pub size: Vec<f64>,
    /// Whether they are points of the new mesh.
    pub chosen: Vec<bool>,
    origin: Vec<Origin>,
}

impl Cloud {
    /// The nodes of the old mesh, none of them chosen.
    pub fn new(old: &Moved<'_, 2>, size: &[f64]) -> Self {
        let nodes = 0..old.position.len() as u32;
        Self {
            position: old.position.to_vec(),
            size: size.to_vec(),
            chosen: vec![false; old.position.len()],
            origin: nodes.map(|n| Origin::Kept(NodeId(n))).collect(),
        }
    }

    /// Chooses a new point and gives its number.
    pub fn add(&mut self, position: Vector<2>, size: f64, origin: Origin) -> usize {
        self.position.push(position);
        self.size.push(size);
        self.chosen.push(true);
        self.origin.push(origin);
        self.position.len() - 1
    }

    /// Whether a new point is on an edge both of whose ends are held along an axis.
    pub fn stays(&self, point: usize, axis: usize, held: &[[bool; 2]]) -> bool {
        let Origin::Surface(ends, _) = self.origin[point] else { return false };
        ends.iter().all(|end| held[end.index()][axis])
    }

    /// The mesh of these elements: its nodes are the points they use, old ones first and in their old order.
    pub fn proposal(&self, elements: &[[usize; 3]]) -> Proposal<2> {
        let mut number = vec![u32::MAX; self.position.len()];
        elements.iter().flatten().for_each(|&point| number[point] = 0);
        let used: Vec<usize> = (0..number.len()).filter(|&point| number[point] == 0).collect();
        used.iter().zip(0..).for_each(|(&point, n)| number[point] = n);
        let simplex = |e: &[usize; 3]| -> Simplex {
            let [a, b, c] = e.map(|point| NodeId(number[point]));
            [a, b, c, NodeId::default()]
        };
        Proposal {
            position: used.iter().map(|&point| self.position[point]).collect(),
            origin: used.iter().map(|&point| self.origin[point]).collect(),
            elements: elements.iter().map(simplex).collect(),
            over: vec![],
            cleared: 0.0,
        }
    }
}
