#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::{Number, exp, ln};

/// Power-law dashpot: the equivalent stress q = q₀ (ε̇/ε̇₀)^m bears the viscous rate ε̇, without a yield stress; it may
/// saturate at q₀.
///
/// q is the equivalent Kirchhoff stress of the branch, √(3/2) μ_i |dev b̄_i|, and ε̇ the equivalent rate of its viscous
/// flow, which is coaxial with dev b̄_i. At a constant strain q̇ = −μ_i tr b̄_i ε̇(q).
///
/// A dashpot that saturates bears q₀ at most: at ε̇ ≥ ε̇₀ q = q₀. It is the limit N → ∞ of ε̇ = ε̇₀ [x^(1/m) + x^N],
/// x = q/q₀. With m > 1 it is small below ε̇₀ and constant above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    stress: f64,
    rate: f64,
    exponent: f64,
    saturates: bool,
}

/// Most iterations of a return; three to four are usual.
const MAX_ITERATIONS: usize = 12;
/// Change of ln s, from which the next iterate is exact: convergence is of third order.
const SETTLED: f64 = 1e-6;
/// ln a, below which s = 1 within half an ulp.
const NEGLIGIBLE: f64 = -38.0;
/// −ln s, beyond which e^u and e^(u/m) would leave the range of numbers.
const LEAST: f64 = 700.0;

impl PowerLaw {
    /// Creates the law from q₀, the stress at a rate of 1/s, Pa, and m.
    ///
    /// # Panics
    /// Unless q₀ > 0 and 0 < m ≤ 1.
    #[must_use]
    pub fn new(stress: f64, exponent: f64) -> Self {
        assert!(stress > 0.0 && exponent > 0.0 && exponent <= 1.0, "a power law needs q > 0 and 0 < m <= 1");
        Self { stress, rate: 1.0, exponent, saturates: false }
    }

    /// Creates the law that saturates at q₀, Pa, from the rate ε̇₀ at which it does, 1/s, and m.
    ///
    /// # Panics
    /// Unless all three are positive.
    #[must_use]
    pub fn saturating(stress: f64, rate: f64, exponent: f64) -> Self {
        assert!(stress > 0.0 && rate > 0.0 && exponent > 0.0, "a saturating law needs q > 0, a rate > 0 and m > 0");
        Self { stress, rate, exponent, saturates: true }
    }

    /// Returns the stress at a viscous rate, 1/s, Pa.
    #[must_use]
    pub fn stress_at(&self, rate: f64) -> f64 {
        let stress = self.stress * libm::pow(rate / self.rate, self.exponent);
        if self.saturates { stress.min(self.stress) } else { stress }
    }

    /// Returns the viscous rate at a stress, Pa, 1/s; that of the power law at a stress that saturates.
    #[must_use]
    pub fn rate_at(&self, stress: f64) -> f64 {
        self.rate * libm::pow(stress / self.stress, 1.0 / self.exponent)
    }

    /// Returns s = q/q_t, the part of a trial stress q_t, Pa, that is left after a step, s; `stiffness` is 3μ̄ = μ_i tr b̄_i.
    ///
    /// The part is that of the power law, unless q is above the stress that saturates: q then returns to this one, and the
    /// equation holds there with the rate that this takes.
    #[must_use]
    #[inline(always)]
    pub fn part_left<T: Number>(&self, trial: T, stiffness: T, step: f64) -> T {
        let part = self.part_of_power(trial, stiffness, step);
        if !self.saturates {
            return part;
        }
        let most = trial.constant(self.stress) / trial.at_least(f64::MIN_POSITIVE);
        (most - part).choose(part, most)
    }

