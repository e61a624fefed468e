#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::Number;

/// Bulk viscosity: a pressure against the rate of change of volume that spreads a shock over a few elements (von Neumann and
/// Richtmyer) and damps the ringing behind it.
///
/// q = ρ ℓ (b₁ c ε̇ + b₂² ℓ ε̇ |ε̇|), the second part in compression only, ε̇ = J̇/J; ℓ is the least height of the element. It depends
/// on the mesh and vanishes with it; both parts are numbers of the method and not of the gel (numerics 6.2).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BulkViscosity {
    /// b₁.
    pub linear: f64,
    /// b₂.
    pub quadratic: f64,
}

impl BulkViscosity {
    /// η of q = η ε̇, Pa·s, for ρ, c and ℓ at a rate.
    #[must_use]
    #[inline(always)]
    pub fn at<T: Number>(&self, density: f64, (speed, length): (f64, T), rate: T) -> T {
        let shock = length * (self.quadratic * self.quadratic) * (-rate).at_least(0.0);
        length * density * (shock + self.linear * speed)
    }
}
