//! Row of a case: the figures of its run.

use super::case::ShotCase;
use super::measured::MeasuredFigure;
use serde::{Deserialize, Serialize};
use serde_json::Value;

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
    /// Row of the `summary.json` of a run; `None` if a figure is missing.
    pub fn of(case: &ShotCase, summary: &Value) -> Option<Self> {
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
            neck_m: number("neck_length"),
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

#[cfg(test)]
mod tests {
    use super::super::measured::measured_shots;
    use super::*;
    use ballistic_gel::scene::{self, CAVITY_MARGIN, cavity_estimate};

    #[test]
    fn the_estimate_of_a_cavity_meets_those_that_were_computed() {
        let rows = csv::Reader::from_reader(include_str!("../../../../docs/shots.csv").as_bytes()).into_deserialize();
        let rows: Vec<CaseRow> = rows.collect::<Result<_, _>>().unwrap();
        let mut n_at_rest = 0;
        for row in &rows {
            let measured = measured_shots().into_iter().find(|shot| shot.name == row.shot).unwrap();
            // The estimate does not depend on the level; it knows the end of the runs to a neck.
            let (ends_early, is_slow) = (measured.measure == MeasuredFigure::Neck, measured.name == "bb-fbi");
            let case = ShotCase { measured, yaw: row.yaw_deg, roll: row.roll_deg, level: "draft" };
            let scene = scene::read(&case.scene_text().unwrap()).unwrap();
            let ratio = cavity_estimate(&scene, 0).unwrap() / row.cavity_m.unwrap();
            n_at_rest += usize::from(!ends_early && !is_slow);
            let band = if ends_early { 1.0..2.5 } else { 1.0 - CAVITY_MARGIN..1.0 + CAVITY_MARGIN };
            assert!(is_slow && ratio < 1.7 || band.contains(&ratio), "{} {}: {ratio}", row.shot, row.level);
        }
        assert_eq!((rows.len(), n_at_rest), (47, 26));
    }
}
