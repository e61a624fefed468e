#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::{Number, exp};

/// Delayed isotropic damage (Allix, Deü 1997): the factor g multiplies the elastic shear stress and the yield stress.
///
/// The equivalent plastic strain ε_p sets the limit g∞(ε_p) = r + (1 − r)/(1 + (ε_p/ε_s)²): 1 without plastic strain,
/// halfway to the residual r at ε_s. g relaxes towards it in a time τ, ġ = −(g − g∞)/τ, since bonds take time to
/// break. g multiplies μ and Y alike, so a damaged gel is the sound gel under g times its stress (strain equivalence:
/// Lemaitre 1971): onset and amount of plastic flow do not depend on g. ε_p only grows, and g only falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DamageLaw {
    strain: f64,
    residual: f64,
    time: f64,
}

impl DamageLaw {
    /// Creates the damage law from ε_s, r and τ, s; τ = 0 means no delay.
    ///
    /// # Panics
    /// Unless ε_s > 0, 0 < r ≤ 1 and τ ≥ 0.
    #[must_use]
    pub fn new(strain: f64, residual: f64, time: f64) -> Self {
        let is_valid = strain > 0.0 && residual > 0.0 && residual <= 1.0 && time >= 0.0;
        assert!(is_valid, "softening needs a strain > 0, 0 < residual <= 1 and a time >= 0");
        Self { strain, residual, time }
    }

    /// Returns the limit g∞ of the damage factor, from 1 down to r.
    #[must_use]
    #[inline(always)]
    pub fn limit<T: Number>(&self, plastic: T) -> T {
        let strained = plastic * (1.0 / self.strain);
        plastic.constant(1.0 - self.residual) / (strained * strained + 1.0) + self.residual
    }

    /// Returns g after a step, s, at the plastic strain of its end; exact for a constant plastic strain.
    #[must_use]
    #[inline(always)]
    pub fn after_step<T: Number>(&self, before: T, plastic: T, step: f64) -> T {
        if step <= 0.0 {
            return before;
        }
        let limit = self.limit(plastic);
        let excess = before - limit;
        excess.choose(limit + excess * exp(-step / self.time), before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_falls_from_one_to_the_residual() {
        let law = DamageLaw::new(0.5, 0.02, 0.0);
        assert_eq!(law.limit(0.0), 1.0);
        assert!((law.limit(0.5) - 0.51).abs() < 1e-15 && (law.limit(1e9) - 0.02).abs() < 1e-15);
        assert!((0..400).all(|i| law.limit(0.01 * f64::from(i + 1)) < law.limit(0.01 * f64::from(i))));
    }

    #[test]
    fn damage_relaxes_in_its_time_for_any_step_and_never_heals() {
        let law = DamageLaw::new(0.5, 0.02, 1e-4);
        let (whole, end) = (law.after_step(1.0, 0.5, 2e-4), law.limit(0.5));
        assert!((whole - end - (1.0 - end) * (-2.0_f64).exp()).abs() < 1e-15);
        let sliced = (0..50).fold(1.0, |left, _| law.after_step(left, 0.5, 4e-6));
        assert!((sliced - whole).abs() < 1e-14);
        assert_eq!(law.after_step(0.3, 0.5, 1.0), 0.3);
        assert_eq!(law.after_step(0.8, 0.5, 0.0), 0.8);
        assert_eq!(DamageLaw::new(0.5, 0.02, 0.0).after_step(1.0, 0.5, 1e-9), end);
    }
}
