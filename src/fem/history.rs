//! History variables of elements: by element, and in rows, of one element or of eight in vector lanes.

#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use crate::constitutive::TwoNetwork;
use crate::math::{Number, SymmetricTensor, Tensor, array};

/// Record of the history variables of a two-network element: of its elastic network, of its deformation at the last
/// tick, or of a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistoryVariables<const D: usize> {
    /// Tensor of unit determinant together with `out`, initially 1: A of the elastic network, C̄⁻¹ at the last tick, or
    /// C̄_i⁻¹ of a branch.
    pub inverse: Tensor<D>,
    /// Out-of-plane component of the tensor; 1 in space.
    pub out: f64,
    /// J at the last tick of the patch (first record).
    pub jacobian: f64,
    /// Damage d of the elastic network, 0 to 1 (first record).
    pub damage: f64,
    /// Equivalent stress q at the last tick, Pa (branch of a power law).
    pub stress: f64,
}

impl<const D: usize> Default for HistoryVariables<D> {
    fn default() -> Self {
        Self { inverse: Tensor::<D>::identity(), out: 1.0, jacobian: 1.0, damage: 0.0, stress: 0.0 }
    }
}

impl<const D: usize> HistoryVariables<D> {
    /// Returns true if all variables are finite.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let Self { inverse, out, jacobian, damage, stress } = self;
        inverse.iter().chain([out, jacobian, damage, stress]).all(|number| number.is_finite())
    }

    /// Returns the tensor of the record.
    pub(crate) fn tensor(&self) -> SymmetricTensor<D, f64> {
        SymmetricTensor { inner: array::rows(&self.inverse), out: if D == 2 { self.out } else { 0.0 } }
    }
}

/// Most records of an element.
pub(crate) const MOST_MEMORIES: usize = 2 + TwoNetwork::MOST_BRANCHES;
/// Most history rows of an element: a tensor and three more numbers of each record.
pub(crate) const MOST_ROWS: usize = MOST_MEMORIES * (shape_rows::<3>() + 3);

/// One history variable of the k-th elements of eight patches; of one element where `L` is a number.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct HistoryLanes<L = [f64; 8]>(pub(crate) L);

/// Order of the history variables of a material in rows, one number of an element to a row; no rows by default.
pub(crate) trait HistoryLayout<const D: usize> {
    /// Returns the number of rows.
    fn rows(&self) -> usize {
        0
    }
    /// Writes the records of an element to its rows.
    fn store_history(&self, _rows: &mut [f64], _memory: &[HistoryVariables<D>]) {}
    /// Reads the records of an element from its rows.
    fn load_history(&self, _rows: &[f64], _memory: &mut [HistoryVariables<D>]) {}
    /// Returns the viscous part of U′ of an element at its last tick, Pa.
    fn viscous(&self, _rows: &[f64]) -> f64 {
        0.0
    }
    /// Sets the viscous part of U′ of an element for a re-evaluation at its last tick, Pa.
    fn hold_viscous(&self, _rows: &mut [f64], _viscous: f64) {}
}

/// Returns the number of rows of C̄⁻¹: the components i ≤ j, and in the plane the out-of-plane component.
pub(crate) const fn shape_rows<const D: usize>() -> usize {
    if D == 2 { 4 } else { 6 }
}

/// Writes C̄⁻¹ to its rows.
pub(crate) fn store_shape<const D: usize>(rows: &mut [f64], memory: &HistoryVariables<D>) {
    let components = (0..D).flat_map(|i| (i..D).map(move |j| memory.inverse[(i, j)]));
    let numbers = components.chain((D == 2).then_some(memory.out));
    rows.iter_mut().zip(numbers).for_each(|(row, number)| *row = number);
}

/// Reads C̄⁻¹ from its rows; the other history variables keep their initial values.
pub(crate) fn load_shape<const D: usize>(rows: &[f64]) -> HistoryVariables<D> {
    // Packed upper triangle: row i has D − i components.
    let at = |i: usize, j: usize| i * D - i * (i + 1) / 2 + j;
    let inverse = Tensor::<D>::from_fn(|i, j| rows[at(i.min(j), i.max(j))]);
    let out = if D == 2 { rows[shape_rows::<D>() - 1] } else { 1.0 };
    HistoryVariables { inverse, out, ..HistoryVariables::default() }
}

/// Loads a symmetric tensor from its rows.
#[inline(always)]
pub(crate) fn load_tensor<const D: usize, V: Number>(
    zero: V,
    rows: &[HistoryLanes<V::Lanes>],
) -> SymmetricTensor<D, V> {
    let rows = &rows[..shape_rows::<D>()];
    let (mut inner, mut at) = ([[zero; D]; D], 0);
    for i in 0..D {
        for j in i..D {
            inner[i][j] = zero.load(&rows[at].0);
            at += 1;
        }
    }
    SymmetricTensor { inner, out: if D == 2 { zero.load(&rows[at].0) } else { zero } }
}

/// Stores a symmetric tensor in its rows.
#[inline(always)]
pub(crate) fn store_tensor<const D: usize, V: Number>(
    tensor: &SymmetricTensor<D, V>,
    rows: &mut [HistoryLanes<V::Lanes>],
) {
    let rows = &mut rows[..shape_rows::<D>()];
    let mut at = 0;
    for i in 0..D {
        for j in i..D {
            rows[at].0 = tensor.inner[i][j].store();
            at += 1;
        }
    }
    if D == 2 {
        rows[at].0 = tensor.out.store();
    }
}
