#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::{Number, exp, ln};

/// Power-law dashpot: the equivalent stress q = Y₁ (ε̇ · 1 s)^m bears the viscous rate ε̇, without a yield stress.
///
/// q is the equivalent Kirchhoff stress of the branch, √(3/2) μ_i |dev b̄_i|, and ε̇ the equivalent rate of its viscous
/// flow, which is coaxial with dev b̄_i. At a constant strain q̇ = −μ_i tr b̄_i ε̇(q).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    stress: f64,
    exponent: f64,
}

/// Most iterations of a return; three to four are usual.
const MAX_ITERATIONS: usize = 12;
/// Change of ln s, from which the next iterate is exact: convergence is of third order.
const SETTLED: f64 = 1e-6;
/// ln a, below which s = 1 within half an ulp.
const NEGLIGIBLE: f64 = -38.0;

impl PowerLaw {
    /// Creates the law from Y₁, the stress at a rate of 1/s, Pa, and m.
    ///
    /// # Panics
    /// Unless Y₁ > 0 and 0 < m ≤ 1.
    #[must_use]
    pub fn new(stress: f64, exponent: f64) -> Self {
        assert!(stress > 0.0 && exponent > 0.0 && exponent <= 1.0, "a power law needs Y > 0 and 0 < m <= 1");
        Self { stress, exponent }
    }

    /// Returns the stress at a viscous rate, 1/s, Pa.
    #[must_use]
    pub fn stress_at(&self, rate: f64) -> f64 {
        self.stress * libm::pow(rate, self.exponent)
    }

    /// Returns the viscous rate at a stress, Pa, 1/s.
    #[must_use]
    pub fn rate_at(&self, stress: f64) -> f64 {
        libm::pow(stress / self.stress, 1.0 / self.exponent)
    }

    /// Returns s = q/q_t, the part of a trial stress q_t, Pa, that is left after a step, s.
    ///
    /// Implicit Euler: q = q_t − 3μ̄ Δt ε̇(q), `stiffness` 3μ̄ = μ_i tr b̄_i. With u = ln s and a = 3μ̄ Δt ε̇(q_t)/q_t the
    /// equation is e^u + a e^(u/m) = 1. The left side is convex and rises, so Halley's iteration from u = min(0, −m ln a),
    /// which is at or above the root and off by ln 2 at most, converges for every rate; in ε̇ itself Newton's iteration
    /// stalls at rest. A stress too small for a normal number is left as it is.
    #[must_use]
    #[inline(always)]
    pub fn part_left<T: Number>(&self, trial: T, stiffness: T, step: f64) -> T {
        let (one, inverse) = (trial.constant(1.0), 1.0 / self.exponent);
        let normal = trial.at_least(f64::MIN_POSITIVE);
        let log =
            ln((stiffness * step).at_least(f64::MIN_POSITIVE)) - ln(normal) + (ln(normal) - ln(self.stress)) * inverse;
        let is_normal = trial - f64::MIN_POSITIVE;
        let mut open = is_normal.choose(log - NEGLIGIBLE, is_normal);
        if !open.any_positive() {
            return one;
        }
        let flows = open;
        let mut u = (log * -self.exponent).at_most(0.0);
        for _ in 0..MAX_ITERATIONS {
            let (left, gone) = (exp(u), exp(u * inverse + log));
            let excess = left + gone - 1.0;
            let slope = left + gone * inverse;
            let curvature = left + gone * (inverse * inverse);
            let change = excess * slope / (slope * slope - excess * curvature * 0.5);
            u = u - open.choose(change, one * 0.0);
            open = open.choose(change.absolute() - SETTLED, open);
            if !open.any_positive() {
                break;
            }
        }
        flows.choose(exp(u).at_most(1.0), one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_left_satisfies_the_implicit_equation_at_every_rate() {
        let stiffness = 3.0 * 4.8e6;
        for m in [0.05, 0.5, 0.7, 0.85, 1.0] {
            let law = PowerLaw::new(640.0, m);
            for step in [1e-9, 1e-7, 1e-5, 1e-2, 10.0] {
                for rate in [1e-3, 1.0, 1e3, 1e6] {
                    // The trial stress that leaves the stress of this rate.
                    let trial = law.stress_at(rate) + stiffness * step * rate;
                    let left = law.part_left(trial, stiffness, step) * trial;
                    let error = (left / law.stress_at(rate) - 1.0).abs();
                    // Beside a trial far above it the stress is known to the rounding of its logarithm.
                    assert!(error < 1e-12, "m = {m}, {step} s, {rate}/s: {error:e}");
                }
            }
        }
    }

    #[test]
    fn zero_and_denormal_stresses_come_back_unchanged() {
        for m in [0.5, 1.0] {
            for trial in [0.0, 5e-324, 1e-310] {
                assert_eq!(PowerLaw::new(640.0, m).part_left(trial, 1.4e7, 1e-3), 1.0, "{trial}");
            }
        }
        assert_eq!(PowerLaw::new(640.0, 0.8).part_left(1e5, 1.4e7, 0.0), 1.0);
    }
}
