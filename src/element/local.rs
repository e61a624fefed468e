//! The nodes of a run of elements, numbered by themselves, while it is swept: small enough for the nearest cache.

use crate::algebra::Vector;

/// Most nodes that a block may number for itself.
pub const MOST_LOCAL_NODES: usize = 4096;

/// Displacement (three components and a gap) and velocity of a node.
pub type Row = [f64; 8];
/// Impulse of a node (three components), N·s, and Σ κ of the elements around it, N/m.
pub type Accumulated = [f64; 4];

/// The nodes of one block while it is swept.
#[derive(Debug)]
pub struct Local {
    pub(super) rows: Box<Aligned<Row>>,
    pub(super) accumulated: Box<Aligned<Accumulated>>,
}

/// What belongs to the nodes of a block, each in one line of the cache.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Aligned<T>(pub [T; MOST_LOCAL_NODES]);

impl Local {
    /// Room for the nodes of any block.
    #[must_use]
    #[allow(
        clippy::large_stack_arrays,
        reason = "a quarter of a megabyte, on its way to the heap: a vector would not keep the lines"
    )]
    pub fn new() -> Self {
        let rows = Box::new(Aligned([[0.0; 8]; MOST_LOCAL_NODES]));
        Self { rows, accumulated: Box::new(Aligned([[0.0; 4]; MOST_LOCAL_NODES])) }
    }

    /// Sets displacement and velocity of a node, and nothing accumulated.
    #[inline]
    pub fn load<const D: usize>(&mut self, node: usize, displacement: &Vector<D>, velocity: &Vector<D>) {
        let row = &mut self.rows.0[node];
        for i in 0..D {
            (row[i], row[4 + i]) = (displacement[i], velocity[i]);
        }
        self.accumulated.0[node] = [0.0; 4];
    }

    /// What the sweep left at the first nodes.
    #[must_use]
    pub fn accumulated(&self, n_nodes: usize) -> &[Accumulated] {
        &self.accumulated.0[..n_nodes]
    }
}

impl Default for Local {
    fn default() -> Self {
        Self::new()
    }
}
