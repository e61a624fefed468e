//! Cases of a measured shot: level, yaw and roll.

use super::measured::{MeasuredFigure, ValidationShot};
use crate::failure::CommandError;
use crate::new::{Shot, scene_text};
use ballistic_gel::scene::{self, Override};

/// Case: one run.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotCase {
    /// Measured shot.
    pub measured: ValidationShot,
    /// Yaw, degrees.
    pub yaw: f64,
    /// Roll of the plane of the yaw, degrees.
    pub roll: f64,
    /// Level.
    pub level: &'static str,
}

/// Yaws and rolls of the scatter of a service bullet, degrees.
const SCATTER: [(f64, f64); 4] = [(1.0, 0.0), (2.0, 0.0), (4.0, 0.0), (2.0, 45.0)];

/// Returns the level of the run of a shot that counts: `coarse` for a bullet that tumbles, in some ten minutes in space, and
/// `standard` about an axis, where `coarse` stops a recovered shape a tenth too early.
pub fn counted_level(measured: &ValidationShot) -> &'static str {
    if measured.is_of_service_bullet() { "coarse" } else { "standard" }
}

/// Returns the cases of a shot: its usual yaw at the level that counts, and of a bullet that yaws the scatter at `draft`.
pub fn cases_of(measured: &ValidationShot) -> Vec<ShotCase> {
    let case = |yaw: f64, roll: f64, level| ShotCase { measured: measured.clone(), yaw, roll, level };
    let usual = case(measured.yaw, 0.0, counted_level(measured));
    if !measured.is_of_service_bullet() {
        return vec![usual];
    }
    SCATTER.iter().map(|(yaw, roll)| case(*yaw, *roll, "draft")).chain([usual]).collect()
}

impl ShotCase {
    /// Shot of the case.
    pub fn shot(&self) -> Shot {
        self.measured.shot(self.yaw, self.roll)
    }

    /// Scene of the case at its level.
    pub fn scene_text(&self) -> Result<String, CommandError> {
        let level = format!("scene.fidelity={}", self.level).parse().expect("a key and a value");
        let overrides: Vec<Override> = [Some(level), self.end_of_neck()].into_iter().flatten().collect();
        let resolved = scene::resolve(&scene_text(&self.shot())?, &overrides);
        resolved.map_err(|error| CommandError::BadInput(format!("{}: {error}", self.label())))
    }

    /// End of the run of a shot whose neck was measured: twice the time to its end at the speed of the impact.
    fn end_of_neck(&self) -> Option<Override> {
        let ValidationShot { measure, high, speed, .. } = self.measured;
        let end = format!("scene.end_time={:?}", 2.0 * high / speed);
        (measure == MeasuredFigure::Neck).then(|| end.parse().expect("a key and a value"))
    }

    /// Label for the progress.
    pub fn label(&self) -> String {
        let roll = if self.roll == 0.0 { String::new() } else { format!(" roll {}°", self.roll) };
        format!("{} {} yaw {}°{roll}", self.measured.name, self.level, self.yaw)
    }
}
