#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::{Number, power};

/// Rate-dependent von Mises yield law: the equivalent Kirchhoff stress Y(ε̇) = Y₀ (ε̇/ε̇₀)^m, between Y₀ and the cap.
///
/// ε̇ is the rate of equivalent plastic strain; ε̇₀ = 1/s by default. The power law extrapolates a test at ε̇₀ to the
/// 10⁴/s around a bullet. Pressure may raise the yield stress further, above the cap, too ([`YieldLaw::with_confinement`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct YieldLaw {
    yield_stress: f64,
    exponent: f64,
    cap: f64,
    /// Reference rate ε̇₀, 1/s; Y = Y₀ up to it.
    reference: f64,
    /// Rate at which the power law reaches the cap, 1/s.
    fastest: f64,
    /// Pressure dependence of the yield stress, if any.
    confinement: Option<PressureHardening>,
}

/// Pressure dependence of the yield stress: a multiplier that rises linearly from 1 to `factor` at `pressure`, Pa,
/// then stays.
///
/// The pressure is low-pass filtered in time, τ p̃˙ = p − p̃, so waves shorter than τ do not count; τ = 0 takes the
/// present pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureHardening {
    /// Pressure of the greatest multiplier, Pa.
    pub pressure: f64,
    /// Greatest multiplier.
    pub factor: f64,
    /// Filter time τ, s.
    pub time: f64,
}

impl PressureHardening {
    /// Returns the filtered U′ = −p, Pa, after a step, s, with `slope` at its end (implicit Euler).
    #[inline(always)]
    fn filtered_slope<T: Number>(&self, before: T, slope: T, step: f64) -> T {
        before + (slope - before) * (step / (self.time + step))
    }

    /// Returns the multiplier of the yield stress at the filtered slope U′, Pa.
    #[inline(always)]
    fn multiplier<T: Number>(&self, slope: T) -> T {
        let part = (slope * (-1.0 / self.pressure)).at_least(0.0);
        let one = slope.constant(1.0);
        let part = (one - part).choose(part, one);
        part * (self.factor - 1.0) + 1.0
    }
}

/// Result of the radial return: the equivalent stress on the yield surface and the plastic strain increment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressReturn<T = f64> {
    /// Equivalent stress after the return, Pa.
    pub stress: T,
    /// Increment Δε_p of the equivalent plastic strain; 0 for an elastic step.
    pub strain: T,
}

/// Most Newton iterations of a return.
const MAX_ITERATIONS: usize = 40;
/// Relative residual of the stress before the last Newton iteration, whose own residual is of the order of its square.
const TOLERANCE: f64 = 1e-8;

impl YieldLaw {
    /// Creates the yield law from Y₀, Pa, m and the cap, Pa.
    ///
    /// # Panics
    /// Unless Y₀ > 0, 0 ≤ m < 1 and the cap is Y₀ or more.
    #[must_use]
    pub fn new(yield_stress: f64, exponent: f64, cap: f64) -> Self {
        let is_valid = yield_stress > 0.0 && (0.0..1.0).contains(&exponent) && cap >= yield_stress;
        assert!(is_valid, "a strength needs Y > 0, 0 <= m < 1 and a cap of at least Y");
        let fastest = if exponent > 0.0 { libm::pow(cap / yield_stress, 1.0 / exponent) } else { f64::INFINITY };
        Self { yield_stress, exponent, cap, reference: 1.0, fastest, confinement: None }
    }

    /// Returns the law with the reference rate ε̇₀, 1/s.
    ///
    /// # Panics
    /// Unless ε̇₀ > 0.
    #[must_use]
    pub fn with_reference_rate(self, reference: f64) -> Self {
        assert!(reference > 0.0, "a strength needs a rate of reference > 0");
        Self { reference, fastest: self.fastest / self.reference * reference, ..self }
    }

    /// Returns the law with a pressure-dependent yield stress.
    ///
    /// # Panics
    /// Unless the pressure is positive, the factor 1 or more and the time no less than 0.
    #[must_use]
    pub fn with_confinement(self, confinement: PressureHardening) -> Self {
        let PressureHardening { pressure, factor, time } = confinement;
        let is_valid = pressure > 0.0 && factor >= 1.0 && time >= 0.0;
        assert!(is_valid, "a confined strength needs a pressure > 0, a factor >= 1 and a time >= 0");
        Self { confinement: Some(confinement), ..self }
    }

    /// Returns the greatest slope of the shear strength in the pressure, ∂τ/∂p = (factor − 1) Y/(√3 P), τ = q/√3, at
    /// the cap.
    #[must_use]
    pub fn steepest_friction(&self) -> f64 {
        self.confinement
            .map_or(0.0, |confinement| (confinement.factor - 1.0) * self.cap / (3.0_f64.sqrt() * confinement.pressure))
    }

