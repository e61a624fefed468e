//! The nodes of a run of elements, numbered by themselves, while it is swept: small enough for the nearest cache.

use crate::algebra::Vector;

/// Most nodes that a block may number for itself.
pub const MOST_LOCAL_NODES: usize = 4096;

/// Where a node is (up to three components), m, or how fast, m/s; of where it is last whether it has moved: 1 or 0.
pub type Row = [f64; 4];
/// Impulse of a node (three components), N·s, and Σ κ of the elements around it, N/m.
pub type Accumulated = [f64; 4];

/// The nodes of one block while it is swept.
#[derive(Debug)]
pub struct Local {
    /// Up to which component of its displacement a node is where it is at rest, m.
    still: f64,
    /// Greatest |v|² of the nodes that were loaded, m²/s².
    pub(super) fastest: f64,
    pub(super) positions: Box<Aligned<Row>>,
    pub(super) velocities: Box<Aligned<Row>>,
    pub(super) accumulated: Box<Aligned<Accumulated>>,
}

/// What belongs to the nodes of a block, each in one half of a line of the cache.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct Aligned<T>([T; MOST_LOCAL_NODES]);

impl<T> Aligned<T> {
    /// That of a node; its number is below [`MOST_LOCAL_NODES`], which is said so that nobody need look.
    #[inline]
    pub fn of(&self, number: u16) -> &T {
        &self.0[usize::from(number) % MOST_LOCAL_NODES]
    }

    /// The same, to be changed.
    #[inline]
    pub fn of_mut(&mut self, number: u16) -> &mut T {
        &mut self.0[usize::from(number) % MOST_LOCAL_NODES]
    }
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
    #[allow(
        clippy::large_stack_arrays,
        reason = "an eighth of a megabyte, on its way to the heap: a vector would not keep the lines"
    )]
    pub fn new(still: f64) -> Self {
        let none = || Box::new(Aligned([[0.0; 4]; MOST_LOCAL_NODES]));
        Self { still, fastest: 0.0, positions: none(), velocities: none(), accumulated: none() }
    }

    /// Another block begins.
    pub fn begin(&mut self) {
        self.fastest = 0.0;
    }

    /// Sets where a node is, how far from where it is at rest, and how fast, and nothing accumulated.
    #[inline]
    pub fn load<const D: usize>(&mut self, number: usize, [position, displacement, velocity]: [&Vector<D>; 3]) {
        let (place, speed) = (&mut self.positions.0[number], &mut self.velocities.0[number]);
        for i in 0..D {
            (place[i], speed[i]) = (position[i], velocity[i]);
        }
        self.fastest = self.fastest.max(velocity.norm_squared());
        place[3] = if displacement.amax() > self.still { 1.0 } else { 0.0 };
        self.accumulated.0[number] = [0.0; 4];
    }

    /// What the sweep left at the first nodes.
    #[must_use]
    pub fn accumulated(&self, n_nodes: usize) -> &[Accumulated] {
        &self.accumulated.0[..n_nodes]
    }

    /// Σ p·v over the first nodes of what the sweep left there, J.
    #[must_use]
    pub fn work(&self, n_nodes: usize) -> f64 {
        let mut sums = [0.0; 3];
        for (push, velocity) in self.accumulated.0[..n_nodes].iter().zip(&self.velocities.0) {
            (0..3).for_each(|i| sums[i] += push[i] * velocity[i]);
        }
        sums[0] + sums[1] + sums[2]
    }
}