    /// Returns the part that the power law leaves.
    ///
    /// Implicit Euler: q = q_t − 3μ̄ Δt ε̇(q). With u = ln s and a = 3μ̄ Δt ε̇(q_t)/q_t the
    /// equation is e^u + a e^(u/m) = 1. The left side is convex and rises, so Halley's iteration from u = min(0, −m ln a),
    /// which is at or above the root and off by max(1, m) ln 2 at most, converges for every rate; in ε̇ itself Newton's
    /// iteration stalls at rest. A stress too small for a normal number is left as it is, and none falls below
    /// e^(−700) of itself.
    #[inline(always)]
    fn part_of_power<T: Number>(&self, trial: T, stiffness: T, step: f64) -> T {
        let (one, inverse) = (trial.constant(1.0), 1.0 / self.exponent);
        let normal = trial.at_least(f64::MIN_POSITIVE);
        let gain = ln((stiffness * (step * self.rate)).at_least(f64::MIN_POSITIVE)) - ln(normal);
        let log = (gain + (ln(normal) - ln(self.stress)) * inverse).at_most(LEAST / self.exponent);
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
    use fearless_simd::{Level, SimdBase, dispatch, f64x8};

    #[test]
    fn the_part_left_satisfies_the_implicit_equation_at_every_rate() {
        for m in [0.05, 0.5, 0.7, 0.85, 1.0] {
            check_return(PowerLaw::new(640.0, m));
        }
        for m in [0.05, 0.7, 1.5, 3.0, 10.0] {
            check_return(PowerLaw::saturating(1.1e6, 1200.0, m));
        }
    }

    /// Checks that the trial stress of each rate returns to the stress of this rate.
    fn check_return(law: PowerLaw) {
        let stiffness = 3.0 * 4.8e6;
        for step in [1e-9, 1e-7, 1e-5, 1e-2, 10.0] {
            for rate in [1e-3, 1.0, 1e3, 1e6] {
                let trial = law.stress_at(rate) + stiffness * step * rate;
                let left = law.part_left(trial, stiffness, step) * trial;
                let error = (left / law.stress_at(rate) - 1.0).abs();
                // Beside a trial far above it the stress is known to the rounding of its logarithm, times m.
                assert!(error < 1e-12 * law.exponent.max(1.0), "{law:?}, {step} s, {rate}/s: {error:e}");
            }
        }
    }

    #[test]
    fn a_saturating_law_is_a_power_law_up_to_its_rate_and_constant_above() {
        let law = PowerLaw::saturating(1.1e6, 1200.0, 3.0);
        assert_eq!([1200.0, 1e5, 1e9].map(|rate| law.stress_at(rate)), [1.1e6; 3]);
        assert!((law.stress_at(600.0) / 1.1e6 - 0.125).abs() < 1e-15);
        assert!((law.rate_at(1.1e6 / 8.0) / 600.0 - 1.0).abs() < 1e-15);
        // From above it returns to its stress at once, in a step that is too short for more.
        for (trial, step) in [(1.2e6, 1e-30), (1.2e6, 1e-9), (1e9, 1e-3)] {
            assert_eq!(law.part_left(trial, 1.4e7, step) * trial, 1.1e6, "{trial}, {step}");
        }
        assert_eq!(law.part_left(1.1e6, 1.4e7, 1e-30), 1.0);
    }

    #[test]
    fn eight_lanes_return_to_the_bits_of_one() {
        let laws = [PowerLaw::new(640.0, 0.8), PowerLaw::saturating(1.1e6, 1200.0, 3.0)];
        let trials = [0.0, 1e-310, 1.0, 1e4, 9e5, 1.1e6, 1.2e6, 1e9];
        for law in laws {
            for step in [1e-30, 1e-7, 1e-3] {
                let eight: [f64; 8] = dispatch!(Level::new(), simd => {
                    let trial = f64x8::from_slice(simd, &trials);
                    law.part_left(trial, f64x8::splat(simd, 1.4e7), step).store()
                });
                assert_eq!(eight, trials.map(|trial| law.part_left(trial, 1.4e7, step)), "{law:?}, {step} s");
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
        let law = PowerLaw::saturating(1.1e6, 1200.0, 3.0);
        assert_eq!([0.0, 5e-324].map(|trial| law.part_left(trial, 1.4e7, 1e-3)), [1.0; 2]);
        assert!((0.0..1e-300).contains(&law.part_left(1e-300, 1.4e7, 1e-3)));
    }
}
