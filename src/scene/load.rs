//! Tables of a pressure load on the surface of the gel. The field docs are the descriptions that an editor shows;
//! units are SI.

use serde::{Deserialize, Serialize};

/// Greatest number of loads of a scene: each takes one bit of a facet's load marker.
pub const MOST_LOADS: usize = 8;

/// Follower pressure on a part of the surface of the gel, selected by its position at rest. The pressure stays normal
/// to the surface and acts on its current area.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct LoadSpec {
    /// Face of the gel; the whole surface if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<GelFace>,
    /// Box that contains the loaded facets at rest; no limit if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<BoxRegion>,
    /// Depth below the entry surface of the block over which the pressure rises from 0 to its full value, by current
    /// position, m; 0 is full pressure everywhere. A cavity wall then carries the pressure, the surface around the
    /// entry hole does not.
    #[serde(default)]
    pub depth: f64,
    /// Pressure, Pa; positive pushes the surface inwards, negative pulls it outwards.
    pub pressure: f64,
    /// Rise time of the pressure, linear from 0 at the start, s; 0 is a step.
    #[serde(default)]
    pub ramp: f64,
    /// Time history instead of a ramp: rows [time, fraction] with ascending times, s, and the fraction of the
    /// pressure. Linear in between, constant before and after.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub table: Vec<[f64; 2]>,
}

/// Face of the gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum GelFace {
    /// Face of least x of a block.
    XMin,
    /// Face of greatest x of a block.
    XMax,
    /// Face of least y of a spatial block.
    YMin,
    /// Face of greatest y of a spatial block.
    YMax,
    /// Back face (bottom) of a block or cylinder.
    ZMin,
    /// Entry surface of a block or cylinder, flat face of a shell.
    ZMax,
    /// Lateral surface of a cylinder, outer surface of a shell.
    Side,
    /// Wall of a bore, inner surface of a shell.
    Inner,
}

/// Axis-aligned box in the rest configuration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BoxRegion {
    /// Lower corner, m.
    pub low: [f64; 3],
    /// Upper corner, m.
    pub high: [f64; 3],
}

impl LoadSpec {
    /// Time history of the pressure: pairs of a time, s, ascending, and a pressure, Pa. Linear in between, constant
    /// before and after.
    #[must_use]
    pub fn history(&self) -> Vec<(f64, f64)> {
        match (self.table.as_slice(), self.ramp) {
            ([], 0.0) => vec![(0.0, self.pressure)],
            ([], ramp) => vec![(0.0, 0.0), (ramp, self.pressure)],
            (table, _) => table.iter().map(|[time, part]| (*time, part * self.pressure)).collect(),
        }
    }
}

impl GelFace {
    /// Name of the face in a scene file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::XMin => "x_min",
            Self::XMax => "x_max",
            Self::YMin => "y_min",
            Self::YMax => "y_max",
            Self::ZMin => "z_min",
            Self::ZMax => "z_max",
            Self::Side => "side",
            Self::Inner => "inner",
        }
    }
}
