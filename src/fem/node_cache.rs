//! The nodes of a run of elements, numbered by themselves, while it is swept: small enough for the nearest cache.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::Spent;
use super::batch::on;
use crate::math::Vector;
use crate::mesh::NodeId;
use fearless_simd::{Level, Simd, SimdBase, f64x4};

/// Most nodes that a block may number for itself.
pub const MOST_LOCAL_NODES: usize = 4096;

/// Where a node is (up to three components), m, or how fast, m/s; of where it is last whether it has moved: 1 or 0.
pub type Row = [f64; 4];
/// Impulse of a node (three components), N·s, and Σ κ of the elements around it, N/m.
pub type Accumulated = [f64; 4];

/// Numbers of a row, and of a line of the cache.
const ROW: usize = 4;
const LINE: usize = 8;
/// Where the row of a node begins is a `u16`, and so many rows there are that nobody need look whether it is one of them: what a
/// block has not is never touched.
const NUMBERS: usize = (1 << 16) + ROW;

/// Four numbers of each node of a block, node by node.
pub(super) type Rows = [f64; NUMBERS];

/// Where the row of a node begins, by its number within the block.
///
/// # Panics
/// If no block has so many nodes.
#[must_use]
pub(super) fn row_of(number: u16) -> u16 {
    assert!(usize::from(number) < MOST_LOCAL_NODES, "a block numbers no more nodes");
    number * ROW as u16
}

/// The number of the node whose row begins there.
#[inline]
#[must_use]
pub(super) fn number_of(first: u16) -> u16 {
    first / ROW as u16
}

/// The row that begins there.
#[inline(always)]
pub(super) fn row(rows: &Rows, first: u16) -> &[f64] {
    &rows[usize::from(first)..usize::from(first) + ROW]
}

/// The same, to be changed.
#[inline(always)]
pub(super) fn row_mut(rows: &mut Rows, first: u16) -> &mut [f64] {
    &mut rows[usize::from(first)..usize::from(first) + ROW]
}

/// A node as it was at its last tick.
#[derive(Debug, Clone, Copy)]
pub struct At<'a, const D: usize> {
    /// Where it was, m.
    pub position: &'a Vector<D>,
    /// How fast it is since, m/s.
    pub velocity: &'a Vector<D>,
    /// Where it rests, m.
    pub rest: &'a Vector<D>,
    /// How long ago its last tick was, s.
    pub passed: f64,
}

/// Who knows where nodes are.
pub trait Whereabouts<const D: usize>: Copy {
    /// A node as it was at its last tick.
    fn of(&self, node: NodeId) -> At<'_, D>;

    /// Asks for what belongs to a node before it is needed.
    fn fetch(&self, _node: NodeId) {}
}

/// Nodes that are held where they are.
#[derive(Debug, Clone, Copy)]
pub struct Held<'a, const D: usize> {
    position: &'a [Vector<D>],
    rest: &'a [Vector<D>],
    /// Zero, m/s.
    velocity: Vector<D>,
}

impl<'a, const D: usize> Held<'a, D> {
    /// Where they are and where they rest, m.
    #[must_use]
    pub fn new(position: &'a [Vector<D>], rest: &'a [Vector<D>]) -> Self {
        Self { position, rest, velocity: Vector::<D>::zeros() }
    }
}

impl<const D: usize> Whereabouts<D> for Held<'_, D> {
    fn of(&self, node: NodeId) -> At<'_, D> {
        let a = node.index();
        At { position: &self.position[a], velocity: &self.velocity, rest: &self.rest[a], passed: 0.0 }
    }
}

/// How many nodes before it is loaded a node is asked for, where it is asked for at all; of whole blocks 12 to 96 are as good.
const AHEAD: usize = 24;

/// The nodes of one block while it is swept.
#[derive(Debug)]
pub struct Local {
    /// Up to which component of its displacement a node is where it is at rest, m.
    still: f64,
    /// Greatest |v|² of the nodes that were loaded, m²/s².
    pub(super) fastest: f64,
    /// What those that were swept last store, and what they have lost.
    pub(super) spent: Spent,
    positions: Aligned,
    velocities: Aligned,
    accumulated: Aligned,
}

/// Rows, none of which lies in two lines of the cache.
#[derive(Debug)]
struct Aligned {
    numbers: Vec<f64>,
    first: usize,
}

impl Aligned {
    /// All zero: of that the system gives as much as is touched.
    fn new() -> Self {
        let numbers = vec![0.0; NUMBERS + LINE];
        // Where it can't be told, some rows lie in two lines.
        let first = numbers.as_ptr().align_offset(LINE * size_of::<f64>());
        Self { first: if first < LINE { first } else { 0 }, numbers }
    }

    #[inline]
    fn rows(&self) -> &Rows {
        self.numbers[self.first..].first_chunk().expect("there is a line more")
    }

    #[inline]
    fn rows_mut(&mut self) -> &mut Rows {
        self.numbers[self.first..].first_chunk_mut().expect("there is a line more")
    }
}

/// With zeros.
#[inline(always)]
fn four<const D: usize, S: Simd>(simd: S, v: &Vector<D>) -> f64x4<S> {
    let of = |i: usize| if i < D { v[i] } else { 0.0 };
    f64x4::from_slice(simd, &[of(0), of(1), of(2), 0.0])
}

/// To what the greatest of these positions is rounded, m.
#[must_use]
pub fn rounding<const D: usize>(positions: &[Vector<D>]) -> f64 {
    f64::EPSILON * positions.iter().map(Vector::<D>::amax).fold(0.0, f64::max)
}

