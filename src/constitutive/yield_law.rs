#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::{Number, power};

/// Strength of a gel that flows: the equivalent (von Mises) Kirchhoff stress that it bears at a rate of equivalent plastic strain,
/// Y(ε̇) = Y₀ (ε̇/ε̇₀)^m, no less than Y₀ and no more than the cap; ε̇₀ = 1/s unless it is told.
///
/// Y₀ and m are of one power law, so a gel measured at ε̇₀ (Y₀) is known at the 10⁴/s around a bullet. Under pressure it may bear more
/// than that, and than the cap ([`Strength::confined`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    yield_stress: f64,
    exponent: f64,
    cap: f64,
    /// ε̇₀, up to which it bears Y₀, 1/s.
    reference: f64,
    /// ε̇ at which the power law meets the cap, 1/s.
    fastest: f64,
    /// What more it bears under pressure; nothing if none.
    confinement: Option<Confinement>,
}

/// How many times as much a gel bears under pressure: once at none, in proportion up to `factor` times at `pressure`, Pa, and above.
///
/// It feels the pressure of the last `time`, s: τ p̃˙ = p − p̃. Waves that pass in less do not count; 0 feels what is now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Confinement {
    /// Pressure from which on it bears most, Pa.
    pub pressure: f64,
    /// How many times as much then.
    pub factor: f64,
    /// τ, s.
    pub time: f64,
}

impl Confinement {
    /// What is felt after a step, s, of U′ = −p, Pa, at its end: by the implicit Euler step.
    #[inline(always)]
    fn felt<T: Number>(&self, before: T, slope: T, step: f64) -> T {
        before + (slope - before) * (step / (self.time + step))
    }

    /// At a slope U′ that is felt, Pa.
    #[inline(always)]
    fn times<T: Number>(&self, slope: T) -> T {
        let part = (slope * (-1.0 / self.pressure)).at_least(0.0);
        let one = slope.constant(1.0);
        let part = (one - part).choose(part, one);
        part * (self.factor - 1.0) + 1.0
    }
}

/// Where the stress comes back to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Returned<T = f64> {
    /// Equivalent stress then, Pa.
    pub stress: T,
    /// Δε_p, equivalent plastic strain; 0 if it stays.
    pub strain: T,
}

/// Newton's steps of the return at most, and what is left of the stress, as a part of it, before the last of them, which leaves its
/// square.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-8;

impl Strength {
    /// From Y₀, Pa, m and the cap, Pa.
    ///
    /// # Panics
    /// Unless Y₀ > 0, 0 ≤ m < 1 and the cap is Y₀ or more.
    #[must_use]
    pub fn new(yield_stress: f64, exponent: f64, cap: f64) -> Self {
        let sound = yield_stress > 0.0 && (0.0..1.0).contains(&exponent) && cap >= yield_stress;
        assert!(sound, "a strength needs Y > 0, 0 <= m < 1 and a cap of at least Y");
        let fastest = if exponent > 0.0 { libm::pow(cap / yield_stress, 1.0 / exponent) } else { f64::INFINITY };
        Self { yield_stress, exponent, cap, reference: 1.0, fastest, confinement: None }
    }

    /// The same law with Y₀ up to ε̇₀, 1/s, in the place of 1/s.
    ///
    /// # Panics
    /// Unless ε̇₀ > 0.
    #[must_use]
    pub fn from_rate(self, reference: f64) -> Self {
        assert!(reference > 0.0, "a strength needs a rate of reference > 0");
        Self { reference, fastest: self.fastest / self.reference * reference, ..self }
    }

    /// The same law with more borne under pressure.
    ///
    /// # Panics
    /// Unless the pressure is positive, the factor 1 or more and the time no less than 0.
    #[must_use]
    pub fn confined(self, confinement: Confinement) -> Self {
        let Confinement { pressure, factor, time } = confinement;
        let sound = pressure > 0.0 && factor >= 1.0 && time >= 0.0;
        assert!(sound, "a confined strength needs a pressure > 0, a factor >= 1 and a time >= 0");
        Self { confinement: Some(confinement), ..self }
    }

    /// How steeply the shear stress that it bears follows the pressure at most, ∂τ/∂p = (factor − 1) Y/(√3 P), τ = q/√3, at the cap.
    #[must_use]
    pub fn steepest_friction(&self) -> f64 {
        self.confinement
            .map_or(0.0, |confinement| (confinement.factor - 1.0) * self.cap / (3.0_f64.sqrt() * confinement.pressure))
    }

