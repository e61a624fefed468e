//! What eight elements remember, side by side.

use super::Memory;
use super::batch::{LANES, Wide};
use crate::algebra::Tensor;

/// What the k-th elements of eight patches remember, a [`Memory`] in each lane.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub struct Recall<const D: usize> {
    /// C̄_p⁻¹, its components of i ≤ j.
    pub(super) inverse: [[Wide; D]; D],
    pub(super) out: Wide,
    pub(super) plastic: Wide,
    pub(super) jacobian: Wide,
    pub(super) rate: Wide,
    pub(super) left: Wide,
    /// What viscosity added to U′ at the last own tick, Pa; of no use after it.
    pub(super) viscous: Wide,
}

impl<const D: usize> Default for Recall<D> {
    fn default() -> Self {
        let (none, one) = ([0.0; LANES], [1.0; LANES]);
        let mut inverse = [[none; D]; D];
        (0..D).for_each(|i| inverse[i][i] = one);
        Self { inverse, out: one, plastic: none, jacobian: one, rate: none, left: one, viscous: none }
    }
}

impl<const D: usize> Recall<D> {
    /// The memory in a lane.
    #[must_use]
    pub fn get(&self, lane: usize) -> Memory<D> {
        Memory {
            inverse: Tensor::<D>::from_fn(|i, j| self.inverse[i.min(j)][i.max(j)][lane]),
            out: self.out[lane],
            plastic: self.plastic[lane],
            jacobian: self.jacobian[lane],
            rate: self.rate[lane],
            left: self.left[lane],
        }
    }

    /// Puts a memory into a lane.
    pub fn set(&mut self, lane: usize, memory: &Memory<D>) {
        for (i, row) in self.inverse.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(j, wide)| wide[lane] = memory.inverse[(i, j)]);
        }
        self.out[lane] = memory.out;
        self.plastic[lane] = memory.plastic;
        self.jacobian[lane] = memory.jacobian;
        self.rate[lane] = memory.rate;
        self.left[lane] = memory.left;
    }

    /// What viscosity added to U′ of the element in a lane at its last own tick, Pa.
    #[must_use]
    pub fn viscous(&self, lane: usize) -> f64 {
        self.viscous[lane]
    }
}
