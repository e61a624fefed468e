use super::NeoHookean;
use crate::math::{exp, exp_less_one};

/// Maxwell branch: a shear spring in series with a dashpot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxwellBranch {
    /// μ_i, Pa.
    pub shear_modulus: f64,
    /// Relaxation time τ_i, s: at a constant strain the branch stress falls as e^(−t/τ_i).
    pub time: f64,
}

impl MaxwellBranch {
    /// Returns the two relaxation factors of a step, s: at the strain of its start, then at the strain of its end.
    ///
    /// With x = Δt/τ the product is e^(−x), exact for a constant strain. The second factor (1 − e^(−x))/x is exact
    /// for a strain that grows linearly: a branch with τ far below the step acts as a dashpot.
    #[must_use]
    pub fn relaxation_factors(&self, step: f64) -> [f64; 2] {
        let x = step / self.time;
        let now = if x > 0.0 { -exp_less_one(-x) / x } else { 1.0 };
        [exp(-x) / now, now]
    }
}

/// Finite-strain viscoelastic material: a neo-Hookean equilibrium spring with parallel Maxwell branches (numerics 6.4).
///
/// ψ = ψ_∞(F) + Σ μ_i/2 (tr b̄_i − 3), b̄_i = F̄ C̄_i⁻¹ F̄ᵀ with F̄ = J^(−1/3) F: each branch has a rest shape C̄_i
/// of determinant 1. At a constant strain dev b̄_i, and so the Kirchhoff stress of the branch, falls as e^(−t/τ_i)
/// while det b̄_i stays 1. On that path d(tr b̄)/dt = −(tr b̄ tr b̄⁻¹ − 9)/(τ tr b̄⁻¹) ≤ 0 (Cauchy): energy is only
/// lost. Small strains give the shear modulus G(ω) = μ + Σ μ_i iωτ_i/(1 + iωτ_i), the Prony series; the bulk modulus
/// does not relax.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viscoelastic {
    equilibrium: NeoHookean,
    branches: [MaxwellBranch; Self::MOST_BRANCHES],
    n_branches: usize,
}

impl Viscoelastic {
    /// Most branches of a material: three span the four decades from a wave crossing an element to a rebound.
    pub const MOST_BRANCHES: usize = 3;

    /// Creates the material from its equilibrium spring and its branches.
    ///
    /// # Panics
    /// Unless there are 1 to [`Self::MOST_BRANCHES`] branches, all of positive modulus and time.
    #[must_use]
    pub fn new(equilibrium: NeoHookean, branches: &[MaxwellBranch]) -> Self {
        let n_branches = branches.len();
        let known = (1..=Self::MOST_BRANCHES).contains(&n_branches);
        let is_valid = |branch: &MaxwellBranch| branch.shear_modulus > 0.0 && branch.time > 0.0;
        assert!(
            known && branches.iter().all(is_valid),
            "a viscoelastic gel has 1 to 3 branches with mu > 0 and tau > 0"
        );
        let mut own = [branches[0]; Self::MOST_BRANCHES];
        own[..n_branches].copy_from_slice(branches);
        Self { equilibrium, branches: own, n_branches }
    }

    /// Returns the equilibrium (long-term) solid.
    #[must_use]
    pub fn equilibrium(&self) -> &NeoHookean {
        &self.equilibrium
    }

    /// Returns the Maxwell branches.
    #[must_use]
    pub fn branches(&self) -> &[MaxwellBranch] {
        &self.branches[..self.n_branches]
    }

    /// Returns the instantaneous solid, without relaxation of any branch.
    #[must_use]
    pub fn instantaneous(&self) -> NeoHookean {
        let (rest, fast) = (&self.equilibrium, self.branches().iter().map(|branch| branch.shear_modulus).sum::<f64>());
        NeoHookean::new(rest.shear_modulus() + fast, rest.wave_modulus() - 4.0 / 3.0 * rest.shear_modulus())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relaxation_of_two_steps_is_that_of_their_sum() {
        let branch = MaxwellBranch { shear_modulus: 1.0, time: 3e-3 };
        let left = |step: f64| branch.relaxation_factors(step).iter().product::<f64>();
        assert!((left(1e-3) * left(4e-3) / left(5e-3) - 1.0).abs() < 1e-15);
        assert_eq!(branch.relaxation_factors(0.0), [1.0; 2]);
    }

    #[test]
    fn the_instantaneous_modulus_includes_all_branches() {
        let rest = NeoHookean::new(3.0, 40.0);
        let branch = |shear_modulus| MaxwellBranch { shear_modulus, time: 1.0 };
        let gel = Viscoelastic::new(rest, &[branch(2.0), branch(4.0)]);
        let fast = gel.instantaneous();
        assert!((fast.shear_modulus() - 9.0).abs() < 1e-14);
        assert!((fast.wave_modulus() - NeoHookean::new(9.0, 40.0).wave_modulus()).abs() < 1e-13);
    }
}
