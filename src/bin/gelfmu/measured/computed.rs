//! Computed curves of a result folder, of the quantities that a laboratory measures.

use super::quantity::MeasuredQuantity;
use crate::failure::RunError;
use ballistic_gel::output::{CurveAbscissa, CurvePoint, MOST_RESULT_BYTES, read_limited_text};
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Columns of a table of results by name.
type ResultColumns = HashMap<String, Vec<f64>>;

/// Returns the computed curve of a quantity; empty if the run has none.
pub fn curve(
    folder: &Path,
    summary: &Value,
    quantity: MeasuredQuantity,
    by: CurveAbscissa,
) -> Result<Vec<CurvePoint>, RunError> {
    use CurveAbscissa::{Depth, Time};
    use MeasuredQuantity as Of;
    let columns = |file: &str, at: &str, value: &str| read_columns(&folder.join(file)).map(|all| pair(&all, at, value));
    let at = if by == Time { "time_s" } else { "depth_m" };
    let points = match (quantity, by) {
        (Of::Depth, Time) => columns("history.csv", at, "depth_m"),
        (Of::Yaw, Time) => columns("history.csv", at, "yaw_rad"),
        (Of::Velocity, Time) => read_columns(&folder.join("history.csv")).map(|all| speeds(&all)),
        (Of::Velocity, Depth) => columns("shot.csv", at, "velocity_m_per_s"),
        (Of::Force, _) => columns("shot.csv", at, "force_N"),
        (Of::Energy, _) => columns("shot.csv", at, "energy_J"),
        (Of::Yaw, Depth) => columns("shot.csv", at, "yaw_rad"),
        (Of::CavityDiameter, Time) => Ok(cavity_course(summary)),
        (Of::CavityDiameter, Depth) => read_columns(&folder.join("cavity.csv")).map(|all| widest_cavity(&all)),
        (Of::TrackDiameter, Depth) => columns("track.csv", at, "track_diameter_m"),
        (Of::EnergyPerCentimetre, Depth) => columns("track.csv", at, "energy_in_centimetre_J"),
        (Of::Time, _) | (Of::Depth, Depth) | (Of::TrackDiameter | Of::EnergyPerCentimetre, Time) => Ok(vec![]),
    };
    points.map(ascending)
}

/// Reads a table of results; without the file there are no columns.
fn read_columns(path: &Path) -> Result<ResultColumns, RunError> {
    let failed = |source: std::io::Error| RunError::File { verb: "read", path: path.to_path_buf(), source };
    if !path.exists() {
        return Ok(HashMap::new());
    }
    let text = read_limited_text(path, MOST_RESULT_BYTES).map_err(failed)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names = reader.headers().map_err(|error| failed(error.into()))?.clone();
    let mut columns: Vec<Vec<f64>> = vec![vec![]; names.len()];
    for record in reader.records() {
        let record = record.map_err(|error| failed(error.into()))?;
        for (cell, column) in record.iter().zip(&mut columns) {
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok(names.iter().map(str::to_owned).zip(columns).collect())
}

fn pair(columns: &ResultColumns, at: &str, value: &str) -> Vec<CurvePoint> {
    let column = |name: &str| columns.get(name).map(Vec::as_slice).unwrap_or_default();
    column(at).iter().zip(column(value)).map(|(at, value)| CurvePoint { at: *at, value: *value }).collect()
}

/// Returns the speed of the projectile relative to the block by time.
fn speeds(columns: &ResultColumns) -> Vec<CurvePoint> {
    let component = |of: &str, axis: &str| pair(columns, "time_s", &format!("{of}_{axis}_m_per_s"));
    let mut points: Vec<CurvePoint> =
        component("block_velocity", "x").into_iter().map(|x| CurvePoint { value: 0.0, ..x }).collect();
    for axis in ["x", "y", "z"] {
        let relative = component("velocity", axis).into_iter().zip(component("block_velocity", axis));
        for (point, (own, block)) in points.iter_mut().zip(relative) {
            point.value = point.value.hypot(own.value - block.value);
        }
    }
    points
}

/// Returns the greatest diameter of the cavity over the depth by time.
fn cavity_course(summary: &Value) -> Vec<CurvePoint> {
    let course = summary["cavity_course"].as_array().map(Vec::as_slice).unwrap_or_default();
    let point = |entry: &Value| Some(CurvePoint { at: entry["time"].as_f64()?, value: entry["diameter"].as_f64()? });
    course.iter().filter_map(point).collect()
}

/// Returns the widest diameter over the run by depth.
fn widest_cavity(columns: &ResultColumns) -> Vec<CurvePoint> {
    let mut widest = BTreeMap::<u64, CurvePoint>::new();
    // The bits of numbers of one sign are in the order of the numbers; depths are positive.
    for point in pair(columns, "depth_m", "diameter_m").into_iter().filter(|point| point.at >= 0.0) {
        let known = widest.entry(point.at.to_bits()).or_insert(point);
        known.value = known.value.max(point.value);
    }
    widest.into_values().collect()
}

/// Returns the points of a curve in ascending order, without unknown values.
fn ascending(mut points: Vec<CurvePoint>) -> Vec<CurvePoint> {
    points.retain(|point| point.at.is_finite() && point.value.is_finite());
    points.sort_by(|a, b| a.at.total_cmp(&b.at));
    points
}
