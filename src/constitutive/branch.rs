#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::PowerLaw;
use crate::math::{exp, exp_less_one};

/// Branch of a two-network gel: a neo-Hookean shear spring in series with a dashpot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    shear_modulus: f64,
    dashpot: Dashpot,
}

/// Dashpot of a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dashpot {
    /// Linear dashpot (Maxwell branch).
    Linear(LinearDashpot),
    /// Power-law dashpot.
    PowerLaw(PowerLaw),
}

/// Linear dashpot: at a constant strain dev b̄_i, and so the Kirchhoff stress of the branch, falls as e^(−t/τ).
///
/// det b̄_i remains 1. On that path d(tr b̄)/dt = −(tr b̄ tr b̄⁻¹ − 9)/(τ tr b̄⁻¹) ≤ 0 (Cauchy): energy is only lost. At
/// small strains the branches have the shear modulus Σ μ_i iωτ_i/(1 + iωτ_i), the Prony series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearDashpot {
    time: f64,
}

impl Branch {
    /// Creates a branch from μ_i, Pa, and its dashpot.
    ///
    /// # Panics
    /// Unless μ_i > 0.
    #[must_use]
    pub fn new(shear_modulus: f64, dashpot: Dashpot) -> Self {
        assert!(shear_modulus > 0.0, "a branch needs a shear modulus > 0");
        Self { shear_modulus, dashpot }
    }

    /// Returns μ_i, Pa.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    /// Returns the dashpot.
    #[must_use]
    pub fn dashpot(&self) -> &Dashpot {
        &self.dashpot
    }
}

impl Dashpot {
    /// Creates a linear dashpot from the relaxation time τ, s.
    ///
    /// # Panics
    /// Unless τ > 0.
    #[must_use]
    pub fn linear(time: f64) -> Self {
        assert!(time > 0.0, "a linear dashpot needs a time > 0");
        Self::Linear(LinearDashpot { time })
    }

    /// Creates a power-law dashpot from the stress at a rate of 1/s, Pa, and the exponent.
    ///
    /// # Panics
    /// Unless the stress is positive and 0 < m ≤ 1 ([`PowerLaw::new`]).
    #[must_use]
    pub fn power_law(stress: f64, exponent: f64) -> Self {
        Self::PowerLaw(PowerLaw::new(stress, exponent))
    }

    /// Creates a power-law dashpot that saturates, from its stress, Pa, its rate, 1/s, and the exponent.
    ///
    /// # Panics
    /// Unless all are positive ([`PowerLaw::saturating`]).
    #[must_use]
    pub fn saturating(stress: f64, rate: f64, exponent: f64) -> Self {
        Self::PowerLaw(PowerLaw::saturating(stress, rate, exponent))
    }
}

impl LinearDashpot {
    /// Returns the two relaxation factors of a step, s: at the strain of its start, then at the strain of its end.
    ///
    /// With x = Δt/τ the product is e^(−x), exact for a constant strain. The second factor (1 − e^(−x))/x is exact
    /// for a strain that grows linearly: a branch with τ far below the step acts as a viscous damper.
    #[must_use]
    pub fn relaxation_factors(&self, step: f64) -> [f64; 2] {
        let x = step / self.time;
        let now = if x > 0.0 { -exp_less_one(-x) / x } else { 1.0 };
        [exp(-x) / now, now]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relaxation_of_two_steps_is_that_of_their_sum() {
        let dashpot = LinearDashpot { time: 3e-3 };
        let left = |step: f64| dashpot.relaxation_factors(step).iter().product::<f64>();
        assert!((left(1e-3) * left(4e-3) / left(5e-3) - 1.0).abs() < 1e-15);
        assert_eq!(dashpot.relaxation_factors(0.0), [1.0; 2]);
    }
}
