//! Row of a case: the figures of its run.

use super::case::ShotCase;
use super::measured::MeasuredFigure;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Yaw at the end of the neck.
const NECK_YAW: f64 = std::f64::consts::PI / 6.0;

/// Figures of a run, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseRow {
    /// Name of the measured shot.
    pub shot: String,
    /// Level.
    pub level: String,
    /// Yaw, degrees.
    pub yaw_deg: f64,
    /// Roll, degrees.
    pub roll_deg: f64,
    /// Depth of the nose at rest or at the end, m; the length of the block after a perforation.
    pub depth_m: f64,
    /// Speed at the end, or at the exit, m/s.
    pub last_speed_m_per_s: f64,
    /// True if the projectile left the block.
    pub perforated: bool,
    /// Depth at which the yaw passed 30°, m.
    pub neck_m: Option<f64>,
    /// Greatest diameter of the temporary cavity, m.
    pub cavity_m: Option<f64>,
    /// Depth of the greatest diameter, m.
    pub cavity_depth_m: Option<f64>,
    /// Greatest energy in a centimetre, J.
    pub energy_per_cm_j: Option<f64>,
    /// Wall time of the run on one thread, s.
    pub seconds: f64,
    /// Part of the energy that the method changed.
    pub energy_defect: f64,
    /// True if the run reached its end.
    pub completed: bool,
}

impl CaseRow {
    /// Row of the `summary.json` and the `shot.csv` of a run; `None` if a figure is missing.
    pub fn of(case: &ShotCase, summary: &Value, shot_table: &str) -> Option<Self> {
        let number = |key: &str| summary[key].as_f64();
        let velocity = if summary["exit_velocity"].is_null() { "final_velocity" } else { "exit_velocity" };
        let speed = summary[velocity].as_array()?.iter().filter_map(Value::as_f64).map(|v| v * v).sum::<f64>();
        let perforated = summary["perforated"].as_bool().unwrap_or(false);
        let energies = summary["energy_per_centimetre"].as_array();
        Some(Self {
            shot: case.measured.name.clone(),
            level: case.level.to_owned(),
            yaw_deg: case.yaw,
            roll_deg: case.roll,
            depth_m: number("rest_depth").or(number("final_depth"))?,
            last_speed_m_per_s: speed.sqrt(),
            perforated,
            neck_m: depth_of_yaw(shot_table, NECK_YAW),
            cavity_m: number("greatest_cavity_diameter"),
            cavity_depth_m: number("depth_of_greatest_cavity"),
            energy_per_cm_j: energies.and_then(|all| all.iter().filter_map(Value::as_f64).reduce(f64::max)),
            seconds: number("wall_seconds")?,
            energy_defect: number("energy_defect")?,
            completed: summary["completed"].as_bool()?,
        })
    }

    /// Computed value of the measured figure, m; `None` if the run did not get there.
    pub fn value(&self, figure: MeasuredFigure) -> Option<f64> {
        match figure {
            MeasuredFigure::Depth if self.completed => Some(self.depth_m),
            MeasuredFigure::Depth => None,
            MeasuredFigure::Neck => self.neck_m,
        }
    }
}

/// Depth at which the yaw of a `shot.csv` first passes an angle, m, linear between the rows.
fn depth_of_yaw(table: &str, angle: f64) -> Option<f64> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let column = |headers: &csv::StringRecord, name| headers.iter().position(|known| known == name);
    let headers = reader.headers().ok()?.clone();
    let (depth, yaw) = (column(&headers, "depth_m")?, column(&headers, "yaw_rad")?);
    let mut before: Option<[f64; 2]> = None;
    for record in reader.records() {
        let record = record.ok()?;
        let [Ok(depth), Ok(yaw)] = [depth, yaw].map(|at| record[at].parse::<f64>()) else { continue };
        let row = [depth, yaw];
        if row[1] >= angle {
            let [d0, y0] = before.unwrap_or(row);
            let part = if row[1] > y0 { (angle - y0) / (row[1] - y0) } else { 1.0 };
            return Some(d0 + part * (row[0] - d0));
        }
        before = Some(row);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::depth_of_yaw;

    #[test]
    fn the_neck_ends_where_the_yaw_passes_its_angle() {
        let table = "depth_m,time_s,yaw_rad\n0.0,0,0.1\n0.1,1,0.2\n,,\n0.2,2,0.6\n0.3,3,0.3\n";
        assert!((depth_of_yaw(table, 0.4).unwrap() - 0.15).abs() < 1e-15);
        assert_eq!(depth_of_yaw(table, 0.7), None);
        assert_eq!(depth_of_yaw("depth_m,time_s\n0.0,0\n", 0.1), None);
    }
}