    /// Returns the greatest ∂τ/∂p for which small disturbances of a plastic flow decay, 2√(m(1 − m)).
    ///
    /// A wave along k, at the angle 2θ to the direction of shear, grows as −1 + (1 − m) sin²2θ/(1 − ∂τ/∂p cos 2θ),
    /// short waves fastest (numerics 6.2). Above the limit the solution does not converge with mesh refinement.
    #[must_use]
    pub fn stable_friction(&self) -> f64 {
        2.0 * (self.exponent * (1.0 - self.exponent)).sqrt()
    }

    /// Returns the filtered U′, Pa, after a step, s, with `slope` at its end.
    #[must_use]
    #[inline(always)]
    pub fn filtered_slope<T: Number>(&self, before: T, slope: T, step: f64) -> T {
        if step <= 0.0 {
            return before;
        }
        self.confinement.map_or(slope, |confinement| confinement.filtered_slope(before, slope, step))
    }

    /// Returns Y at zero pressure at a rate of equivalent plastic strain, 1/s.
    #[must_use]
    pub fn at(&self, rate: f64) -> f64 {
        if rate <= self.reference || self.exponent == 0.0 {
            return self.yield_stress;
        }
        if rate >= self.fastest { self.cap } else { self.power_law(rate) }
    }

    /// Power law Y₀ (ε̇/ε̇₀)^m, without its limits.
    #[inline(always)]
    fn power_law<T: Number>(&self, rate: T) -> T {
        power(rate * (1.0 / self.reference), self.exponent) * self.yield_stress
    }

    /// Radial return mapping of a trial stress, Pa, in a step, s (Simo & Hughes 1998).
    ///
    /// A trial stress above the yield stress satisfies q = q_trial − 3μ̄ Δε = N Y(Δε/Δt); `stiffness` is 3μ̄. This
    /// implicit equation has one root, since its left side falls and its right side rises. The iteration starts from
    /// `rate`, that of the last return, 1/s. N is the multiplier at the filtered slope U′, Pa, which the return does
    /// not change.
    #[must_use]
    #[inline(always)]
    pub fn return_stress<T: Number>(&self, trial: T, stiffness: T, filtered: T, step: f64, rate: T) -> StressReturn<T> {
        let strain = match &self.confinement {
            Some(confinement) => {
                let multiplier = confinement.multiplier(filtered);
                self.plastic_increment(trial / multiplier, stiffness / multiplier, step, rate)
            }
            None => self.plastic_increment(trial, stiffness, step, rate),
        };
        StressReturn { stress: trial - stiffness * strain, strain }
    }

    /// Returns Δε at zero pressure; branch-free between the lanes of a vector.
    #[inline(always)]
    fn plastic_increment<T: Number>(&self, trial: T, stiffness: T, step: f64, rate: T) -> T {
        let least = (trial - self.yield_stress) / stiffness;
        let mut strain = least;
        // Strains at which Y leaves Y₀ and reaches the cap.
        let (slow, fast) = (self.reference * step, self.fastest * step);
        let between = least - slow;
        if self.exponent > 0.0 && between.any_positive() {
            let most = (trial - self.cap) / stiffness;
            let low = most.at_least(slow);
            let above = least - low;
            let start = rate * step;
            let start = (start - low).choose((start - least).choose(least, start), low);
            let open = between.choose(-(most - fast), between);
            let root = self.power_law_root(trial, stiffness, step, low, above.choose(start, low), open);
            strain = between.choose((-(most - fast)).choose(root, most), least);
        }
        strain.at_least(0.0)
    }

