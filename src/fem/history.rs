//! What eight elements remember, side by side.

use super::Memory;
use super::batch::Wide;
use crate::math::Tensor;

/// A number that the k-th elements of eight patches remember.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct Recall(pub(super) Wide);

/// What the elements of a gel remember in lanes, a row for each number: nothing, unless it says more.
pub(super) trait Remembering<const D: usize> {
    /// Numbers of an element.
    fn rows(&self) -> usize {
        0
    }
    /// Puts what an element remembers into a lane.
    fn put_memory(&self, _rows: &mut [Recall], _lane: usize, _memory: &[Memory<D>]) {}
    /// Takes it from there.
    fn take_memory(&self, _rows: &[Recall], _lane: usize, _memory: &mut [Memory<D>]) {}
    /// What viscosity added to U′ of the element in a lane at its last own tick, Pa.
    fn viscous(&self, _rows: &[Recall], _lane: usize) -> f64 {
        0.0
    }
}

/// Rows of C̄⁻¹: its components of i ≤ j, and in the plane that out of it.
pub(super) const fn rows_of_shape<const D: usize>() -> usize {
    if D == 2 { 4 } else { 6 }
}

/// Puts the C̄⁻¹ of a memory into a lane.
pub(super) fn put_shape<const D: usize>(rows: &mut [Recall], lane: usize, memory: &Memory<D>) {
    let inner = (0..D).flat_map(|i| (i..D).map(move |j| memory.inverse[(i, j)]));
    let numbers = inner.chain((D == 2).then_some(memory.out));
    rows.iter_mut().zip(numbers).for_each(|(row, number)| row.0[lane] = number);
}

/// A memory of the C̄⁻¹ in a lane, else fresh.
pub(super) fn shape<const D: usize>(rows: &[Recall], lane: usize) -> Memory<D> {
    // Before row i stand i rows of one less each.
    let at = |i: usize, j: usize| i * D - i * (i + 1) / 2 + j;
    let inverse = Tensor::<D>::from_fn(|i, j| rows[at(i.min(j), i.max(j))].0[lane]);
    let out = if D == 2 { rows[rows_of_shape::<D>() - 1].0[lane] } else { 1.0 };
    Memory { inverse, out, ..Memory::default() }
}
