//! Simulation of one shot until its projectile rests in the gel.

use crate::failure::CommandError;
use crate::job;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, RestDetector, Simulation};
use std::ops::ControlFlow;

/// Greatest end time of a run to rest, in end times of the scene: a gel springs back long after the greatest depth.
pub const END_TIME_FACTOR: f64 = 4.0;
/// Measurements of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct ShotRun {
    /// State of the projectile at the end.
    pub end: ShotEnd,
    /// Time of the end of the run, s.
    pub time: f64,
    /// Depth of the gel at rest, m.
    pub thickness: f64,
}

/// State of the projectile at the end of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum ShotEnd {
    /// The projectile rests in the gel.
    AtRest {
        /// Mean depth of the foremost point over the last millisecond, m.
        depth: f64,
        /// Time of rest, s.
        time: f64,
    },
    /// The foremost point has reached the back face of the gel.
    Perforated,
    /// The projectile has left the gel through the entry.
    ThrownBack,
    /// The projectile does not rest.
    Moving {
        /// Depth of the foremost point, m.
        depth: f64,
        /// Speed along −z, m/s.
        speed: f64,
    },
    /// The run failed; the reason.
    Failed(String),
}

/// Callback after each communication step with the time, s, and the depth, m; it may ask the run to stop.
type ShotCallback<'a> = dyn FnMut(f64, f64) -> ControlFlow<()> + 'a;

/// Shot in progress.
struct ShotTrial {
    scene: Scene,
    simulation: Simulation,
    detector: RestDetector,
    /// Depth of the gel at rest, m.
    thickness: f64,
}

/// Runs a scene until its projectile rests or cannot rest any more; returns `None` if `watch` asked to stop.
pub fn run(mut scene: Scene, threads: usize, watch: &mut ShotCallback<'_>) -> Result<Option<ShotRun>, CommandError> {
    scene.scene.end_time *= END_TIME_FACTOR;
    let simulation = job::build_simulation(&scene, CouplingMode::Integrated, threads)?;
    let start = simulation.frame();
    let thickness = -start.points.iter().map(|point| point.z).fold(0.0, f64::min);
    let trial = ShotTrial { scene, simulation, detector: RestDetector::new(), thickness };
    Ok(trial.finish(watch))
}

impl ShotTrial {
    /// Steps the simulation to the end of the run.
    fn finish(mut self, watch: &mut ShotCallback<'_>) -> Option<ShotRun> {
        for end in job::step_ends(&self.scene, self.scene.scene.communication_step) {
            let inputs = self.simulation.inputs();
            if let Err(error) = self.simulation.step(&inputs, end) {
                return Some(self.into_run(ShotEnd::Failed(error.to_string())));
            }
            let (time, depth) = (self.simulation.time(), self.simulation.depth(0));
            if watch(time, depth).is_break() {
                return None;
            }
            if let Some(end) = self.check_end(time, depth) {
                return Some(self.into_run(end));
            }
        }
        let (depth, speed) = (self.simulation.depth(0), -self.simulation.kinematics(0).velocity.z);
        Some(self.into_run(ShotEnd::Moving { depth, speed }))
    }

    /// Returns the end of the run if the projectile rests, or cannot rest any more.
    fn check_end(&mut self, time: f64, depth: f64) -> Option<ShotEnd> {
        self.detector.push(time, depth);
        if self.detector.peak().is_some_and(|peak| peak.depth >= self.thickness) {
            return Some(ShotEnd::Perforated);
        }
        let is_deep = self.detector.peak().is_some_and(|peak| peak.depth > 0.0);
        if is_deep && depth <= 0.0 && self.simulation.kinematics(0).velocity.z > 0.0 {
            return Some(ShotEnd::ThrownBack);
        }
        self.detector.rest().map(|rest| ShotEnd::AtRest { depth: rest.depth, time: rest.time })
    }

    /// Returns the measurements.
    fn into_run(self, end: ShotEnd) -> ShotRun {
        ShotRun { end, time: self.simulation.time(), thickness: self.thickness }
    }
}

/// Depth, m, from which the value is likely to be in millimetres: no block of gel is so thick.
const DEEPEST_IN_METRES: f64 = 1.0;

/// Explains why a projectile cannot rest at a depth in a gel of that thickness, both m; `None` if the depth is valid.
pub fn explain_excess_depth(depth: f64, thickness: f64) -> Option<String> {
    let hint = if (DEEPEST_IN_METRES..1e3 * DEEPEST_IN_METRES).contains(&depth) {
        format!("; were millimetres meant? They are {} m", 1e-3 * depth)
    } else {
        String::new()
    };
    (depth >= thickness)
        .then(|| format!("found {depth:?} m, expected less than the depth of the gel, {thickness:?} m{hint}"))
}
