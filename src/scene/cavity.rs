//! Air in the cavity behind the projectile. The field docs are the descriptions that an editor shows; units are SI.

use serde::{Deserialize, Serialize};

/// Absolute pressure of the air around the gel, Pa: the standard atmosphere.
pub const AMBIENT_PRESSURE: f64 = 101_325.0;

/// Air in the cavity: the void that is connected with the entry, behind the projectile.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum CavitySpec {
    /// Air enters freely: the pressure is ambient everywhere and has no net load.
    #[default]
    Vented,
    /// No air enters: a constant pressure in the cavity, ambient pressure on the rest of the surface.
    Sealed {
        /// Absolute pressure in the cavity, Pa; 0 for a vacuum. Ambient pressure is 101325 Pa.
        pressure: f64,
    },
    /// Air flows in through the entry, as through a nozzle, and through the exit of a perforation.
    Inflow {
        /// Discharge coefficient of the openings, 0 to 1. The jet through a slit has 0.61 (Kirchhoff).
        #[serde(default = "jet")]
        discharge: f64,
    },
}

/// Contraction of the jet through a slit, π/(π + 2) (Kirchhoff 1869).
fn jet() -> f64 {
    0.61
}

impl CavitySpec {
    /// Returns true if air enters the cavity freely.
    #[must_use]
    pub fn is_vented(&self) -> bool {
        *self == Self::Vented
    }

    /// Gauge pressure in a sealed cavity, or in one without air into which it flows, Pa: negative below the ambient
    /// pressure.
    #[must_use]
    pub fn gauge_pressure(&self) -> Option<f64> {
        match self {
            Self::Vented => None,
            Self::Sealed { pressure } => Some(pressure - AMBIENT_PRESSURE),
            Self::Inflow { .. } => Some(-AMBIENT_PRESSURE),
        }
    }

    /// Returns the discharge coefficient of the openings through which air flows in.
    #[must_use]
    pub fn discharge(&self) -> Option<f64> {
        if let Self::Inflow { discharge } = self { Some(*discharge) } else { None }
    }

    /// Describes the air of a cavity that is not vented in a sentence.
    pub(super) fn describe(&self) -> Option<String> {
        let what = match self {
            Self::Vented => return None,
            Self::Sealed { pressure } => format!("{pressure:?} Pa in the sealed cavity behind the projectile"),
            Self::Inflow { discharge } => format!(
                "flows into the cavity behind the projectile through its entry, as through a nozzle of the discharge \
                 coefficient {discharge:?}"
            ),
        };
        Some(format!(
            "air: {what}, {AMBIENT_PRESSURE:?} Pa on the rest of the surface; the difference acts on the wall of the \
             cavity"
        ))
    }

    /// Names the effects of air that are not computed.
    pub(super) fn omitted(&self) -> &'static str {
        match self {
            Self::Vented => "air: none, its pressure is the same in the vented cavity and around the gel",
            Self::Sealed { .. } => "air flow: none, the pressure in the sealed cavity is constant",
            Self::Inflow { .. } => "air waves: none, the pressure is the same in the whole cavity",
        }
    }
}
