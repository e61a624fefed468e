//! Node cache of a block: positions, velocities and sums of its nodes during a sweep, small enough for the nearest
//! cache.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::batch::on;
use crate::fem::Dissipation;
use crate::math::Vector;
use crate::mesh::NodeId;
use fearless_simd::{Level, Simd, SimdBase, f64x4};

/// Most nodes of a block.
pub const MOST_LOCAL_NODES: usize = 4096;

/// Row of a node: up to three components of the position, m, or velocity, m/s.
///
/// The last number of a position row is 1 for a moved node, else 0.
pub type NodeRow = [f64; 4];
/// Sums at a node: the impulse (three components), N·s, and Σ κ of the adjacent elements, N/m.
pub type NodeAccumulator = [f64; 4];

/// Numbers of a row.
const ROW: usize = 4;
/// Numbers of a cache line.
const LINE: usize = 8;
/// Numbers of all rows: every `u16` offset is in bounds, so no access needs a bounds check; unused rows are never
/// touched.
const NUMBERS: usize = (1 << 16) + ROW;

/// Rows of all nodes of a block, node by node.
pub(crate) type NodeRows = [f64; NUMBERS];

/// Returns the first number of the row of a node, from its number within the block.
///
/// # Panics
/// If the number is not below [`MOST_LOCAL_NODES`].
#[must_use]
pub(super) fn row_of(number: u16) -> u16 {
    assert!(usize::from(number) < MOST_LOCAL_NODES, "a block numbers no more nodes");
    number * ROW as u16
}

/// Returns the node number of the row at an offset.
#[inline]
#[must_use]
pub(super) fn number_of(first: u16) -> u16 {
    first / ROW as u16
}

/// Returns the row at an offset.
#[inline(always)]
pub(super) fn row(rows: &NodeRows, first: u16) -> &[f64] {
    &rows[usize::from(first)..usize::from(first) + ROW]
}

/// Returns the row at an offset, mutable.
#[inline(always)]
pub(super) fn row_mut(rows: &mut NodeRows, first: u16) -> &mut [f64] {
    &mut rows[usize::from(first)..usize::from(first) + ROW]
}

/// State of a node at its last tick.
#[derive(Debug, Clone, Copy)]
pub struct NodeMotion<'a, const D: usize> {
    /// Position, m.
    pub position: &'a Vector<D>,
    /// Velocity since then, m/s.
    pub velocity: &'a Vector<D>,
    /// Rest position, m.
    pub rest: &'a Vector<D>,
    /// Time since the last tick, s.
    pub passed: f64,
}

/// Source of nodal states.
pub trait NodeSource<const D: usize>: Copy {
    /// Returns the state of a node at its last tick.
    fn of(&self, node: NodeId) -> NodeMotion<'_, D>;
}

/// Nodes at given positions, with zero velocity.
#[derive(Debug, Clone, Copy)]
pub struct HeldNodes<'a, const D: usize> {
    position: &'a [Vector<D>],
    rest: &'a [Vector<D>],
    /// Zero, m/s.
    velocity: Vector<D>,
}

impl<'a, const D: usize> HeldNodes<'a, D> {
    /// Creates the source from positions and rest positions, m.
    #[must_use]
    pub fn new(position: &'a [Vector<D>], rest: &'a [Vector<D>]) -> Self {
        Self { position, rest, velocity: Vector::<D>::zeros() }
    }
}

impl<const D: usize> NodeSource<D> for HeldNodes<'_, D> {
    fn of(&self, node: NodeId) -> NodeMotion<'_, D> {
        let a = node.index();
        NodeMotion { position: &self.position[a], velocity: &self.velocity, rest: &self.rest[a], passed: 0.0 }
    }
}

/// Node cache of one block during a sweep.
#[derive(Debug)]
pub struct NodeCache {
    /// Greatest component of a displacement that counts as rest, m.
    still: f64,
    /// Greatest |v|² of the loaded nodes, m²/s².
    max_squared_speed: f64,
    /// Energy and dissipation of the last sweep.
    pub(super) spent: Dissipation,
    positions: AlignedRows,
    velocities: AlignedRows,
    accumulated: AlignedRows,
}

