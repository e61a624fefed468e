//! What an element of an old mesh hands on of its deformation.

use super::history::Past;
use crate::algebra::{Tensor, Vector, cube_root, det};
use crate::mesh::ElementId;

/// Ī₁ of what is not distorted.
pub(super) const UNDISTORTED: f64 = 3.0;

/// F and the stretch out of the plane.
#[derive(Clone, Copy)]
pub(super) struct Strain<const D: usize> {
    pub f: Tensor<D>,
    pub out: f64,
}

impl<const D: usize> Strain<D> {
    /// Of an old element, or the elastic part where it flows; none of one that is inside out then.
    pub fn of(past: &Past<'_, D>, x: &[Vector<D>], element: ElementId) -> Self {
        let (f, out) = match past.memory.get(element.index()) {
            Some(memory) => {
                past.potential.elastic(element, x, memory).unwrap_or_else(|| (Tensor::<D>::identity(), 1.0))
            }
            None => past.potential.deformation(element, x),
        };
        Self { f, out }
    }

    pub fn zero() -> Self {
        Self { f: Tensor::<D>::zeros(), out: 0.0 }
    }

    pub fn plus(&self, other: &Self, part: f64) -> Self {
        Self { f: self.f + other.f * part, out: self.out + other.out * part }
    }

    /// From this one to another.
    pub fn between(&self, other: &Self, part: f64) -> Self {
        Self::zero().plus(self, 1.0 - part).plus(other, part)
    }

    /// F C, λ³: along the same axes, but stretched three times as far.
    pub fn thrice(&self) -> Self {
        Self { f: self.f * self.f.transpose() * self.f, out: self.out * self.out * self.out }
    }

    /// F undistorted, but turned as it is: its first column in its direction, the others at right angles (Gram, Schmidt). All that lies
    /// between it and F is upright if F is.
    pub fn turning(&self) -> Self {
        let mut axes = self.f;
        for i in 0..D {
            let mut axis = axes.column(i).into_owned();
            for k in 0..i {
                let other = axes.column(k).into_owned();
                axis -= other * other.dot(&axis);
            }
            axes.set_column(i, &(axis / axis.norm()));
        }
        Self { f: axes, out: 1.0 }
    }

    /// Ī₁ = tr(FᵀF)/J^⅔: what a distortion costs, whatever the volume.
    pub fn distortion(&self) -> f64 {
        let root = cube_root(det(&self.f) * self.out);
        self.square() / (root * root)
    }

    /// I₁ = tr(FᵀF): a solid stores μ/2 (I₁ − 3) beside what its volume does, also where it is nearly flat and Ī₁ is beyond all bounds.
    pub fn square(&self) -> f64 {
        let across = if D == 2 { self.out * self.out } else { 0.0 };
        self.f.norm_squared() + across
    }
}
