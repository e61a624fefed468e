//! Simulation of one shot until its projectile stops.

use super::search::ShotOutcome;
use crate::failure::CommandError;
use crate::job;
use crate::options::CalibrateOptions;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::ops::ControlFlow;

/// Factor on the end time of the scene: a projectile in a weaker gel takes longer to stop.
const END_TIME_FACTOR: f64 = 4.0;

/// Callback after each communication step with the time, s, and the depth, m; it may ask the run to stop.
type ShotCallback<'a> = dyn FnMut(f64, f64) -> ControlFlow<()> + 'a;

/// Runs a scene until its projectile turns back or has left the gel; returns `None` if `watch` asked to stop.
pub fn run(
    mut scene: Scene,
    options: &CalibrateOptions,
    watch: &mut ShotCallback<'_>,
) -> Result<Option<ShotOutcome>, CommandError> {
    scene.scene.end_time *= END_TIME_FACTOR;
    let mut simulation = job::build_simulation(&scene, CouplingMode::Integrated, options.threads)?;
    let thickness = -simulation.frame().points.iter().map(|point| point.z).fold(0.0, f64::min);
    if let Some(why) = explain_excess_depth(options.depth, thickness) {
        return Err(CommandError::BadInput(format!("--depth: {why}")));
    }
    let step = scene.scene.communication_step;
    let n_steps = (scene.scene.end_time / step).ceil() as u64;
    for k in 1..=n_steps {
        let inputs = simulation.inputs();
        if let Err(error) = simulation.step(&inputs, k as f64 * step) {
            return Ok(Some(ShotOutcome::Failed(error.to_string())));
        }
        let depth = simulation.depth(0);
        if watch(simulation.time(), depth).is_break() {
            return Ok(None);
        }
        if depth >= thickness {
            return Ok(Some(ShotOutcome::Through));
        }
        if simulation.kinematics(0).velocity.z >= 0.0 {
            return Ok(Some(stopped_outcome(&simulation)));
        }
    }
    Ok(Some(outcome_in_motion(&simulation, options.depth)))
}

/// Depth, m, from which the value is likely to be in millimetres: no block of gel is so thick.
const DEEPEST_IN_METRES: f64 = 1.0;

/// Explains why a projectile cannot stop at a depth in a gel of that thickness, both m; `None` if the depth is valid.
pub fn explain_excess_depth(depth: f64, thickness: f64) -> Option<String> {
    let hint = if (DEEPEST_IN_METRES..1e3 * DEEPEST_IN_METRES).contains(&depth) {
        format!("; were millimetres meant? They are {} m", 1e-3 * depth)
    } else {
        String::new()
    };
    (depth >= thickness)
        .then(|| format!("found {depth:?} m, expected less than the depth of the gel, {thickness:?} m{hint}"))
}

fn stopped_outcome(simulation: &Simulation) -> ShotOutcome {
    let (depth, time) = simulation.contact(0).peak_depth;
    ShotOutcome::Stopped { depth, time }
}

/// Returns the outcome of a run whose projectile still moves: through if it is below the target already, else failed.
fn outcome_in_motion(simulation: &Simulation, target: f64) -> ShotOutcome {
    let (depth, speed) = (simulation.depth(0), -simulation.kinematics(0).velocity.z);
    if depth > target {
        return ShotOutcome::Through;
    }
    let reason = format!(
        "found the projectile still moving at {speed:.3} m/s after {:e} s, {:.2} mm deep: give it a longer scene.end_time",
        simulation.time(),
        1e3 * depth
    );
    ShotOutcome::Failed(reason)
}