/// Access to the nodes of a block for a sweep.
pub(super) struct NodeAccess<'a> {
    /// Rows of positions, m, and velocities, m/s.
    pub motion: [&'a NodeRows; 2],
    /// Greatest |v|² of the nodes, m²/s².
    pub max_squared_speed: f64,
    /// Rows of [`NodeAccumulator`] sums.
    pub accumulated: &'a mut NodeRows,
}

/// Rows aligned to cache lines, so no row spans two lines.
#[derive(Debug)]
struct AlignedRows {
    numbers: Vec<f64>,
    first: usize,
}

impl AlignedRows {
    /// Allocates zeroed rows; the system provides only the touched pages.
    fn new() -> Self {
        let numbers = vec![0.0; NUMBERS + LINE];
        // Without a known offset some rows span two lines.
        let first = numbers.as_ptr().align_offset(LINE * size_of::<f64>());
        Self { first: if first < LINE { first } else { 0 }, numbers }
    }

    #[inline]
    fn rows(&self) -> &NodeRows {
        self.numbers[self.first..].first_chunk().expect("there is a line more")
    }

    #[inline]
    fn rows_mut(&mut self) -> &mut NodeRows {
        self.numbers[self.first..].first_chunk_mut().expect("there is a line more")
    }
}

/// Pads a vector with zeros to four numbers.
#[inline(always)]
fn padded<const D: usize, S: Simd>(simd: S, v: &Vector<D>) -> f64x4<S> {
    let of = |i: usize| if i < D { v[i] } else { 0.0 };
    f64x4::from_slice(simd, &[of(0), of(1), of(2), 0.0])
}

/// Returns the rounding unit of the greatest coordinate, m.
#[must_use]
pub fn rounding<const D: usize>(positions: &[Vector<D>]) -> f64 {
    f64::EPSILON * positions.iter().map(Vector::<D>::amax).fold(0.0, f64::max)
}

impl NodeCache {
    /// Creates a cache for any block of a gel with positions rounded to `still`, m.
    ///
    /// A node displaced by no more than `still` counts as at rest, since its force would be rounding.
    #[must_use]
    pub fn new(still: f64) -> Self {
        let [positions, velocities, accumulated] = [AlignedRows::new(), AlignedRows::new(), AlignedRows::new()];
        Self { still, max_squared_speed: 0.0, spent: Dissipation::default(), positions, velocities, accumulated }
    }

    /// Resets the cache for another block.
    pub fn begin(&mut self) {
        self.max_squared_speed = 0.0;
        // Empty lanes use node 0, so values of another block must be cleared there.
        for all in [&mut self.positions, &mut self.velocities, &mut self.accumulated] {
            row_mut(all.rows_mut(), 0).fill(0.0);
        }
    }

    /// Loads the present positions and velocities of numbered nodes and zeroes their sums, after [`Self::begin`].
    ///
    /// Returns true if a node is displaced or moves.
    pub fn load<const D: usize>(
        &mut self,
        level: Level,
        whereabouts: &impl NodeSource<D>,
        nodes: impl Iterator<Item = (usize, NodeId)>,
    ) -> bool {
        on!(level, simd => self.load_in(simd, whereabouts, nodes))
    }