    /// How steeply it may follow the pressure for small disturbances of a flow to fade, 2√(m(1 − m)): with k across the direction of shear at an angle
    /// 2θ they grow as −1 + (1 − m) sin²2θ/(1 − ∂τ/∂p cos 2θ), the shorter the faster (numerics 6.2). Above it a flow has no limit of refinement.
    #[must_use]
    pub fn stable_friction(&self) -> f64 {
        2.0 * (self.exponent * (1.0 - self.exponent)).sqrt()
    }

    /// U′ as the gel feels it after a step, s, with `slope` at its end, Pa.
    #[must_use]
    #[inline(always)]
    pub fn felt<T: Number>(&self, before: T, slope: T, step: f64) -> T {
        if step <= 0.0 {
            return before;
        }
        self.confinement.map_or(slope, |confinement| confinement.felt(before, slope, step))
    }

    /// Y without pressure at a rate of equivalent plastic strain, 1/s.
    #[must_use]
    pub fn at(&self, rate: f64) -> f64 {
        if rate <= self.reference || self.exponent == 0.0 {
            return self.yield_stress;
        }
        if rate >= self.fastest { self.cap } else { self.power_law(rate) }
    }

    /// Y₀ (ε̇/ε̇₀)^m.
    #[inline(always)]
    fn power_law<T: Number>(&self, rate: T) -> T {
        power(rate * (1.0 / self.reference), self.exponent) * self.yield_stress
    }

    /// Where a trial stress, Pa, comes back to in a step, s: if it is more than the gel bears, q = q_trial − 3μ̄ Δε = N Y(Δε/Δt), an
    /// implicit equation with one root, for the left side falls and the right one rises; else it stays, with no strain. It is
    /// sought from the rate of the last return, 1/s, if there was one. N is what confinement makes of it at the slope U′ that is felt, Pa,
    /// which the return does not change.
    #[must_use]
    #[inline(always)]
    pub fn returned<T: Number>(&self, (trial, stiffness): (T, T), felt: T, (step, rate): (f64, T)) -> Returned<T> {
        let strain = match &self.confinement {
            Some(confinement) => {
                let times = confinement.times(felt);
                self.flown((trial / times, stiffness / times), (step, rate))
            }
            None => self.flown((trial, stiffness), (step, rate)),
        };
        Returned { stress: trial - stiffness * strain, strain }
    }

    /// Δε without pressure. Written without a branch between one trial and the next.
    #[inline(always)]
    fn flown<T: Number>(&self, (trial, stiffness): (T, T), (step, rate): (f64, T)) -> T {
        let least = (trial - self.yield_stress) / stiffness;
        let mut strain = least;
        // Between what flows so slowly, or so fast, that Y is one of its ends.
        let (slow, fast) = (self.reference * step, self.fastest * step);
        let between = least - slow;
        if self.exponent > 0.0 && between.any_positive() {
            let most = (trial - self.cap) / stiffness;
            let low = most.at_least(slow);
            let above = least - low;
            let start = rate * step;
            let start = (start - low).choose((start - least).choose(least, start), low);
            let open = between.choose(-(most - fast), between);
            let sought = self.sought((trial, stiffness), (step, low), (above.choose(start, low), open));
            strain = between.choose((-(most - fast)).choose(sought, most), least);
        }
        strain.at_least(0.0)
    }

