//! Tables of the material parameters of a gel.

use crate::constitutive::{Branch, Dashpot, OgdenTerm, PowerLaw};
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
    /// Two networks in parallel: elastic (with delayed damage), and viscous branches; pressure by an equation of state.
    TwoNetwork,
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

/// Branch of a two-network gel: a shear spring in series with a dashpot, which is given by either `time` or `power_law`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BranchSpec {
    /// Contribution to the instantaneous shear modulus, Pa.
    pub shear_modulus: f64,
    /// Relaxation time of a linear dashpot: at a held strain the stress of the branch falls to 1/e within it, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Power-law dashpot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_law: Option<PowerLawSpec>,
}

/// Power-law dashpot: it bears the equivalent stress `stress` (rate/`rate`)^`exponent`, without a yield stress; with a
/// `rate`, `stress` at most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct PowerLawSpec {
    /// Equivalent stress, Pa: at a rate of 1/s, or with `rate` the one at which the dashpot saturates.
    pub stress: f64,
    /// Rate from which on the dashpot bears no more, 1/s; without it the stress rises at all rates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Exponent of the rate, 0.01 to 1; with `rate` 0.01 to 10.
    pub exponent: f64,
}

impl PowerLawSpec {
    /// Dashpot with these parameters.
    ///
    /// # Panics
    /// If a value is outside its domain; those of a scene that was read are not.
    #[must_use]
    pub fn law(self) -> PowerLaw {
        let Self { stress, rate, exponent } = self;
        rate.map_or_else(|| PowerLaw::new(stress, exponent), |rate| PowerLaw::saturating(stress, rate, exponent))
    }
}

impl BranchSpec {
    /// Branch with these parameters.
    ///
    /// # Panics
    /// If a value is outside its domain; those of a scene that was read are not.
    #[must_use]
    pub fn branch(self) -> Branch {
        let dashpot = match (self.time, self.power_law) {
            (_, Some(law)) => Dashpot::PowerLaw(law.law()),
            (time, None) => Dashpot::linear(time.expect("a checked branch has a dashpot")),
        };
        Branch::new(self.shear_modulus, dashpot)
    }
}

/// Damage of the elastic network of a two-network gel. It grows at the rate (stretch/critical stretch - 1)/delay where
/// the greatest stretch exceeds the critical one; fully damaged, the network bears nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct DamageSpec {
    /// Greatest principal stretch that does no damage, above 1.
    pub critical_stretch: f64,
    /// Time in which a network at twice the critical stretch breaks, s.
    pub delay: f64,
}

/// Equation of state of a two-network gel: p = K (1/J - 1), unless a shock slope is given.
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

/// Bulk viscosity of a two-network gel.
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
