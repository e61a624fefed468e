//! Tables of the material parameters of a gel.

use crate::constitutive::{OgdenTerm, PressureHardening, YieldLaw};
use serde::{Deserialize, Serialize};

/// Constitutive model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum MaterialModel {
    /// Compressible neo-Hookean with a C2 continuation below J = 0.2.
    NeoHookean,
    /// Compressible Mooney-Rivlin: two constants.
    MooneyRivlin,
    /// Compressible Ogden: one to three powers of the principal stretches.
    Ogden,
    /// Viscoplastic: neo-Hookean in shear up to a rate-dependent yield stress, pressure by an equation of state.
    Flowing,
    /// Viscoelastic: neo-Hookean in the long run, with Maxwell branches whose stress relaxes.
    Viscoelastic,
}

/// Constants of a Mooney-Rivlin gel: the shear modulus at rest is 2 (c1 + c2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ConstantsSpec {
    /// Constant C1 of |F|^2, Pa.
    pub c1: f64,
    /// Constant C2 of |cof F|^2, Pa; with 0 the gel is neo-Hookean.
    pub c2: f64,
}

/// Term modulus/exponent (l1^exponent + l2^exponent + l3^exponent - 3) of an Ogden gel. The shear modulus at rest is
/// half the sum of modulus times exponent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct TermSpec {
    /// Modulus mu, Pa, with the sign of the exponent.
    pub modulus: f64,
    /// Exponent alpha, of a magnitude of 0.1 to 30.
    pub exponent: f64,
}

/// Maxwell branch of a viscoelastic gel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BranchSpec {
    /// Contribution to the instantaneous shear modulus, Pa.
    pub shear_modulus: f64,
    /// Relaxation time: at a held strain the stress of the branch falls to 1/e within it, s.
    pub time: f64,
}

/// Yield law of a viscoplastic gel: Y = Y0 (plastic strain rate / reference rate)^exponent, at least Y0 and at most
/// the cap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct StrengthSpec {
    /// Yield stress Y0 at the reference rate and below, as an equivalent stress, Pa.
    pub yield_stress: f64,
    /// Reference rate of plastic strain, up to which the yield stress is Y0, 1/s; 1 if absent.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub reference_rate: f64,
    /// Exponent of the plastic strain rate, 0 to 1.
    #[serde(default)]
    pub rate_exponent: f64,
    /// Greatest yield stress at any rate without pressure, Pa.
    pub cap: f64,
    /// Increase of the yield stress with pressure; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confined: Option<ConfinedSpec>,
}

/// Increase of the yield stress with pressure: `factor` times as much at `pressure` and above, in proportion below.
/// The pressure is lagged by `time`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ConfinedSpec {
    /// Pressure at and above which the yield stress is greatest, Pa.
    pub pressure: f64,
    /// Ratio of the greatest yield stress to that without pressure, 1 to 1000.
    pub factor: f64,
    /// Time lag of the pressure that enters the yield stress, s; 0 if absent.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub time: f64,
}

impl StrengthSpec {
    /// Yield law with these parameters.
    ///
    /// # Panics
    /// If a value is outside its domain; those of a scene that was read are not.
    #[must_use]
    pub fn law(self) -> YieldLaw {
        let strength =
            YieldLaw::new(self.yield_stress, self.rate_exponent, self.cap).with_reference_rate(self.reference_rate);
        self.confined.map_or(strength, |ConfinedSpec { pressure, factor, time }| {
            strength.with_confinement(PressureHardening { pressure, factor, time })
        })
    }
}

fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_one(number: &f64) -> bool {
    *number == 1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// Softening of a viscoplastic gel. Shear modulus and yield stress are multiplied by r + (1 - r)/(1 + (plastic
/// strain/strain)^2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SofteningSpec {
    /// Plastic strain at which half of the final loss has occurred.
    pub strain: f64,
    /// Residual fraction r of stiffness and strength: above 0, to 1.
    pub residual: f64,
    /// Relaxation time of the loss (to 1/e), s; immediate if absent.
    #[serde(default)]
    pub time: f64,
}

/// Equation of state of a viscoplastic gel: p = K (1/J - 1), unless a shock slope is given.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct VolumeSpec {
    /// Slope s of the Hugoniot line, shock speed = c0 + s u; 0 for none.
    pub hugoniot_slope: f64,
    /// Tension at which voids open, Pa; unlimited if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_limit: Option<f64>,
}

/// Bulk viscosity of a viscoplastic gel.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ViscositySpec {
    /// Coefficient linear in the rate of volume change.
    pub linear: f64,
    /// Coefficient quadratic in the rate of volume change, in compression.
    pub quadratic: f64,
}

impl From<&TermSpec> for OgdenTerm {
    fn from(term: &TermSpec) -> Self {
        Self { modulus: term.modulus, exponent: term.exponent }
    }
}
