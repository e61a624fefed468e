use super::NeoHookean;
use crate::math::{exp, exp_less_one};

/// A Maxwell branch: a spring in shear whose strain is forgotten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// μ_i, Pa.
    pub shear_modulus: f64,
    /// τ_i, s: at a held strain its stress falls as e^(−t/τ_i).
    pub time: f64,
}

impl Branch {
    /// Parts of its stress that are left of a step, s: of what it had before by forgetting where the gel was, and of all by forgetting
    /// where it is now.
    ///
    /// With x = Δt/τ their product is e^(−x), that of a held strain, and the second (1 − e^(−x))/x, that of a strain that has grown
    /// evenly: a branch that forgets much faster than it is looked at is a dashpot.
    #[must_use]
    pub fn left(&self, step: f64) -> [f64; 2] {
        let x = step / self.time;
        let now = if x > 0.0 { -exp_less_one(-x) / x } else { 1.0 };
        [exp(-x) / now, now]
    }
}

/// A gel with a memory that fades: neo-Hookean in the long run, with Maxwell branches beside it (numerics 6.4).
///
/// ψ = ψ_∞(F) + Σ μ_i/2 (tr b̄_i − 3), b̄_i = F̄ C̄_i⁻¹ F̄ᵀ with F̄ = J^(−1/3) F: each branch has a rest shape C̄_i of its own, of determinant 1.
/// At a held strain dev b̄_i, and so its Kirchhoff stress, falls as e^(−t/τ_i) while det b̄_i stays 1. On that path
/// d(tr b̄)/dt = −(tr b̄ tr b̄⁻¹ − 9)/(τ tr b̄⁻¹) ≤ 0 (Cauchy): energy is only lost. Small strains give the shear modulus
/// G(ω) = μ + Σ μ_i iωτ_i/(1 + iωτ_i), the Prony series; the bulk modulus does not relax.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viscoelastic {
    equilibrium: NeoHookean,
    branches: [Branch; Self::MOST_BRANCHES],
    n_branches: usize,
}

impl Viscoelastic {
    /// Most branches of a gel: three span the four decades from the passing of a wave through an element to a bounce.
    pub const MOST_BRANCHES: usize = 3;

    /// From what it is in the long run and its branches.
    ///
    /// # Panics
    /// Unless there are 1 to [`Self::MOST_BRANCHES`] branches, all of positive modulus and time.
    #[must_use]
    pub fn new(equilibrium: NeoHookean, branches: &[Branch]) -> Self {
        let n_branches = branches.len();
        let known = (1..=Self::MOST_BRANCHES).contains(&n_branches);
        let sound = |branch: &Branch| branch.shear_modulus > 0.0 && branch.time > 0.0;
        assert!(known && branches.iter().all(sound), "a viscoelastic gel has 1 to 3 branches with mu > 0 and tau > 0");
        let mut own = [branches[0]; Self::MOST_BRANCHES];
        own[..n_branches].copy_from_slice(branches);
        Self { equilibrium, branches: own, n_branches }
    }

    /// What it is in the long run.
    #[must_use]
    pub fn equilibrium(&self) -> &NeoHookean {
        &self.equilibrium
    }

    /// Its branches.
    #[must_use]
    pub fn branches(&self) -> &[Branch] {
        &self.branches[..self.n_branches]
    }

    /// What it is in a change that is too fast for all branches.
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
    fn two_steps_leave_what_one_of_both_leaves() {
        let branch = Branch { shear_modulus: 1.0, time: 3e-3 };
        let left = |step: f64| branch.left(step).iter().product::<f64>();
        assert!((left(1e-3) * left(4e-3) / left(5e-3) - 1.0).abs() < 1e-15);
        assert_eq!(branch.left(0.0), [1.0; 2]);
    }

    #[test]
    fn fast_changes_feel_all_branches() {
        let rest = NeoHookean::new(3.0, 40.0);
        let branch = |shear_modulus| Branch { shear_modulus, time: 1.0 };
        let gel = Viscoelastic::new(rest, &[branch(2.0), branch(4.0)]);
        let fast = gel.instantaneous();
        assert!((fast.shear_modulus() - 9.0).abs() < 1e-14);
        assert!((fast.wave_modulus() - NeoHookean::new(9.0, 40.0).wave_modulus()).abs() < 1e-13);
    }
}
