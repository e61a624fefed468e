//! The tables of what a gel is made of.

use super::Gel;
use crate::constitutive::{Confinement, Strength, Term};
use serde::{Deserialize, Serialize};

/// Material model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum MaterialModel {
    /// Compressible neo-Hookean with a C2 continuation below J = 0.2.
    NeoHookean,
    /// Mooney-Rivlin: two constants.
    MooneyRivlin,
    /// Ogden: one to three powers of the stretches.
    Ogden,
    /// Neo-Hookean in shear up to a strength that depends on the rate, pressure by an equation of state.
    Flowing,
    /// Neo-Hookean in the long run, with branches whose stress fades.
    Viscoelastic,
}

/// Constants of a Mooney-Rivlin gel: the shear modulus at rest is 2 (c1 + c2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ConstantsSpec {
    /// C1, of |F|^2, Pa.
    pub c1: f64,
    /// C2, of |cof F|^2, Pa; with 0 the gel is neo-Hookean.
    pub c2: f64,
}

/// A term modulus/exponent (l1^exponent + l2^exponent + l3^exponent - 3) of an Ogden gel: the shear modulus at rest is half the sum
/// of modulus times exponent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct TermSpec {
    /// mu, Pa, of the sign of the exponent.
    pub modulus: f64,
    /// alpha, of a magnitude of 0.1 to 30.
    pub exponent: f64,
}

/// A Maxwell branch of a viscoelastic gel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BranchSpec {
    /// What it adds to the shear modulus of a fast strain, Pa.
    pub shear_modulus: f64,
    /// Time in which its stress falls to 1/e at a held strain, s.
    pub time: f64,
}

/// Strength of a gel that flows: Y = Y0 times the rate of plastic strain by that of reference to a power, at least Y0 and at most
/// the cap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct StrengthSpec {
    /// Y0, equivalent stress at the rate of reference and below, Pa.
    pub yield_stress: f64,
    /// Rate up to which it bears Y0, 1/s: 1 if absent.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub reference_rate: f64,
    /// Power of the rate, 0 to 1.
    #[serde(default)]
    pub rate_exponent: f64,
    /// Most that it bears at any rate without pressure, Pa.
    pub cap: f64,
    /// How much more it bears under pressure: nothing if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confined: Option<ConfinedSpec>,
}

/// How much more a gel bears under pressure: `factor` times as much at `pressure` and above, in proportion below, of the pressure of
/// the last `time`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ConfinedSpec {
    /// Pressure from which on it bears most, Pa.
    pub pressure: f64,
    /// How many times as much, 1 to 1000.
    pub factor: f64,
    /// Time after which it feels a pressure, s: 0 if absent.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub time: f64,
}

impl StrengthSpec {
    /// The law that it tells.
    ///
    /// # Panics
    /// Where the values are none that a scene is let through with.
    #[must_use]
    pub fn law(self) -> Strength {
        let strength = Strength::new(self.yield_stress, self.rate_exponent, self.cap).from_rate(self.reference_rate);
        self.confined.map_or(strength, |ConfinedSpec { pressure, factor, time }| {
            strength.confined(Confinement { pressure, factor, time })
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

/// How gel that has flowed softens: of its shear modulus and its strength the part r + (1 - r)/(1 + (plastic strain/strain)^2)
/// is left.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SofteningSpec {
    /// Plastic strain at which half of what is lost in the end is lost.
    pub strain: f64,
    /// r, what is left in the end: above 0, to 1.
    pub residual: f64,
    /// Time in which it is lost to 1/e, s: at once if absent.
    #[serde(default)]
    pub time: f64,
}

/// How the pressure of a gel that flows follows its volume: p = K (1/J - 1), unless a shock speed is given.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct VolumeSpec {
    /// s of the shock speed c0 + s u; 0 for none.
    pub hugoniot_slope: f64,
    /// Tension that it bears before voids open, Pa; any if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tension_limit: Option<f64>,
}

/// Bulk viscosity of a gel that flows.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ViscositySpec {
    /// Part of it that is linear in the rate.
    pub linear: f64,
    /// Part of it that is quadratic in the rate, in compression.
    pub quadratic: f64,
}

impl From<&TermSpec> for Term {
    fn from(term: &TermSpec) -> Self {
        Self { modulus: term.modulus, exponent: term.exponent }
    }
}

impl Gel {
    /// The terms of an Ogden gel.
    #[must_use]
    pub fn ogden_terms(&self) -> Vec<Term> {
        self.terms.iter().map(Term::from).collect()
    }
}
