//! Table of a sensor in the gel. The field docs are the descriptions that an editor shows; units are SI.

use serde::{Deserialize, Serialize};

/// Greatest number of sensors of a scene: the number of blocks of value references.
pub const MOST_SENSORS: usize = 99;

/// Sensor at a material point of the gel: pressure, displacement and velocity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct SensorSpec {
    /// Position of the material point at rest, m; in `axisymmetric` [radius, 0, z].
    pub position: [f64; 3],
}
