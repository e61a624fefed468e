#![allow(clippy::inline_always, reason = "only what is inlined is compiled for the vector unit of its caller")]

use crate::math::{Number, ln};

/// Volumetric energy density U and its derivatives by J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VolumetricResponse<T = f64> {
    /// U, J/m³.
    pub energy: T,
    /// U′, Pa.
    pub slope: T,
    /// U″, Pa; in a void, where U is straight, that at which the void closes.
    pub curvature: T,
}

/// Volumetric energy of a material, for one element or for eight in vector lanes.
pub trait VolumetricEnergy {
    /// Evaluates U of an element without a patch.
    #[must_use]
    fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T>;
    /// Evaluates the element part of U, at the J of the element, in an F-bar patch.
    #[must_use]
    fn own<T: Number>(&self, j: T) -> VolumetricResponse<T>;
    /// Evaluates the patch part of U, at the volume ratio J̄ of an F-bar patch.
    #[must_use]
    fn shared<T: Number>(&self, mean: T) -> VolumetricResponse<T>;
}

/// Logarithmic volumetric energy U(J) = −m ln J + Λ/2 (ln J)².
///
/// Below [`Self::FLOOR`] U continues as its second-order Taylor polynomial. m cancels the rest stress of ψ_s,
/// ∂ψ_s/∂F = m 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogarithmicEnergy {
    /// m, Pa.
    pub rest: f64,
    /// Λ, Pa.
    pub lambda: f64,
}

impl LogarithmicEnergy {
    /// Volume ratio J₀ below which the continuation begins.
    ///
    /// 0.2 leaves every state of a gel that a mesh can resolve untouched. 0.4 would soften real compression; 0.1
    /// reduces the stable step at J₀ to a sixteenth (method 6.1).
    pub const FLOOR: f64 = 0.2;
}

impl VolumetricEnergy for LogarithmicEnergy {
    #[inline(always)]
    fn volumetric<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        continued(self.rest, self.lambda, j)
    }

    /// Element part, −m ln J.
    #[inline(always)]
    fn own<T: Number>(&self, j: T) -> VolumetricResponse<T> {
        continued(self.rest, 0.0, j)
    }

    /// Patch part, Λ/2 (ln J̄)².
    #[inline(always)]
    fn shared<T: Number>(&self, mean: T) -> VolumetricResponse<T> {
        continued(0.0, self.lambda, mean)
    }
}

/// Logarithmic energy −m ln J + Λ/2 (ln J)², continued below J₀; branch-free, for vector units.
#[inline(always)]
fn continued<T: Number>(rest: f64, lambda: f64, j: T) -> VolumetricResponse<T> {
    let floor = LogarithmicEnergy::FLOOR;
    let VolumetricResponse { energy, slope, curvature } = logarithmic(rest, lambda, j.at_least(floor));
    let d = (j - floor).at_most(0.0);
    VolumetricResponse { energy: energy + d * (slope + d * 0.5 * curvature), slope: slope + d * curvature, curvature }
}

/// Logarithmic energy −m ln J + Λ/2 (ln J)² and its derivatives.
#[inline(always)]
fn logarithmic<T: Number>(rest: f64, lambda: f64, j: T) -> VolumetricResponse<T> {
    let (log, inverse) = (ln(j), j.constant(1.0) / j);
    VolumetricResponse {
        energy: log * (log * (0.5 * lambda) - rest),
        slope: (log * lambda - rest) * inverse,
        curvature: (log * -lambda + (lambda + rest)) * (inverse * inverse),
    }
}
