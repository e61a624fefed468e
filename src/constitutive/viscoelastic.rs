#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{IsochoricDeformation, LogarithmicEnergy, NeoHookean};
use crate::math::{Number, SymmetricTensor, array, exp, exp_less_one, isochoric_mean};

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

    /// Relaxes the rest shape C̄_i⁻¹ of a branch in a step, s, at the strain before it, then at the strain now.
    ///
    /// Returns the energy lost, J/m³.
    ///
    /// The loss is the fall of tr b̄ at both strains, corrected for the work of the branch between them. The nodes do
    /// work against the mean of the first and the last stress; the excess of the two relaxed stresses over this mean
    /// is, to second order, ½ (d_b − d_a):[(1 − s_b) d_b − (1 − s_a) d], d_a = s_a d.
    #[inline(always)]
    pub fn relax<const D: usize, V: Number>(
        &self,
        branch: &mut SymmetricTensor<D, V>,
        [before, now]: [&IsochoricShape<D, V>; 2],
        step: f64,
    ) -> V {
        let parts = self.relaxation_factors(step);
        let [first, second] = [before.relax(branch, parts[0]), now.relax(branch, parts[1])];
        let mut both = first.out * second.out;
        for i in 0..D {
            for j in 0..D {
                both = both + first.inner[i][j] * second.inner[j][i];
            }
        }
        // (d_b − s_a d_a):[(1 − s_b) d_b − (1 − s_a) d_a].
        let (left, gone) = (parts[0], parts.map(|part| 1.0 - part));
        let excess = second.square * gone[1] - both * (gone[0] + left * gone[1]) + first.square * (left * gone[0]);
        let zero = excess.constant(0.0);
        let both_relax = before.above_floor.choose(now.above_floor, zero);
        (first.fall + second.fall - both_relax.choose(excess * 0.5, zero)) * (0.5 * self.shear_modulus)
    }

    /// Evaluates W_i = μ_i/2 (tr b̄_i − 3) at the rest shape C̄_i⁻¹ of the branch.
    #[inline(always)]
    pub fn respond<const D: usize, V: Number>(
        &self,
        at: &IsochoricDeformation<D, V>,
        rest: &SymmetricTensor<D, V>,
    ) -> BranchResponse<D, V> {
        let (mu, part, zero) = (self.shear_modulus, at.scale * self.shear_modulus, at.scale.constant(0.0));
        let pulled = at.times_inverse_shape(rest);
        let elastic = at.elastic(&pulled, rest.out);
        let trace = elastic.trace();
        BranchResponse {
            energy: (trace - 3.0) * (0.5 * mu),
            stress: pulled.map(|row| row.map(|component| component * part)),
            out: rest.out * part,
            pressure: at.above_floor.choose(trace * (1.0 / 3.0) * mu / at.jacobian, zero),
            elastic,
        }
    }
}

/// Isochoric shapes C̄⁻¹ and C̄; a branch relaxes where `above_floor` is positive.
#[derive(Clone, Copy)]
pub struct IsochoricShape<const D: usize, V> {
    /// C̄⁻¹.
    pub inverse: SymmetricTensor<D, V>,
    shape: SymmetricTensor<D, V>,
    /// Height of J above the floor, at most 0 where the element is inverted.
    pub above_floor: V,
}

/// Relaxation of a branch at a constant strain: dev(C̄ C̄_i⁻¹) before it, with its out-of-plane component and square.
struct BranchRelaxation<const D: usize, V> {
    inner: [[V; D]; D],
    out: V,
    square: V,
    /// Decrease of tr b̄.
    fall: V,
}

/// Energy and stress of a branch, ∂W_i/∂F = `stress` − `pressure` ∂J/∂F.
pub struct BranchResponse<const D: usize, V> {
    /// W_i, J/m³.
    pub energy: V,
    /// Rows of μ_i J^(−2/3) F C̄_i⁻¹, Pa.
    pub stress: [[V; D]; D],
    /// Out-of-plane component of `stress` over λ, Pa.
    pub out: V,
    /// μ_i tr b̄_i/(3J), which removes the trace of the stress, Pa; 0 below the floor of J.
    pub pressure: V,
    /// b̄_i.
    pub elastic: SymmetricTensor<D, V>,
}

impl<const D: usize, V: Number> IsochoricShape<D, V> {
    /// Returns the shapes at the last tick from the history variables.
    #[inline(always)]
    pub fn before(inverse: SymmetricTensor<D, V>, jacobian: V) -> Self {
        Self { shape: inverse.inverse(), inverse, above_floor: jacobian - LogarithmicEnergy::FLOOR }
    }

