//! Coefficients of the reduced model for the classes of bodies in one gel, with the range in which they were identified.

use super::{PenetrationLaw, RingLaw};
use serde::{Deserialize, Serialize};

/// Class of bodies that share coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum BodyClass {
    /// Spheres.
    Sphere,
    /// Bodies with a hemispherical nose and a length of half a calibre and more, such as recovered bullets.
    RoundNose,
}

/// Range of shots from which coefficients were identified, least and greatest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct IdentifiedRange {
    /// Calibre in m.
    pub diameter: [f64; 2],
    /// Sectional density m/A in kg/m².
    pub sectional_density: [f64; 2],
    /// Speed at the gel in m/s.
    pub speed: [f64; 2],
}

/// Coefficients of a class of bodies, identified from runs of the full model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct IdentifiedClass {
    /// Bodies.
    pub body: BodyClass,
    /// Number of runs from which the coefficients were identified.
    pub runs: u32,
    /// Level of these runs, which the errors are relative to.
    pub level: String,
    /// Relative error of the greatest depth that nine tenths of the runs kept out do not exceed.
    pub depth_error: f64,
    /// Relative error of the exit speed that nine tenths of the runs kept out do not exceed.
    pub exit_error: f64,
    /// Relative error of the greatest diameter of the cavity that nine tenths of the runs kept out do not exceed.
    pub cavity_error: f64,
    /// Range of these runs.
    pub range: IdentifiedRange,
    /// Penetration law.
    pub penetration: PenetrationLaw,
    /// Rings of the cavity.
    pub rings: RingLaw,
}

/// Coefficients of the reduced model in one gel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ReducedCoefficients {
    /// Classes of bodies.
    pub class: Vec<IdentifiedClass>,
}

impl ReducedCoefficients {
    /// Returns the coefficients of a class of bodies.
    #[must_use]
    pub fn of(&self, body: BodyClass) -> Option<&IdentifiedClass> {
        self.class.iter().find(|class| class.body == body)
    }
}
