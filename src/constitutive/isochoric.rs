#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::LogarithmicEnergy;
use crate::math::{Number, SymmetricTensor, array, exp, ln};

/// Deformation split into its volume change and F̄ = J^(−1/3) F (Flory 1961); J^(−2/3) is constant below the floor.
#[derive(Clone, Copy)]
pub struct IsochoricDeformation<const D: usize, V> {
    /// Rows of F.
    pub f: [[V; D]; D],
    /// Out-of-plane stretch λ.
    pub out: V,
    /// det F in the plane or in space, without λ.
    pub det_f: V,
    /// cof F.
    pub cofactor: [[V; D]; D],
    /// J, clamped to the floor of the volumetric energy.
    pub jacobian: V,
    /// J^(−2/3).
    pub scale: V,
    /// Height of J above the floor, at most 0 in the continuation.
    pub above_floor: V,
}

impl<const D: usize, V: Number> IsochoricDeformation<D, V> {
    /// Computes the split from F, the out-of-plane stretch and det F.
    #[inline(always)]
    pub fn new(f: &[[V; D]; D], out: V, det_f: V) -> Self {
        let now = if D == 2 { det_f * out } else { det_f };
        let (jacobian, above_floor) = (now.at_least(LogarithmicEnergy::FLOOR), now - LogarithmicEnergy::FLOOR);
        let scale = exp(ln(jacobian) * (-2.0 / 3.0));
        Self { f: *f, out, det_f, cofactor: array::fused_cofactors(f), jacobian, scale, above_floor }
    }

    /// Returns F C̄⁻¹ for the rest shape of the history variables.
    #[inline(always)]
    pub fn times_inverse_shape(&self, memory: &SymmetricTensor<D, V>) -> [[V; D]; D] {
        let f = &self.f;
        let mut all = *f;
        for i in 0..D {
            for j in 0..D {
                let mut sum = f[i][0] * memory.of(0, j);
                for k in 1..D {
                    sum = sum + f[i][k] * memory.of(k, j);
                }
                all[i][j] = sum;
            }
        }
        all
    }

    /// Returns b̄ = J^(−2/3) F C̄⁻¹ Fᵀ from F C̄⁻¹ and the out-of-plane component of C̄⁻¹.
    #[inline(always)]
    pub fn elastic(&self, pulled: &[[V; D]; D], out: V) -> SymmetricTensor<D, V> {
        let (f, zero) = (&self.f, self.scale.constant(0.0));
        let mut inner = [[zero; D]; D];
        for i in 0..D {
            for j in i..D {
                let mut sum = pulled[i][0] * f[j][0];
                for k in 1..D {
                    sum = pulled[i][k] * f[j][k] + sum;
                }
                inner[i][j] = sum * self.scale;
            }
        }
        let out = if D == 2 { self.out * self.out * out * self.scale } else { zero };
        SymmetricTensor { inner, out }
    }

    /// Returns the pull-back C̄⁻¹ = J^(2/3) F⁻¹ b̄ F⁻ᵀ of b̄.
    #[inline(always)]
    pub fn pull_back(&self, elastic: &SymmetricTensor<D, V>) -> SymmetricTensor<D, V> {
        let c = &self.cofactor;
        let zero = self.scale.constant(0.0);
        let over = self.scale.constant(1.0) / (self.det_f * self.det_f * self.scale);
        let (mut half, mut inner) = ([[zero; D]; D], [[zero; D]; D]);
        for i in 0..D {
            for j in 0..D {
                half[i][j] = c[0][i] * elastic.of(0, j);
                for k in 1..D {
                    half[i][j] = half[i][j] + c[k][i] * elastic.of(k, j);
                }
            }
        }
        for i in 0..D {
            for j in i..D {
                let mut sum = half[i][0] * c[0][j];
                for k in 1..D {
                    sum = sum + half[i][k] * c[k][j];
                }
                inner[i][j] = sum * over;
            }
        }
        let out = if D == 2 { elastic.out / (self.out * self.out * self.scale) } else { zero };
        SymmetricTensor { inner, out }
    }
}
