//! The tables of a pressure on the surface of the gel. Field docs are the help an editor shows; units are SI.

use serde::{Deserialize, Serialize};

/// Loads of a scene at most: one bit each of the mark of a facet.
pub const MOST_LOADS: usize = 8;

/// A pressure on a part of the surface of the gel, chosen by where that is at rest. It follows the surface: always normal to
/// it, on the area that it has now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Load {
    /// The face of the gel; all of its surface if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<Face>,
    /// Only what is inside this box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Region>,
    /// Depth below z = 0 over which the pressure rises from nothing to all of it, m, where the surface is now; 0 is all of it
    /// everywhere. Walls of a cavity bear it then, the surface around the hole does not.
    #[serde(default)]
    pub depth: f64,
    /// Pressure, Pa; positive pushes the surface inwards, negative draws it outwards.
    pub pressure: f64,
    /// Time in which the pressure rises evenly from 0 at the start, s; 0 is at once.
    #[serde(default)]
    pub ramp: f64,
    /// Instead of a ramp: times, s, ascending, and the part of the pressure that acts then, as [time, part]; straight in between,
    /// constant before and after.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub table: Vec<[f64; 2]>,
}

/// A face of the gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub enum Face {
    /// The face of least x of a block.
    XMin,
    /// The face of greatest x of a block.
    XMax,
    /// The face of least y of a spatial block.
    YMin,
    /// The face of greatest y of a spatial block.
    YMax,
    /// The bottom of a block or cylinder.
    ZMin,
    /// The entry surface of a block or cylinder, the flat face of a shell.
    ZMax,
    /// The mantle of a cylinder, the outer surface of a shell.
    Side,
    /// The wall of a bore, the inner surface of a shell.
    Inner,
}

/// A box along the axes, at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Region {
    /// Its least coordinates, m.
    pub low: [f64; 3],
    /// Its greatest coordinates, m.
    pub high: [f64; 3],
}

impl Load {
    /// Times, s, ascending, and the pressures then, Pa; straight in between, constant before and after.
    #[must_use]
    pub fn history(&self) -> Vec<(f64, f64)> {
        match (self.table.as_slice(), self.ramp) {
            ([], 0.0) => vec![(0.0, self.pressure)],
            ([], ramp) => vec![(0.0, 0.0), (ramp, self.pressure)],
            (table, _) => table.iter().map(|[time, part]| (*time, part * self.pressure)).collect(),
        }
    }
}

impl Face {
    /// Its name in a scene.
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
