#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::Number;

/// Artificial bulk viscosity (von Neumann and Richtmyer): spreads a shock over a few elements and damps the ringing
/// behind it.
///
/// q = ρ ℓ (b₁ c ε̇ + b₂² ℓ ε̇ |ε̇|), the quadratic part in compression only, ε̇ = J̇/J; ρ is the present density and
/// ℓ the least height of the element. q vanishes as the mesh is refined; both coefficients belong to the method and not to the material
/// (method 6.2).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BulkViscosity {
    /// Linear coefficient b₁.
    pub linear: f64,
    /// Quadratic coefficient b₂.
    pub quadratic: f64,
}

impl BulkViscosity {
    /// Returns η of q = η ε̇, Pa·s, from ρ, kg/m³, c, m/s, ℓ, m, and ε̇, 1/s.
    #[must_use]
    #[inline(always)]
    pub fn at<T: Number>(&self, density: T, speed: T, length: T, rate: T) -> T {
        let shock = length * (self.quadratic * self.quadratic) * (-rate).at_least(0.0);
        length * density * (shock + speed * self.linear)
    }
}
