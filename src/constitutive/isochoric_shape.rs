#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{IsochoricDeformation, LinearDashpot, LogarithmicEnergy};
use crate::math::{Number, SymmetricTensor, array, isochoric_mean};

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
        let relaxed = branch.combined(zero + left, &self.inverse, after - before * left);
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

impl LinearDashpot {
    /// Relaxes the rest shape C̄_i⁻¹ of a branch in a step, s, at the strain before it, then at the strain now.
    ///
    /// Returns the fall of tr b̄_i, the energy lost over μ_i/2.
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
        // (d_b − s_a d_a):[(1 − s_b) d_b − (1 − s_a) d].
        let (left, gone) = (parts[0], parts.map(|part| 1.0 - part));
        let excess = second.square * gone[1] - both * (gone[0] + left * gone[1]) + first.square * (left * gone[0]);
        let zero = excess.constant(0.0);
        let both_relax = before.above_floor.choose(now.above_floor, zero);
        first.fall + second.fall - both_relax.choose(excess * 0.5, zero)
    }
}
