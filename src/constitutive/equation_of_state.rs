#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use super::{NeoHookean, VolumetricResponse};
use crate::math::{Number, ln};

/// Equation of state p = −U′(J), a function of the volume alone; U is the energy per rest volume.
///
/// Compression, χ = 1 − J > 0, follows the measured shock speed U_s = c₀ + s u_p. The Rankine–Hugoniot relations,
/// taken as a function of volume only, give p = K χ/(1 − sχ)², K = ρc₀², whence U = K/s² [ln(1 − sχ) + 1/(1 − sχ) −
/// 1]. With s = 0, and always in tension, p = K (1/J − 1): U = K (J − 1 − ln J). Both have the bulk modulus K at
/// rest, and only the slope of U″ jumps there, by (4s − 2) K.
///
/// In tension the pressure falls no further than to −`tension`: beyond, a reversible void opens (tension cut-off). There
/// the curvature is that at the limit and no derivative of the slope: steps chosen by U″ = 0 are ten times as long as the
/// closed gel allows, and a void may close within one (method 1.3f).
/// Where 1 − sχ falls below [`Self::LEAST`], or J below [`NeoHookean::FLOOR`], U continues as its second-order Taylor
/// polynomial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquationOfState {
    bulk: f64,
    slope: f64,
    tension: f64,
}

impl EquationOfState {
    /// Least 1 − sχ before the continuation: there p is 10 K for s = 2, far above any shot into gel.
    pub const LEAST: f64 = 0.2;

    /// Creates the equation of state from the bulk modulus K, Pa, the slope s of the shock speed, and the tension
    /// limit, Pa.
    ///
    /// s = 0 means no shock term; an infinite tension limit means no cut-off.
    ///
    /// # Panics
    /// If K or the tension is not positive, or s negative.
    #[must_use]
    pub fn new(bulk_modulus: f64, slope: f64, tension: f64) -> Self {
        assert!(bulk_modulus > 0.0 && slope >= 0.0 && tension > 0.0, "an equation of state needs K > 0, s >= 0, t > 0");
        Self { bulk: bulk_modulus, slope, tension }
    }

    /// Returns K at rest, Pa.
    #[must_use]
    pub fn bulk_modulus(&self) -> f64 {
        self.bulk
    }

    /// Returns true if voids open at a limited tension.
    #[must_use]
    pub fn has_tension_limit(&self) -> bool {
        self.tension.is_finite()
    }

    /// Returns U and its derivatives at J; branch-free, for vector units.
    #[must_use]
    #[inline(always)]
    pub fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        let floor = self.floor();
        continued(&self.regular(j.at_least(floor)), (j - floor).at_most(0.0))
    }

    /// Returns the J below which the continuation of U begins.
    #[inline(always)]
    fn floor(&self) -> f64 {
        let shock = if self.slope > 0.0 { 1.0 - (1.0 - Self::LEAST) / self.slope } else { 0.0 };
        shock.max(NeoHookean::FLOOR)
    }

    /// U and its derivatives above the floor.
    #[inline(always)]
    fn regular<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        // At the tension cut-off J is clamped, and U continues as its tangent.
        let limit = 1.0 - self.tension / self.bulk;
        let at = if limit > 0.0 { j.at_most(1.0 / limit) } else { j };
        let beyond = j - at;
        let soft = self.soft(at);
        let drawn = VolumetricResponse {
            energy: beyond.choose(soft.energy + beyond * self.tension, soft.energy),
            slope: beyond.choose(j.constant(self.tension), soft.slope),
            curvature: soft.curvature,
        };
        if self.slope == 0.0 {
            return drawn;
        }
        let (strained, shocked) = (-(j - 1.0), self.shocked((-(j - 1.0)).at_least(0.0)));
        VolumetricResponse {
            energy: strained.choose(shocked.energy, drawn.energy),
            slope: strained.choose(shocked.slope, drawn.slope),
            curvature: strained.choose(shocked.curvature, drawn.curvature),
        }
    }

    /// Tension branch, p = K (1/J − 1).
    #[inline(always)]
    fn soft<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        let (k, inverse) = (self.bulk, j.constant(1.0) / j);
        VolumetricResponse {
            energy: (j - 1.0 - ln(j)) * k,
            slope: -((inverse - 1.0) * k),
            curvature: inverse * inverse * k,
        }
    }

    /// Shock branch, p = K χ/(1 − sχ)².
    #[inline(always)]
    fn shocked<T: Number>(&self, x: T) -> VolumetricResponse<T> {
        let (k, s) = (self.bulk, self.slope);
        let strained = x * s;
        let rest = -(strained - 1.0);
        let inverse = x.constant(1.0) / rest;
        // ln r + 1/r − 1 loses all digits at small strains; its series there is (sχ)²/2 + 2(sχ)³/3 + 3(sχ)⁴/4.
        let small = x * x * (strained * (strained * 0.75 + 2.0 / 3.0) + 0.5);
        let large = (ln(rest) + inverse - 1.0) * (1.0 / (s * s));
        let square = inverse * inverse * k;
        VolumetricResponse {
            energy: (strained - 1e-3).choose(large, small) * k,
            slope: -(x * square),
            curvature: (strained + 1.0) * square * inverse,
        }
    }
}

