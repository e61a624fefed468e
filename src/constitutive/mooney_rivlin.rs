#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]
#![allow(clippy::needless_range_loop, reason = "indices of vectors side by side, as in the equations")]

use super::{Hyperelastic, LogarithmicEnergy, ShearResponse};
use crate::math::{Number, SymmetricTensor};

/// Compressible Mooney–Rivlin solid (Mooney 1940, Rivlin 1948), with the neo-Hookean volumetric energy.
///
/// ψ = C₁(I₁ − 3) + C₂(I₂ − 3) + U(J), I₁ = |F|², I₂ = |cof F|², U = −(2C₁ + 4C₂) ln J + Λ/2 (ln J)²; hence P = F
/// [2C₁ + 2C₂(I₁ − C)] + U′(J) cof F, C = FᵀF. Small strains give μ = 2(C₁ + C₂) and K = Λ + 4C₁/3 + 16C₂/3. C₂ = 0
/// gives the neo-Hookean solid of μ = 2C₁. I₁ and I₂ are polynomials: only U needs a continuation below J₀ = 0.2.
///
/// **Stable** for C₁ > 0, C₂ ≥ 0 and Λ ≥ 0. Of the logarithmic strains e_i, ψ is C₁ Σ exp 2e_i + C₂ Σ exp 2(e_i +
/// e_j) − m Σ e_i + Λ/2 (Σ e_i)², each part convex: Kirchhoff stress and logarithmic strain never work against each
/// other (Hill's inequality, Drucker's postulate at large strain), and ψ is polyconvex. C₂ < 0 loses stability in
/// equibiaxial tension.
///
/// **Curvature.** F is diag(s_i) without its rotations. The off-diagonal components of H contribute to d²I₂ at most
/// 2(s_k² + |s_i s_j|)(H_ij² + H_ji²) ≤ 2|F|² of their squares. The diagonal ones contribute 2{|F|²Σh² + 2(Σy)² −
/// 3Σy²}, y_i = s_i h_i, at most 2{|F|²Σh² + (Σy)²}, since (Σy)² ≤ 3Σy²; Σy = F:H. Together d²ψ_s ≤ (2C₁ +
/// 2C₂|F|²)|H|² + 2C₂(F:H)².
///
/// **Domain.** Two constants fit rubber and gels in tension and shear to about twice their length. They do not
/// describe the stiffening near the limit of chain extension. One pair rarely fits tension and compression at once:
/// pig skin is not fitted (Shergold and others 2006). No constants of gelatin are shipped; take them from your own
/// test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MooneyRivlin {
    first: f64,
    second: f64,
    lambda: f64,
}

impl MooneyRivlin {
    /// Creates the solid from C₁, C₂ and the bulk modulus K, Pa.
    ///
    /// # Panics
    /// Unless C₁ > 0, C₂ ≥ 0 and K is at least [`Self::least_bulk_modulus`].
    #[must_use]
    pub fn new([first, second]: [f64; 2], bulk_modulus: f64) -> Self {
        let lambda = bulk_modulus - Self::least_bulk_modulus([first, second]);
        let is_valid = first > 0.0 && second >= 0.0 && lambda >= 0.0;
        assert!(is_valid, "a stable Mooney-Rivlin solid needs C1 > 0, C2 >= 0 and K >= 4/3 C1 + 16/3 C2");
        Self { first, second, lambda }
    }

    /// Returns the bulk modulus of Λ = 0, Pa.
    #[must_use]
    pub fn least_bulk_modulus([first, second]: [f64; 2]) -> f64 {
        2.0 / 3.0 * (2.0 * first) + 16.0 / 3.0 * second
    }

    /// Returns the shear modulus at rest of C₁ and C₂, Pa: 2(C₁ + C₂).
    #[must_use]
    pub fn shear_modulus_of([first, second]: [f64; 2]) -> f64 {
        2.0 * (first + second)
    }

    /// Returns μ at rest, Pa.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        Self::shear_modulus_of([self.first, self.second])
    }

    /// Returns K at rest, Pa.
    #[must_use]
    pub fn bulk_modulus(&self) -> f64 {
        self.lambda + Self::least_bulk_modulus([self.first, self.second])
    }
}

impl Hyperelastic for MooneyRivlin {
    fn volume(&self) -> LogarithmicEnergy {
        LogarithmicEnergy { rest: 2.0 * self.first + 4.0 * self.second, lambda: self.lambda }
    }

    #[inline(always)]
    fn sheared<const D: usize, V: Number>(&self, f: &[[V; D]; D], out: V) -> ShearResponse<D, V> {
        let c = SymmetricTensor::right_cauchy_green(f, out);
        // I₂ is a sum of principal minors: no difference of large numbers.
        let (first, second) = (c.trace(), c.second_invariant());
        let (one, two) = (2.0 * self.first, 2.0 * self.second);
        let isotropic = first * two + one;
        let mut stress = *f;
        for i in 0..D {
            for j in 0..D {
                let mut pulled = f[i][0] * c.of(0, j);
                for k in 1..D {
                    pulled = pulled + f[i][k] * c.of(k, j);
                }
                stress[i][j] = f[i][j] * isotropic - pulled * two;
            }
        }
        ShearResponse {
            energy: (first - 3.0) * self.first + (second - 3.0) * self.second,
            stress,
            out: if D == 2 { (c.inner[0][0] + c.inner[1][1]) * two + one } else { out.constant(0.0) },
            curvature: [isotropic, out.constant(two)],
        }
    }
}
