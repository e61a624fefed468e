//! A new mesh for a gel that has moved, and what it carries over: pure functions from a mesh where its nodes are to another one.

mod carried;
mod defects;
mod locate;
mod overlay;
mod pairing;
mod parts;
mod trace;
mod transfer;
mod triangle;
mod velocity;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod waves;

use crate::algebra::Vector;
pub use carried::{Carried, Symmetry, Transferred, corner_masses, nodal_masses};
pub use defects::{Books, Defects};
pub use transfer::transfer;
use triangle::Triangle;

use crate::mesh::{Mesh, NodeId, Simplex};

/// A mesh where its nodes are.
#[derive(Debug, Clone, Copy)]
pub struct Moved<'a, const D: usize> {
    /// The mesh at rest.
    pub mesh: &'a Mesh<D>,
    /// Where its nodes are, m.
    pub position: &'a [Vector<D>],
}

/// Where a node of a new mesh comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// A node of the old mesh, where it was.
    Kept(NodeId),
    /// A point of an edge of the old boundary: x = (1 − s) a + s b.
    Edge(NodeId, NodeId, f64),
    /// A point inside.
    Inside,
}

/// A new mesh of the same body, and nothing on it yet.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal<const D: usize> {
    /// Where the nodes are, m.
    pub position: Vec<Vector<D>>,
    /// Where they come from.
    pub origin: Vec<Origin>,
    /// The elements, positively oriented there.
    pub elements: Vec<Simplex>,
}
