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
}

impl CavitySpec {
    /// Returns true if air enters the cavity freely.
    #[must_use]
    pub fn is_vented(&self) -> bool {
        *self == Self::Vented
    }

    /// Gauge pressure in a sealed cavity, Pa: negative below the ambient pressure.
    #[must_use]
    pub fn gauge_pressure(&self) -> Option<f64> {
        match self {
            Self::Vented => None,
            Self::Sealed { pressure } => Some(pressure - AMBIENT_PRESSURE),
        }
    }

    /// Describes the air of a sealed cavity in a sentence.
    pub(super) fn describe(&self) -> Option<String> {
        let Self::Sealed { pressure } = self else { return None };
        Some(format!(
            "air: {pressure:?} Pa in the sealed cavity behind the projectile, {AMBIENT_PRESSURE:?} Pa on the rest of \
             the surface; the difference acts on the wall of the cavity"
        ))
    }

    /// Names the effects of air that are not computed.
    pub(super) fn omitted(&self) -> &'static str {
        match self {
            Self::Vented => "air: none, its pressure is the same in the vented cavity and around the gel",
            Self::Sealed { .. } => "air flow: none, the pressure in the sealed cavity is constant",
        }
    }
}