    #[inline(always)]
    fn load_in<const D: usize, S: Simd>(
        &mut self,
        simd: S,
        whereabouts: &impl NodeSource<D>,
        nodes: impl Iterator<Item = (usize, NodeId)>,
    ) -> bool {
        let positions: &mut [NodeRow] = &mut self.positions.rows_mut().as_chunks_mut().0[..MOST_LOCAL_NODES];
        let velocities: &mut [NodeRow] = &mut self.velocities.rows_mut().as_chunks_mut().0[..MOST_LOCAL_NODES];
        let sums: &mut [NodeAccumulator] = &mut self.accumulated.rows_mut().as_chunks_mut().0[..MOST_LOCAL_NODES];
        let (zero, still) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, self.still));
        // Local copy, which no write below can alias.
        let whereabouts = *whereabouts;
        // Sums of absolute values: zero only if every term is zero.
        let (mut displaced, mut moving) = (zero, zero);
        let mut max_squared_speed = self.max_squared_speed;
        for (number, node) in nodes {
            let NodeMotion { position, velocity, rest, passed } = whereabouts.of(node);
            let rate = padded(simd, velocity);
            let present = padded(simd, position) + rate * passed;
            let displacement = present - padded(simd, rest);
            present.store_slice(&mut positions[number]);
            let has_moved = simd.to_bitmask_mask64x4(displacement.abs().simd_gt(still)) != 0;
            positions[number][3] = if has_moved { 1.0 } else { 0.0 };
            rate.store_slice(&mut velocities[number]);
            zero.store_slice(&mut sums[number]);
            (displaced, moving) = (displaced + displacement.abs(), moving + rate.abs());
            let square = velocity.norm_squared();
            max_squared_speed = if square > max_squared_speed { square } else { max_squared_speed };
        }
        self.max_squared_speed = max_squared_speed;
        let rests = displaced.simd_eq(zero) & moving.simd_eq(zero);
        simd.to_bitmask_mask64x4(rests) != 0b1111
    }

    /// Returns the rows of positions and velocities.
    #[inline]
    pub(crate) fn motion(&self) -> [&NodeRows; 2] {
        [self.positions.rows(), self.velocities.rows()]
    }

    /// Returns access to the nodes for a sweep.
    #[inline]
    pub(super) fn access(&mut self) -> NodeAccess<'_> {
        NodeAccess {
            motion: [self.positions.rows(), self.velocities.rows()],
            max_squared_speed: self.max_squared_speed,
            accumulated: self.accumulated.rows_mut(),
        }
    }

    /// Returns the sums that the sweep left at the first nodes.
    ///
    /// # Panics
    /// If `n_nodes` exceeds [`MOST_LOCAL_NODES`].
    #[must_use]
    pub fn accumulated(&self, n_nodes: usize) -> &[NodeAccumulator] {
        &self.accumulated.rows().as_chunks().0[..MOST_LOCAL_NODES][..n_nodes]
    }

    /// Returns the energy and dissipation of the groups of the last sweep, each since its previous tick.
    #[must_use]
    pub fn spent(&self) -> Dissipation {
        self.spent
    }

    /// Returns the work Σ p·v of the impulses at the first nodes, J.
    ///
    /// # Panics
    /// If `n_nodes` exceeds [`MOST_LOCAL_NODES`].
    #[must_use]
    pub fn work(&self, n_nodes: usize) -> f64 {
        let mut sums = [0.0; 3];
        let velocities: &[NodeRow] = self.velocities.rows().as_chunks().0;
        for (push, velocity) in self.accumulated(n_nodes).iter().zip(velocities) {
            (0..3).for_each(|i| sums[i] += push[i] * velocity[i]);
        }
        sums[0] + sums[1] + sums[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_at_node_0_do_not_carry_over_to_the_next_block() {
        let none = vec![Vector::<3>::from_element(f64::NAN); 2];
        let rest = vec![Vector::<3>::zeros(), Vector::<3>::new(1.0, 2.0, 3.0)];
        let mut local = NodeCache::new(1e-15);
        local.begin();
        assert!(local.load(Level::new(), &HeldNodes::new(&none, &rest), [(0, NodeId(0)), (1, NodeId(1))].into_iter()));
        assert!(row(local.motion()[0], 0)[0].is_nan());
        local.begin();
        assert!(!local.load(Level::new(), &HeldNodes::new(&rest, &rest), std::iter::once((5, NodeId(1)))));
        for rows in local.motion() {
            assert_eq!(row(rows, 0), [0.0; 4]);
        }
        assert_eq!(local.accumulated(1), [[0.0; 4]]);
        assert_eq!(row(local.motion()[0], row_of(5)), [1.0, 2.0, 3.0, 0.0]);
    }
}
