//! Tables of a shot, read back: the track of the projectile, the cavity, the permanent track, the cracks by depth, and
//! the layers.

use super::SavedRunError;
use super::table::CsvTable;
use crate::output::penetration::{CavityCoursePoint, CrackSlice, LAYERS, LayerPassage};
use crate::output::summary::RunSummary;
use std::collections::BTreeMap;
use std::path::Path;

/// Row of `shot.csv`: the projectile at a depth; a value that the run does not have is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct ShotPoint {
    /// Depth of the foremost point, m.
    pub(in crate::output) depth: f64,
    /// Time of the first arrival at the depth, s.
    pub(in crate::output) time: f64,
    /// Speed along −z, m/s.
    pub(in crate::output) velocity: f64,
    /// Mean retarding force around the depth, N.
    pub(in crate::output) force: f64,
    /// Energy given to the gel down to the depth, J.
    pub(in crate::output) energy: f64,
    /// Yaw, rad.
    pub(in crate::output) yaw: f64,
    /// Mean force across the line of fire around the depth, N.
    pub(in crate::output) side_force: f64,
    /// Opening of an expanding projectile; 0 for any other.
    pub(in crate::output) expansion: f64,
}

/// Width along the depth: depth, m, and radius or diameter, m.
pub(in crate::output) type DepthCurve = Vec<(f64, f64)>;

/// Radii of the cavity along the depth.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::output) struct CavityWidths {
    /// Greatest radius of the run at each depth.
    pub(in crate::output) temporary: DepthCurve,
    /// Radii at the time of the greatest diameter.
    pub(in crate::output) widest: DepthCurve,
    /// Radii at the end.
    pub(in crate::output) last: DepthCurve,
}

/// Tables of a shot.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::output) struct SavedShot {
    /// Projectile at each depth of `shot.csv`.
    pub(in crate::output) points: Vec<ShotPoint>,
    /// Cavity of `cavity.csv`.
    pub(in crate::output) cavity: CavityWidths,
    /// Greatest diameter of the cavity by time.
    pub(in crate::output) course: Vec<CavityCoursePoint>,
    /// Diameters of the permanent track of `track.csv`; empty without damage.
    pub(in crate::output) track: DepthCurve,
    /// Energy given to the gel in each centimetre, J.
    pub(in crate::output) energies: Vec<f64>,
    /// Estimated cracks of `cracks.csv`.
    pub(in crate::output) cracks: Vec<CrackSlice>,
    /// Layers of `layers.csv`, the gel below them included; empty without layers.
    pub(in crate::output) layers: Vec<LayerPassage>,
}

impl SavedShot {
    /// Reads the tables; `None` for a run without them.
    pub(super) fn read(folder: &Path, summary: &RunSummary) -> Result<Option<Self>, SavedRunError> {
        if !folder.join("shot.csv").is_file() {
            return Ok(None);
        }
        let shot = CsvTable::read(&folder.join("shot.csv"))?;
        let point = |row: &Vec<f64>| {
            let value = |name: &str| shot.value(row, name).unwrap_or(f64::NAN);
            ShotPoint {
                depth: value("depth_m"),
                time: value("time_s"),
                velocity: value("velocity_m_per_s"),
                force: value("force_N"),
                energy: value("energy_J"),
                yaw: value("yaw_rad"),
                side_force: value("side_force_N"),
                expansion: value("expansion"),
            }
        };
        Ok(Some(Self {
            points: shot.rows().iter().map(point).collect(),
            cavity: cavity_widths(&CsvTable::read(&folder.join("cavity.csv"))?, summary),
            course: summary.wound.cavity_course.clone().unwrap_or_default(),
            track: track_curve(&CsvTable::read(&folder.join("track.csv"))?),
            energies: summary.energy_per_centimetre.clone().unwrap_or_default(),
            cracks: crack_slices(&folder.join("cracks.csv"))?,
            layers: layer_passages(folder)?,
        }))
    }

    /// Returns the greatest depth of the track, m.
    pub(in crate::output) fn greatest_depth(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.depth)
    }

    /// Returns the greatest diameter of the permanent track, m.
    pub(in crate::output) fn greatest_track_diameter(&self) -> f64 {
        self.track.iter().map(|(_, diameter)| *diameter).fold(0.0, f64::max)
    }
}

/// Returns the widths of the cavity: envelope of all profiles, profile of the greatest diameter, and last profile.
fn cavity_widths(table: &CsvTable, summary: &RunSummary) -> CavityWidths {
    let cells =
        |row: &Vec<f64>| ["time_s", "depth_m", "radius_m"].map(|name| table.value(row, name).unwrap_or(f64::NAN));
    let points: Vec<[f64; 3]> = table.rows().iter().map(cells).collect();
    let at = |time: f64| -> DepthCurve {
        points.iter().filter(|point| point[0] == time).map(|[_, depth, radius]| (*depth, *radius)).collect()
    };
    // Depths are positive, so their bits are in the order of the depths.
    let mut envelope = BTreeMap::<u64, f64>::new();
    for [_, depth, radius] in &points {
        let widest = envelope.entry(depth.to_bits()).or_insert(*radius);
        *widest = widest.max(*radius);
    }
    CavityWidths {
        temporary: envelope.into_iter().map(|(depth, radius)| (f64::from_bits(depth), radius)).collect(),
        widest: summary.wound.time_of_greatest_cavity.map_or(vec![], at),
        last: at(summary.end_time),
    }
}

fn track_curve(table: &CsvTable) -> DepthCurve {
    let cells = |row: &Vec<f64>| Some((table.value(row, "depth_m")?, table.value(row, "track_diameter_m")?));
    let curve: DepthCurve = table.rows().iter().filter_map(cells).collect();
    if curve.iter().any(|(_, diameter)| *diameter > 0.0) { curve } else { vec![] }
}

/// Reads the cracks; none in a folder that was written before this table was.
fn crack_slices(path: &Path) -> Result<Vec<CrackSlice>, SavedRunError> {
    if !path.is_file() {
        return Ok(vec![]);
    }
    let table = CsvTable::read(path)?;
    let slice = |row: &Vec<f64>| {
        let value = |name: &str| table.value(row, name).unwrap_or(f64::NAN);
        CrackSlice {
            depth_from: value("depth_from_m"),
            depth_to: value("depth_to_m"),
            cavity_diameter: value("cavity_diameter_m"),
            tear_diameter: value("tear_diameter_m"),
            energy: value("energy_J"),
            crack_length: value("crack_length_m"),
        }
    };
    Ok(table.rows().iter().map(slice).collect())
}

/// Reads the layers of a run in the order of the scene; none in the folder of a run without layers.
pub(in crate::output) fn layer_passages(folder: &Path) -> Result<Vec<LayerPassage>, SavedRunError> {
    let path = folder.join(LAYERS);
    if !path.is_file() {
        return Ok(vec![]);
    }
    let table = CsvTable::read(&path)?;
    let passage = |row: &Vec<f64>| {
        let value = |name: &str| table.value(row, name).unwrap_or(f64::NAN);
        LayerPassage {
            depth_from: value("depth_from_m"),
            depth_to: value("depth_to_m"),
            density: value("density_kg_per_m3"),
            entry_speed: value("entry_speed_m_per_s"),
            energy: value("energy_J"),
            energy_fraction: value("energy_fraction"),
        }
    };
    Ok(table.rows().iter().map(passage).collect())
}
