#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::neo_hookean::continued;
use super::{Volume, Volumetric};
use crate::math::{Number, Tensor};

/// An elastic gel without a memory: ψ = ψ_s(F) + U(J), an isotropic energy of the stretches that is defined for every F, turned inside
/// out or not, and one of the volume that keeps it upright.
pub trait Hyperelastic {
    /// U.
    fn volume(&self) -> Logarithmic;
    /// ψ_s at F, and at the stretch out of the plane, which is 1 in the plane and not looked at in space.
    fn sheared<const D: usize>(&self, f: &Tensor<D>, out: f64) -> Sheared<D>;
}

/// What the energy of the stretches of a gel is at one of its states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheared<const D: usize> {
    /// ψ_s, J/m³.
    pub energy: f64,
    /// ∂ψ_s/∂F, Pa.
    pub stress: Tensor<D>,
    /// The same by the stretch out of the plane, Pa; not looked at in space.
    pub out: f64,
    /// a and b of a bound of the curvature, Pa: d²ψ_s(F + tH)/dt² ≤ a|H|² + b(F:H)² for every H.
    pub curvature: [f64; 2],
}

/// U(J) = −m ln J + Λ/2 (ln J)², continued below [`NeoHookean::FLOOR`](super::NeoHookean::FLOOR) by its second-order Taylor polynomial.
///
/// m is what takes the stress of ψ_s from a gel at rest: ∂ψ_s/∂F = m 1 there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logarithmic {
    /// m, Pa.
    pub rest: f64,
    /// Λ, Pa.
    pub lambda: f64,
}

impl Volume for Logarithmic {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> Volumetric<T> {
        continued(self.rest, self.lambda, j)
    }

    /// −m ln J.
    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> Volumetric<T> {
        continued(self.rest, 0.0, j)
    }

    /// Λ/2 (ln J̄)².
    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> Volumetric<T> {
        continued(0.0, self.lambda, mean)
    }
}

/// C = FᵀF.
pub(super) fn right<const D: usize>(f: &Tensor<D>) -> Tensor<D> {
    f.transpose() * f
}

/// The square of a stretch out of the plane; none in space.
pub(super) fn across<const D: usize>(out: f64) -> f64 {
    if D == 2 { out * out } else { 0.0 }
}
