#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::neo_hookean::continued;
use super::{VolumetricEnergy, VolumetricResponse};
use crate::math::{Number, Tensor};

/// Hyperelastic material, ψ = ψ_s(F) + U(J).
///
/// ψ_s is an isotropic energy of the principal stretches, defined for every F, inverted elements included; U resists
/// inversion.
pub trait Hyperelastic {
    /// Returns the volumetric energy U.
    fn volume(&self) -> LogarithmicEnergy;
    /// Evaluates ψ_s at F and the out-of-plane stretch `out`: 1 in plane strain, ignored in space.
    fn sheared<const D: usize>(&self, f: &Tensor<D>, out: f64) -> ShearResponse<D>;
}

/// Energy ψ_s of the principal stretches, its stress and a bound of its curvature at one deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShearResponse<const D: usize> {
    /// ψ_s, J/m³.
    pub energy: f64,
    /// ∂ψ_s/∂F, Pa.
    pub stress: Tensor<D>,
    /// Derivative of ψ_s by the out-of-plane stretch, Pa; ignored in space.
    pub out: f64,
    /// Constants a and b of a curvature bound, Pa: d²ψ_s(F + tH)/dt² ≤ a|H|² + b(F:H)² for every H.
    pub curvature: [f64; 2],
}

/// Logarithmic volumetric energy U(J) = −m ln J + Λ/2 (ln J)².
///
/// Below [`NeoHookean::FLOOR`](super::NeoHookean::FLOOR) U continues as its second-order Taylor polynomial. m cancels
/// the rest stress of ψ_s, ∂ψ_s/∂F = m 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogarithmicEnergy {
    /// m, Pa.
    pub rest: f64,
    /// Λ, Pa.
    pub lambda: f64,
}

impl VolumetricEnergy for LogarithmicEnergy {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        continued(self.rest, self.lambda, j)
    }

    /// Element part, −m ln J.
    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        continued(self.rest, 0.0, j)
    }

    /// Patch part, Λ/2 (ln J̄)².
    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> VolumetricResponse<T> {
        continued(0.0, self.lambda, mean)
    }
}

/// Returns the right Cauchy–Green tensor C = FᵀF.
pub(super) fn right_cauchy_green<const D: usize>(f: &Tensor<D>) -> Tensor<D> {
    f.transpose() * f
}

/// Returns the square of the out-of-plane stretch; 0 in space.
pub(super) fn squared_stretch<const D: usize>(out: f64) -> f64 {
    if D == 2 { out * out } else { 0.0 }
}