    /// The root of the power law, by Newton's steps while it is open. What is left of the stress is a convex function of the
    /// strain that falls: from below they only rise to the root, and from above the first one falls below it, but for what holds
    /// it at the least strain that there can be.
    #[inline(always)]
    fn sought<T: Number>(&self, (trial, stiffness): (T, T), (step, low): (f64, T), (start, mut open): (T, T)) -> T {
        let mut strain = start;
        for _ in 0..STEPS {
            if !open.any_positive() {
                break;
            }
            let bears = self.power_law(strain * (1.0 / step));
            let over = trial - stiffness * strain - bears;
            let next = (strain + over / (stiffness + bears * self.exponent / strain)).or_greater(low);
            strain = open.choose(next, strain);
            open = open.choose(over.absolute() - trial * SETTLED, open);
        }
        strain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gel() -> Strength {
        Strength::new(0.133e6, 0.23, 1.6e6)
    }

    #[test]
    fn the_power_law_holds_between_its_ends() {
        let gel = gel();
        assert_eq!((gel.at(0.0), gel.at(1.0)), (0.133e6, 0.133e6));
        assert!((gel.at(1e3) / (0.133e6 * 1e3_f64.powf(0.23)) - 1.0).abs() < 1e-14);
        assert_eq!(gel.at(1e9), 1.6e6);
        let later = gel.from_rate(500.0);
        assert_eq!((later.at(500.0), later.at(1e9)), (0.133e6, 1.6e6));
        assert!((later.at(5e5) / gel.at(1e3) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn friction_is_as_steep_as_disturbances_in_no_direction_bear() {
        let confinement = Confinement { pressure: 0.4e6, factor: 3.0, time: 0.0 };
        let rise = 1e-6 * 0.4e6;
        let more = confinement.times(-rise) - confinement.times(0.0);
        let slope = more * 1.6e6 / (rise * 3.0_f64.sqrt());
        assert!((gel().confined(confinement).steepest_friction() / slope - 1.0).abs() < 1e-9);
        assert_eq!(gel().steepest_friction(), 0.0);
        for m in [0.05, 0.23, 0.4] {
            let law = Strength::new(0.1e6, m, 1e6);
            let growth =
                |friction: f64, cosine: f64| (1.0 - m) * (1.0 - cosine * cosine) / (1.0 - friction * cosine) - 1.0;
            let most =
                |friction: f64| (0..=2000).map(|i| growth(friction, f64::from(i) / 2000.0)).fold(f64::MIN, f64::max);
            assert!(most(0.999 * law.stable_friction()) < 0.0 && most(1.001 * law.stable_friction()) > 0.0, "{m}");
        }
    }

    #[test]
    fn the_stress_that_is_left_is_what_the_gel_bears_at_the_rate_of_the_return() {
        let stiffness = 3.0 * 4.8e6;
        let laws = [gel(), gel().from_rate(500.0)];
        for (gel, step) in [1e-9, 1e-7, 1e-5, 1e-2, 10.0].iter().flat_map(|step| laws.map(|law| (law, *step))) {
            for rate in [0.0, 1e3, 1e9] {
                for trial in [0.14e6, 0.5e6, 1.5e6, 1.7e6, 5e6, 5e7] {
                    let Returned { stress, strain } = gel.returned((trial, stiffness), 0.0, (step, rate));
                    assert!((stress - gel.at(strain / step)).abs() < 2e-13 * trial, "{step} {trial}");
                    assert!((trial - stiffness * strain - stress).abs() < 1e-12 * trial && strain > 0.0);
                }
            }
        }
        let borne = Returned { stress: 0.13e6, strain: 0.0 };
        assert_eq!(gel().returned((0.13e6, stiffness), 0.0, (1e-6, 0.0)), borne);
    }

    #[test]
    fn it_feels_the_pressure_of_the_last_time_and_all_of_it_without() {
        let feels = |time: f64| gel().confined(Confinement { pressure: 0.4e6, factor: 3.0, time });
        let sliced = |n: i32| (0..n).fold(0.0, |felt, _| feels(2e-6).felt(felt, -1e6, 3e-6 / f64::from(n)));
        let exact = -1e6 * (1.0 - (-1.5_f64).exp());
        let [coarse, fine] = [100, 1000].map(|n| (sliced(n) / exact - 1.0).abs());
        assert!(coarse < 5e-3 && fine < 0.11 * coarse, "{coarse:e}, {fine:e}");
        assert_eq!((feels(0.0).felt(7.0, -1e6, 1e-9), feels(2e-6).felt(7.0, -1e6, 0.0)), (-1e6, 7.0));
        assert_eq!(gel().felt(7.0, -1e6, 1e-9), -1e6);
    }

    #[test]
    fn under_pressure_it_bears_more_in_proportion_up_to_the_factor() {
        let confinement = Confinement { pressure: 0.4e6, factor: 3.0, time: 0.0 };
        let (gel, stiffness, step) = (gel().confined(confinement), 3.0 * 4.8e6, 1e-7);
        for (slope, times) in [(1e6, 1.0), (0.0, 1.0), (-0.2e6, 2.0), (-0.4e6, 3.0), (-7e6, 3.0)] {
            for trial in [0.5e6, 1.5e6, 5e6, 5e7] {
                let Returned { stress, strain } = gel.returned((trial, stiffness), slope, (step, 1e3));
                let bears = times * gel.at(strain / step);
                let stays = strain == 0.0 && stress == trial && trial <= bears;
                assert!(stays || (stress - bears).abs() < 4e-13 * trial, "{slope}, {trial}: {stress} for {bears}");
            }
        }
    }
}