impl Local {
    /// Room for the nodes of any block of a gel whose positions are rounded to `still`, m: what stands no farther from where it rests
    /// is taken to rest, as its force would be one of rounding.
    #[must_use]
    pub fn new(still: f64) -> Self {
        let [positions, velocities, accumulated] = [Aligned::new(), Aligned::new(), Aligned::new()];
        Self { still, fastest: 0.0, spent: Spent::default(), positions, velocities, accumulated }
    }

    /// Another block begins.
    pub fn begin(&mut self) {
        self.fastest = 0.0;
        // Empty lanes name node 0; what another block left there must not come in.
        for all in [&mut self.positions, &mut self.velocities, &mut self.accumulated] {
            row_mut(all.rows_mut(), 0).fill(0.0);
        }
    }

    /// Loads nodes of a block that has [begun](Self::begin), each with its number: where it is now, how fast, and nothing accumulated. Whether
    /// one of them has moved or moves.
    pub fn load<const D: usize>(
        &mut self,
        level: Level,
        whereabouts: &impl Whereabouts<D>,
        nodes: impl Iterator<Item = (usize, NodeId)> + Clone,
    ) -> bool {
        on!(level, simd => self.load_in(simd, whereabouts, nodes))
    }

    #[inline(always)]
    fn load_in<const D: usize, S: Simd>(
        &mut self,
        simd: S,
        whereabouts: &impl Whereabouts<D>,
        nodes: impl Iterator<Item = (usize, NodeId)> + Clone,
    ) -> bool {
        let places: &mut [Row] = &mut self.positions.rows_mut().as_chunks_mut().0[..MOST_LOCAL_NODES];
        let speeds: &mut [Row] = &mut self.velocities.rows_mut().as_chunks_mut().0[..MOST_LOCAL_NODES];
        let sums: &mut [Accumulated] = &mut self.accumulated.rows_mut().as_chunks_mut().0[..MOST_LOCAL_NODES];
        let (none, still) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, self.still));
        // Its own: what is written here can't change it.
        let whereabouts = *whereabouts;
        // Sums of what has no sign: they are zero only where all of it is.
        let (mut far, mut fast) = (none, none);
        let (mut fastest, mut ahead) = (self.fastest, nodes.clone().skip(AHEAD));
        for (number, node) in nodes {
            if let Some((_, later)) = ahead.next() {
                whereabouts.fetch(later);
            }
            let At { position, velocity, rest, passed } = whereabouts.of(node);
            let speed = four(simd, velocity);
            let place = four(simd, position) + speed * passed;
            let away = place - four(simd, rest);
            place.store_slice(&mut places[number]);
            let has_moved = simd.to_bitmask_mask64x4(away.abs().simd_gt(still)) != 0;
            places[number][3] = if has_moved { 1.0 } else { 0.0 };
            speed.store_slice(&mut speeds[number]);
            none.store_slice(&mut sums[number]);
            (far, fast) = (far + away.abs(), fast + speed.abs());
            let square = velocity.norm_squared();
            fastest = if square > fastest { square } else { fastest };
        }
        self.fastest = fastest;
        let rests = far.simd_eq(none) & fast.simd_eq(none);
        simd.to_bitmask_mask64x4(rests) != 0b1111
    }

    /// Where the nodes are, and how fast.
    #[inline]
    pub(super) fn motion(&self) -> [&Rows; 2] {
        [self.positions.rows(), self.velocities.rows()]
    }

    /// The same, and what is accumulated at them.
    #[inline]
    pub(super) fn at_work(&mut self) -> ([&Rows; 2], &mut Rows) {
        ([self.positions.rows(), self.velocities.rows()], self.accumulated.rows_mut())
    }

    /// What the sweep left at the first nodes.
    ///
    /// # Panics
    /// If no block has so many nodes.
    #[must_use]
    pub fn accumulated(&self, n_nodes: usize) -> &[Accumulated] {
        &self.accumulated.rows().as_chunks().0[..MOST_LOCAL_NODES][..n_nodes]
    }

    /// What the groups that the last sweep has gone through store, and what they have lost since the tick before of each.
    #[must_use]
    pub fn spent(&self) -> Spent {
        self.spent
    }

    /// Σ p·v over the first nodes of what the sweep left there, J.
    ///
    /// # Panics
    /// If no block has so many nodes.
    #[must_use]
    pub fn work(&self, n_nodes: usize) -> f64 {
        let mut sums = [0.0; 3];
        let velocities: &[Row] = self.velocities.rows().as_chunks().0;
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
    fn what_a_block_left_at_node_0_does_not_come_into_the_next_one() {
        let none = vec![Vector::<3>::from_element(f64::NAN); 2];
        let rest = vec![Vector::<3>::zeros(), Vector::<3>::new(1.0, 2.0, 3.0)];
        let mut local = Local::new(1e-15);
        local.begin();
        assert!(local.load(Level::new(), &Held::new(&none, &rest), [(0, NodeId(0)), (1, NodeId(1))].into_iter()));
        assert!(row(local.motion()[0], 0)[0].is_nan());
        local.begin();
        assert!(!local.load(Level::new(), &Held::new(&rest, &rest), std::iter::once((5, NodeId(1)))));
        for rows in local.motion() {
            assert_eq!(row(rows, 0), [0.0; 4]);
        }
        assert_eq!(local.accumulated(1), [[0.0; 4]]);
        assert_eq!(row(local.motion()[0], row_of(5)), [1.0, 2.0, 3.0, 0.0]);
    }
}