/// Second-order Taylor polynomial U + U′d + U″d²/2 and its derivatives.
#[inline(always)]
fn continued<T: Number>(at: &VolumetricResponse<T>, d: T) -> VolumetricResponse<T> {
    VolumetricResponse {
        energy: at.energy + d * (at.slope + d * 0.5 * at.curvature),
        slope: at.slope + d * at.curvature,
        curvature: at.curvature,
    }
}

/// k ln J and its derivatives, continued below [`NeoHookean::FLOOR`].
#[inline(always)]
pub(super) fn logarithmic<T: Number>(k: f64, j: T) -> VolumetricResponse<T> {
    let at = j.at_least(NeoHookean::FLOOR);
    let inverse = j.constant(1.0) / at;
    let (slope, curvature) = (inverse * k, -(inverse * inverse * k));
    continued(&VolumetricResponse { energy: ln(at) * k, slope, curvature }, j - at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laws() -> [EquationOfState; 3] {
        [(0.0, f64::INFINITY), (2.0, f64::INFINITY), (2.0, 5e6)].map(|(s, t)| EquationOfState::new(2.38e9, s, t))
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let step = 1e-6;
        for law in laws() {
            for j in [-0.3, 0.1, 0.3, 0.55, 0.62, 0.9, 0.9996, 1.2, 3.0] {
                let (a, b, at) = (law.volumetric(j - step), law.volumetric(j + step), law.volumetric(j));
                assert!(
                    ((b.energy - a.energy) / (2.0 * step) - at.slope).abs() < 1e-5 * at.slope.abs().max(1e6),
                    "{j}"
                );
                // In a void U″ is told as at its closing.
                let curvature = if at.slope == law.tension { at.curvature } else { (b.slope - a.slope) / (2.0 * step) };
                assert!((curvature - at.curvature).abs() < 1e-4 * at.curvature.abs().max(1e7), "{j}");
            }
        }
    }

    #[test]
    fn energy_and_pressure_are_continuous() {
        for law in laws() {
            let mut before = law.volumetric(-0.5);
            for i in 1..4000 {
                let now = law.volumetric(-0.5 + 1e-3 * f64::from(i));
                let slope = 0.5 * (before.slope + now.slope);
                // A jump would not fall with the step; these bounds are of first and second order in it.
                let stiffest = before.curvature.max(now.curvature).max(law.bulk_modulus());
                assert!((now.energy - before.energy - 1e-3 * slope).abs() <= 1e-6 * stiffest, "{i}");
                assert!((now.slope - before.slope).abs() <= 1.1e-3 * stiffest, "{i}");
                before = now;
            }
        }
    }

    #[test]
    fn the_shock_speed_is_that_of_the_hugoniot() {
        // Mass and momentum across a shock: 1 − J = u/U, p = ρ U u.
        let (density, sound, slope) = (1030.0, 1520.0, 2.0);
        let law = EquationOfState::new(density * sound * sound, slope, f64::INFINITY);
        for u in [1.0, 50.0, 300.0] {
            let speed = sound + slope * u;
            let pressure = -law.volumetric(1.0 - u / speed).slope;
            assert!((pressure / (density * speed * u) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn tension_stays_within_its_limit() {
        let law = EquationOfState::new(1e9, 2.0, 5e6);
        assert_eq!(law.volumetric(1.5).slope, 5e6);
        assert!(law.volumetric(1.004).slope < 5e6);
    }

    #[test]
    fn a_void_has_the_stiffness_at_which_it_closes() {
        let law = EquationOfState::new(1e9, 2.0, 5e6);
        let closing = law.volumetric(1.0 / (1.0 - 5e6 / 1e9)).curvature;
        assert!((closing / 1e9 - 0.995 * 0.995).abs() < 1e-12);
        assert_eq!([1.006, 1.5, 30.0].map(|j| law.volumetric(j).curvature), [closing; 3]);
    }
}