    /// Returns the present shapes.
    #[inline(always)]
    pub fn now(at: &IsochoricDeformation<D, V>) -> Self {
        let zero = at.scale.constant(0.0);
        let over = at.scale.constant(1.0) / (at.det_f * at.det_f * at.scale);
        let square = at.out * at.out * at.scale;
        let mut now = Self {
            inverse: SymmetricTensor::diagonal(zero, if D == 2 { square.constant(1.0) / square } else { zero }),
            shape: SymmetricTensor::diagonal(zero, if D == 2 { square } else { zero }),
            above_floor: at.det_f.choose(at.above_floor, zero),
        };
        for i in 0..D {
            for j in i..D {
                let (mut inverse, mut shape) = (at.cofactor[0][i] * at.cofactor[0][j], at.f[0][i] * at.f[0][j]);
                for k in 1..D {
                    inverse = inverse + at.cofactor[k][i] * at.cofactor[k][j];
                    shape = shape + at.f[k][i] * at.f[k][j];
                }
                (now.inverse.inner[i][j], now.shape.inner[i][j]) = (inverse * over, shape * at.scale);
            }
        }
        now
    }

    /// Relaxes dev b̄ of a branch to its part s at this constant shape.
    ///
    /// b̄ = θ + d, tr d = 0, becomes θ' + s d with θ'³ − θ' s²|d|²/2 + s³ det d = 1, hence C̄_i⁻¹ becomes s C̄_i⁻¹ +
    /// (θ' − sθ) C̄⁻¹; θ, |d|² and det d are those of C̄ C̄_i⁻¹, too, which has the eigenvalues of b̄.
    #[inline(always)]
    fn relax(&self, branch: &mut SymmetricTensor<D, V>, left: f64) -> BranchRelaxation<D, V> {
        let zero = branch.out.constant(0.0);
        let mut inner = [[zero; D]; D];
        let mut out = if D == 2 { self.shape.out * branch.out } else { zero };
        let mut trace = out;
        for i in 0..D {
            for j in 0..D {
                let mut sum = self.shape.of(i, 0) * branch.of(0, j);
                for k in 1..D {
                    sum = sum + self.shape.of(i, k) * branch.of(k, j);
                }
                inner[i][j] = sum;
            }
            trace = trace + inner[i][i];
        }
        let before = trace * (1.0 / 3.0);
        if D == 2 {
            out = out - before;
        }
        let mut square = out * out;
        for i in 0..D {
            inner[i][i] = inner[i][i] - before;
            square = square + inner[i][i] * inner[i][i];
            for j in 0..i {
                square = square + inner[i][j] * inner[j][i] * 2.0;
            }
        }
        let determinant = determinant(&inner, out);
        let after = isochoric_mean(before, square * (0.5 * left * left), determinant * (left * left * left));
        let relaxed = branch.combined(left, &self.inverse, after - before * left);
        *branch = relaxed.where_positive(self.above_floor, branch);
        BranchRelaxation { inner, out, square, fall: self.above_floor.choose((before - after) * 3.0, zero) }
    }
}

/// Returns the determinant of a tensor with its out-of-plane component.
#[inline(always)]
fn determinant<const D: usize, V: Number>(a: &[[V; D]; D], out: V) -> V {
    let inner = array::det(a);
    if D == 2 { inner * out } else { inner }
}

/// Finite-strain viscoelastic material: a neo-Hookean equilibrium spring with parallel Maxwell branches (numerics 6.4),
/// each split into an elastic and a viscous part (Reese and Govindjee 1998).
///
/// ψ = ψ_∞(F) + Σ μ_i/2 (tr b̄_i − 3), b̄_i = F̄ C̄_i⁻¹ F̄ᵀ with F̄ = J^(−1/3) F: each branch has a rest shape C̄_i of
/// determinant 1. With ∂(J^(−2/3))/∂F = −2/(3J) J^(−2/3) ∂J/∂F the stress is P = P_∞ + Σ μ_i [J^(−2/3) F C̄_i⁻¹ −
/// tr b̄_i/(3J) ∂J/∂F].
///
/// At a constant strain dev b̄_i, and so the Kirchhoff stress of the branch, falls as e^(−t/τ_i) while det b̄_i is
/// still 1. On that path d(tr b̄)/dt = −(tr b̄ tr b̄⁻¹ − 9)/(τ tr b̄⁻¹) ≤ 0 (Cauchy): energy is only lost. Small strains
/// give the shear modulus G(ω) = μ + Σ μ_i iωτ_i/(1 + iωτ_i), the Prony series; the bulk modulus does not relax.
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
