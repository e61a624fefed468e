//! The table of a sensor in the gel. Field docs are the help an editor shows; units are SI.

use serde::{Deserialize, Serialize};

/// Most sensors of a scene: as many as there are blocks of value references.
pub const MOST_SENSORS: usize = 99;

/// A sensor that goes with the gel: pressure, displacement and velocity of what is at a point at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Sensor {
    /// Where its gel is at rest, m; in `axisymmetric` [radius, 0, z].
    pub position: [f64; 3],
}