    /// Returns the root of the power law by Newton iterations in the lanes where `open` is positive.
    ///
    /// The residual is a convex, falling function of the strain. From below the iterates rise to the root; from above
    /// the first iterate falls below the root, limited by the least possible strain `low`.
    #[inline(always)]
    fn power_law_root<T: Number>(&self, trial: T, stiffness: T, step: f64, low: T, start: T, mut open: T) -> T {
        let mut strain = start;
        for _ in 0..MAX_ITERATIONS {
            if !open.any_positive() {
                break;
            }
            let bears = self.power_law(strain * (1.0 / step));
            let over = trial - stiffness * strain - bears;
            let next = (strain + over / (stiffness + bears * self.exponent / strain)).or_greater(low);
            strain = open.choose(next, strain);
            open = open.choose(over.absolute() - trial * TOLERANCE, open);
        }
        strain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gel() -> YieldLaw {
        YieldLaw::new(0.133e6, 0.23, 1.6e6)
    }

    #[test]
    fn the_power_law_holds_between_yield_stress_and_cap() {
        let gel = gel();
        assert_eq!((gel.at(0.0), gel.at(1.0)), (0.133e6, 0.133e6));
        assert!((gel.at(1e3) / (0.133e6 * 1e3_f64.powf(0.23)) - 1.0).abs() < 1e-14);
        assert_eq!(gel.at(1e9), 1.6e6);
        let later = gel.with_reference_rate(500.0);
        assert_eq!((later.at(500.0), later.at(1e9)), (0.133e6, 1.6e6));
        assert!((later.at(5e5) / gel.at(1e3) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn stable_friction_is_the_limit_of_decaying_disturbances() {
        let confinement = PressureHardening { pressure: 0.4e6, factor: 3.0, time: 0.0 };
        let rise = 1e-6 * 0.4e6;
        let more = confinement.multiplier(-rise) - confinement.multiplier(0.0);
        let slope = more * 1.6e6 / (rise * 3.0_f64.sqrt());
        assert!((gel().with_confinement(confinement).steepest_friction() / slope - 1.0).abs() < 1e-9);
        assert_eq!(gel().steepest_friction(), 0.0);
        for m in [0.05, 0.23, 0.4] {
            let law = YieldLaw::new(0.1e6, m, 1e6);
            let growth =
                |friction: f64, cosine: f64| (1.0 - m) * (1.0 - cosine * cosine) / (1.0 - friction * cosine) - 1.0;
            let most =
                |friction: f64| (0..=2000).map(|i| growth(friction, f64::from(i) / 2000.0)).fold(f64::MIN, f64::max);
            assert!(most(0.999 * law.stable_friction()) < 0.0 && most(1.001 * law.stable_friction()) > 0.0, "{m}");
        }
    }

    #[test]
    fn the_returned_stress_is_the_yield_stress_at_the_plastic_rate() {
        let stiffness = 3.0 * 4.8e6;
        let laws = [gel(), gel().with_reference_rate(500.0)];
        for (gel, step) in [1e-9, 1e-7, 1e-5, 1e-2, 10.0].iter().flat_map(|step| laws.map(|law| (law, *step))) {
            for rate in [0.0, 1e3, 1e9] {
                for trial in [0.14e6, 0.5e6, 1.5e6, 1.7e6, 5e6, 5e7] {
                    let StressReturn { stress, strain } = gel.return_stress(trial, stiffness, 0.0, step, rate);
                    assert!((stress - gel.at(strain / step)).abs() < 2e-13 * trial, "{step} {trial}");
                    assert!((trial - stiffness * strain - stress).abs() < 1e-12 * trial && strain > 0.0);
                }
            }
        }
        let borne = StressReturn { stress: 0.13e6, strain: 0.0 };
        assert_eq!(gel().return_stress(0.13e6, stiffness, 0.0, 1e-6, 0.0), borne);
    }

    #[test]
    fn the_pressure_filter_follows_its_time_and_is_off_without() {
        let law = |time: f64| gel().with_confinement(PressureHardening { pressure: 0.4e6, factor: 3.0, time });
        let sliced = |n: i32| (0..n).fold(0.0, |slope, _| law(2e-6).filtered_slope(slope, -1e6, 3e-6 / f64::from(n)));
        let exact = -1e6 * (1.0 - (-1.5_f64).exp());
        let [coarse, fine] = [100, 1000].map(|n| (sliced(n) / exact - 1.0).abs());
        assert!(coarse < 5e-3 && fine < 0.11 * coarse, "{coarse:e}, {fine:e}");
        assert_eq!((law(0.0).filtered_slope(7.0, -1e6, 1e-9), law(2e-6).filtered_slope(7.0, -1e6, 0.0)), (-1e6, 7.0));
        assert_eq!(gel().filtered_slope(7.0, -1e6, 1e-9), -1e6);
    }

    #[test]
    fn the_yield_stress_rises_with_pressure_up_to_the_factor() {
        let confinement = PressureHardening { pressure: 0.4e6, factor: 3.0, time: 0.0 };
        let (gel, stiffness, step) = (gel().with_confinement(confinement), 3.0 * 4.8e6, 1e-7);
        for (slope, times) in [(1e6, 1.0), (0.0, 1.0), (-0.2e6, 2.0), (-0.4e6, 3.0), (-7e6, 3.0)] {
            for trial in [0.5e6, 1.5e6, 5e6, 5e7] {
                let StressReturn { stress, strain } = gel.return_stress(trial, stiffness, slope, step, 1e3);
                let bears = times * gel.at(strain / step);
                let stays = strain == 0.0 && stress == trial && trial <= bears;
                assert!(stays || (stress - bears).abs() < 4e-13 * trial, "{slope}, {trial}: {stress} for {bears}");
            }
        }
    }
}
