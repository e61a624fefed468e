//! History variables of elements: by element, and of eight elements in vector lanes.

use super::batch::LaneArray;
use crate::math::Tensor;

/// History variables of a viscoplastic element, or of one branch of a viscoelastic element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistoryVariables<const D: usize> {
    /// C̄_p⁻¹ = (F_pᵀF_p)⁻¹, of unit determinant together with `out`, initially 1; C̄_i⁻¹ of a branch.
    pub inverse: Tensor<D>,
    /// Out-of-plane component of C̄_p⁻¹; 1 in space.
    pub out: f64,
    /// Equivalent plastic strain ε_p.
    pub plastic: f64,
    /// J at the last tick of the patch.
    pub jacobian: f64,
    /// Rate of ε_p at the last plastic step, 1/s.
    pub rate: f64,
    /// Damage factor g of the shear stress.
    pub left: f64,
    /// Equivalent stress q of the undamaged material at the last tick, Pa.
    pub stress: f64,
    /// Time-filtered U′ of the yield law, Pa.
    pub felt: f64,
}

impl<const D: usize> Default for HistoryVariables<D> {
    fn default() -> Self {
        let inverse = Tensor::<D>::identity();
        Self { inverse, out: 1.0, plastic: 0.0, jacobian: 1.0, rate: 0.0, left: 1.0, stress: 0.0, felt: 0.0 }
    }
}

impl<const D: usize> HistoryVariables<D> {
    /// Returns true if all variables are finite.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let Self { inverse, out, plastic, jacobian, rate, left, stress, felt } = self;
        let numbers = [out, plastic, jacobian, rate, left, stress, felt];
        inverse.iter().chain(numbers).all(|number| number.is_finite())
    }
}

/// One history variable of the k-th elements of eight patches.
#[derive(Debug, Clone, Copy, Default)]
#[repr(align(64))]
pub struct HistoryLanes(pub(super) LaneArray);

/// Layout of the history variables of a material in lanes, one row per variable; no rows by default.
pub(super) trait HistoryLayout<const D: usize> {
    /// Returns the number of rows.
    fn rows(&self) -> usize {
        0
    }
    /// Stores the history variables of an element in a lane.
    fn store_history(&self, _rows: &mut [HistoryLanes], _lane: usize, _memory: &[HistoryVariables<D>]) {}
    /// Loads the history variables of an element from a lane.
    fn load_history(&self, _rows: &[HistoryLanes], _lane: usize, _memory: &mut [HistoryVariables<D>]) {}
    /// Returns the viscous part of U′ of an element at its last tick, Pa.
    fn viscous(&self, _rows: &[HistoryLanes], _lane: usize) -> f64 {
        0.0
    }
}

/// Returns the number of rows of C̄⁻¹: the components i ≤ j, and in the plane the out-of-plane component.
pub(super) const fn shape_rows<const D: usize>() -> usize {
    if D == 2 { 4 } else { 6 }
}

/// Stores C̄⁻¹ in a lane.
pub(super) fn store_shape<const D: usize>(rows: &mut [HistoryLanes], lane: usize, memory: &HistoryVariables<D>) {
    let components = (0..D).flat_map(|i| (i..D).map(move |j| memory.inverse[(i, j)]));
    let numbers = components.chain((D == 2).then_some(memory.out));
    rows.iter_mut().zip(numbers).for_each(|(row, number)| row.0[lane] = number);
}

/// Loads C̄⁻¹ from a lane; the other history variables keep their initial values.
pub(super) fn load_shape<const D: usize>(rows: &[HistoryLanes], lane: usize) -> HistoryVariables<D> {
    // Packed upper triangle: row i has D − i components.
    let at = |i: usize, j: usize| i * D - i * (i + 1) / 2 + j;
    let inverse = Tensor::<D>::from_fn(|i, j| rows[at(i.min(j), i.max(j))].0[lane]);
    let out = if D == 2 { rows[shape_rows::<D>() - 1].0[lane] } else { 1.0 };
    HistoryVariables { inverse, out, ..HistoryVariables::default() }
}
