/// Strength of a gel that flows: the equivalent (von Mises) Kirchhoff stress that it bears at a rate of equivalent plastic strain,
/// Y(ε̇) = Y₀ (ε̇/ε̇₀)^m, no less than Y₀ and no more than the cap; ε̇₀ = 1/s unless it is told.
///
/// Y₀ and m are of one power law, so a gel measured at ε̇₀ (Y₀) is known at the 10⁴/s around a bullet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    yield_stress: f64,
    exponent: f64,
    cap: f64,
    /// ε̇₀, up to which it bears Y₀, 1/s.
    reference: f64,
    /// ε̇ at which the power law meets the cap, 1/s.
    fastest: f64,
}

/// Where the stress comes back to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Returned {
    /// Equivalent stress then, Pa.
    pub stress: f64,
    /// Δε_p, equivalent plastic strain.
    pub strain: f64,
}

/// Newton's steps of the return, and what is left of the stress when it has settled.
const STEPS: usize = 40;
const SETTLED: f64 = 1e-10;

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
        Self { yield_stress, exponent, cap, reference: 1.0, fastest }
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

    /// Y at a rate of equivalent plastic strain, 1/s.
    #[must_use]
    pub fn at(&self, rate: f64) -> f64 {
        if rate <= self.reference || self.exponent == 0.0 {
            return self.yield_stress;
        }
        if rate >= self.fastest {
            self.cap
        } else {
            self.yield_stress * libm::pow(rate / self.reference, self.exponent)
        }
    }

    /// Where a trial stress, Pa, comes back to in a step, s, if it is more than the gel bears: q = q_trial − 3μ̄ Δε = Y(Δε/Δt), an
    /// implicit equation with one root, for the left side falls and the right one rises. It is sought from the rate of the last
    /// return, 1/s, if there was one.
    #[must_use]
    pub fn returned(&self, trial: f64, stiffness: f64, (step, rate): (f64, f64)) -> Option<Returned> {
        let least = (trial - self.yield_stress) / stiffness;
        if !(least > 0.0 && least.is_finite()) {
            return None;
        }
        let back = |strain: f64| Some(Returned { stress: trial - stiffness * strain, strain });
        // What flows so slowly, or so fast, that Y is one of its ends.
        if least <= self.reference * step || self.exponent == 0.0 {
            return back(least);
        }
        let most = (trial - self.cap) / stiffness;
        if most >= self.fastest * step {
            return back(most);
        }
        let (mut low, mut high) = (most.max(self.reference * step), least);
        let mut strain = (rate * step).clamp(low, high);
        for _ in 0..STEPS {
            let bears = self.at(strain / step);
            let over = trial - stiffness * strain - bears;
            if over.abs() <= SETTLED * trial {
                break;
            }
            if over > 0.0 {
                low = strain;
            } else {
                high = strain;
            }
            let next = strain + over / (stiffness + self.exponent * bears / strain);
            strain = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        back(strain)
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
    fn the_stress_that_is_left_is_what_the_gel_bears_at_the_rate_of_the_return() {
        let stiffness = 3.0 * 4.8e6;
        let laws = [gel(), gel().from_rate(500.0)];
        for (gel, step) in [1e-9, 1e-7, 1e-5, 1e-2, 10.0].iter().flat_map(|step| laws.map(|law| (law, *step))) {
            for rate in [0.0, 1e3, 1e9] {
                for trial in [0.14e6, 0.5e6, 1.5e6, 1.7e6, 5e6, 5e7] {
                    let Returned { stress, strain } = gel.returned(trial, stiffness, (step, rate)).unwrap();
                    assert!((stress - gel.at(strain / step)).abs() < 2e-10 * trial, "{step} {trial}");
                    assert!((trial - stiffness * strain - stress).abs() < 1e-12 * trial && strain > 0.0);
                }
            }
        }
        assert_eq!(gel().returned(0.13e6, stiffness, (1e-6, 0.0)), None);
    }
}
