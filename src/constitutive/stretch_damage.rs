#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::Number;

/// Delayed damage by stretch: ḋ = ⟨λ/λ_c − 1⟩/τ_d up to 1, λ the greatest principal stretch of the elastic network
/// (delay: Allix and Deü 1997).
///
/// Bonds take time to break, and so the damaged zone does not shrink with the elements. d never falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StretchDamage {
    critical_stretch: f64,
    delay: f64,
}

impl StretchDamage {
    /// Creates the law from λ_c and τ_d, s.
    ///
    /// # Panics
    /// Unless λ_c > 1 and τ_d > 0.
    #[must_use]
    pub fn new(critical_stretch: f64, delay: f64) -> Self {
        assert!(critical_stretch > 1.0 && delay > 0.0, "damage needs a critical stretch > 1 and a delay > 0");
        Self { critical_stretch, delay }
    }

    /// Returns λ_c.
    #[must_use]
    pub fn critical_stretch(&self) -> f64 {
        self.critical_stretch
    }

    /// Returns d after a step, s, at the stretch λ of its end.
    #[must_use]
    #[inline(always)]
    pub fn after_step<T: Number>(&self, before: T, stretch: T, step: f64) -> T {
        let excess = (stretch * (1.0 / self.critical_stretch) - 1.0).at_least(0.0);
        (before + excess * (step / self.delay)).at_most(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_grows_by_the_excess_of_stretch_over_the_delay_up_to_one_and_never_heals() {
        let law = StretchDamage::new(3.0, 1e-5);
        let sliced = (0..50).fold(0.1, |damage, _| law.after_step(damage, 4.5, 2e-7));
        assert!((sliced - 0.6).abs() < 1e-14);
        assert_eq!(law.after_step(0.3, 2.999, 1.0), 0.3);
        assert_eq!(law.after_step(0.3, 30.0, 1.0), 1.0);
        assert_eq!(law.after_step(0.3, 30.0, 0.0), 0.3);
    }
}
