#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::{Hyperelastic, LogarithmicEnergy, ShearResponse};
use crate::math::{Number, array};

/// Compressible neo-Hookean solid (Simo and Pister 1984) whose volumetric energy is continued below J₀.
///
/// ψ(F) = μ/2 (|F|² − 3) + U(J), U(J) = −μ ln J + λ/2 (ln J)², hence P = μ F + U′(J) cof F. Small strains give the
/// shear modulus μ and the bulk modulus K = λ + 2μ/3. ψ_s is quadratic: d²ψ_s = μ|H|², a bound and equality.
///
/// U diverges as J → 0: one missed event would end a run. Below J₀ U continues as its second-order Taylor polynomial
/// (C², method 6.1): ψ and P stay closed forms, exact for J ≥ J₀ and defined for every J, with a bounded U″ and so
/// a bounded step. The energy stored at J < J₀ is that of the continuation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHookean {
    shear: f64,
    lambda: f64,
}

impl NeoHookean {
    /// Volume ratio J₀ below which the continuation begins, as [`LogarithmicEnergy::FLOOR`].
    pub const FLOOR: f64 = LogarithmicEnergy::FLOOR;

    /// Creates the solid from the shear modulus μ and the bulk modulus K, Pa.
    ///
    /// # Panics
    /// If μ ≤ 0 or K < 2μ/3.
    #[must_use]
    pub fn new(shear_modulus: f64, bulk_modulus: f64) -> Self {
        let lambda = bulk_modulus - 2.0 / 3.0 * shear_modulus;
        assert!(shear_modulus > 0.0 && lambda >= 0.0, "a stable solid needs mu > 0 and K >= 2/3 mu");
        Self { shear: shear_modulus, lambda }
    }

    /// Returns μ, Pa.
    #[must_use]
    pub fn shear_modulus(&self) -> f64 {
        self.shear
    }

    /// Returns the pressure wave modulus λ + 2μ at rest, Pa.
    #[must_use]
    pub fn wave_modulus(&self) -> f64 {
        self.lambda + 2.0 * self.shear
    }

    /// Returns the plane contact modulus E/(1 − ν²) at rest, Pa.
    #[must_use]
    pub fn contact_modulus(&self) -> f64 {
        4.0 * self.shear * (self.lambda + self.shear) / (self.lambda + 2.0 * self.shear)
    }
}

impl Hyperelastic for NeoHookean {
    fn volume(&self) -> LogarithmicEnergy {
        LogarithmicEnergy { rest: self.shear, lambda: self.lambda }
    }

    #[inline(always)]
    fn sheared<const D: usize, V: Number>(&self, f: &[[V; D]; D], out: V) -> ShearResponse<D, V> {
        let (mu, zero) = (self.shear, out.constant(0.0));
        let plane = array::norm_squared(f);
        let square = if D == 2 { out * out + plane } else { plane };
        ShearResponse {
            energy: (square - 3.0) * (0.5 * mu),
            stress: f.map(|row| row.map(|component| component * mu)),
            out: zero + mu,
            curvature: [zero + mu, zero],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::VolumetricEnergy;

    #[test]
    fn derivatives_agree_with_central_differences_on_both_sides_of_the_floor() {
        let gel = NeoHookean::new(69e3, 667e3).volume();
        let step = 1e-6;
        for j in [-0.4, 0.0, 0.1, 0.199, 0.201, 0.5, 1.0, 1.7, 6.0] {
            let (a, b, at) = (gel.volumetric(j - step), gel.volumetric(j + step), gel.volumetric(j));
            assert!(((b.energy - a.energy) / (2.0 * step) - at.slope).abs() < 1e-6 * at.slope.abs().max(1e5));
            assert!(((b.slope - a.slope) / (2.0 * step) - at.curvature).abs() < 1e-5 * at.curvature.abs().max(1e5));
        }
    }

    #[test]
    fn the_continuation_is_twice_continuously_differentiable() {
        let gel = NeoHookean::new(3.0, 7.0).volume();
        let (below, above) = (gel.volumetric(NeoHookean::FLOOR - 1e-12), gel.volumetric(NeoHookean::FLOOR));
        assert!((below.energy - above.energy).abs() < 1e-9);
        assert!((below.slope - above.slope).abs() < 1e-8);
        assert!((below.curvature - above.curvature).abs() < 1e-8);
    }

    #[test]
    fn moduli_agree_with_young_and_poisson() {
        let (e, nu) = (200e3, 0.45);
        let gel = NeoHookean::new(e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu)));
        assert!((gel.wave_modulus() / (e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))) - 1.0).abs() < 1e-12);
        assert!((gel.contact_modulus() / (e / (1.0 - nu * nu)) - 1.0).abs() < 1e-12);
        assert_eq!(gel.volume().volumetric(1.0).slope, -gel.shear_modulus());
    }
}
