//! One run of a shot until its projectile stops.

use super::search::Outcome;
use crate::failure::Failure;
use crate::job;
use crate::options::CalibrateOptions;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::ops::ControlFlow;

/// A projectile in a weaker gel takes longer than the scene goes on: it is given so many times its end time.
const PATIENCE: f64 = 4.0;

/// Told after each communication step the time, s, and the depth, m; may ask to stop.
type Watch<'a> = dyn FnMut(f64, f64) -> ControlFlow<()> + 'a;

/// Runs a scene until its projectile turns back or has left the gel; nothing if `watch` asked to stop.
pub fn run(mut scene: Scene, options: &CalibrateOptions, watch: &mut Watch<'_>) -> Result<Option<Outcome>, Failure> {
    scene.scene.end_time *= PATIENCE;
    let mut simulation = job::built(&scene, CouplingMode::Integrated, options.threads)?;
    let gel = -simulation.frame().points.iter().map(|point| point.z).fold(0.0, f64::min);
    if let Some(why) = too_deep(options.depth, gel) {
        return Err(Failure::BadInput(format!("--depth: {why}")));
    }
    let step = scene.scene.communication_step;
    let n_steps = (scene.scene.end_time / step).ceil() as u64;
    for k in 1..=n_steps {
        let inputs = simulation.inputs();
        if let Err(error) = simulation.step(&inputs, k as f64 * step) {
            return Ok(Some(Outcome::Failed(error.to_string())));
        }
        let depth = simulation.depth(0);
        if watch(simulation.time(), depth).is_break() {
            return Ok(None);
        }
        if depth >= gel {
            return Ok(Some(Outcome::Through));
        }
        if simulation.kinematics(0).velocity.z >= 0.0 {
            return Ok(Some(stopped(&simulation)));
        }
    }
    Ok(Some(on_the_way(&simulation, options.depth)))
}

/// Depth from which on millimetres may have been meant, m: no block of gel that is shot at is so deep.
const DEEPEST: f64 = 1.0;

/// Explains why a projectile cannot stop at a depth in a gel of that thickness, both m: it would have left it.
pub fn too_deep(depth: f64, gel: f64) -> Option<String> {
    let meant = if (DEEPEST..1e3 * DEEPEST).contains(&depth) {
        format!("; were millimetres meant? They are {} m", 1e-3 * depth)
    } else {
        String::new()
    };
    (depth >= gel).then(|| format!("found {depth:?} m, expected less than the depth of the gel, {gel:?} m{meant}"))
}

fn stopped(simulation: &Simulation) -> Outcome {
    let (depth, time) = simulation.contact(0).peak_depth;
    Outcome::Stopped { depth, time }
}

/// What a run tells whose projectile still moves: that it goes deeper, if it is too deep already.
fn on_the_way(simulation: &Simulation, target: f64) -> Outcome {
    let (depth, speed) = (simulation.depth(0), -simulation.kinematics(0).velocity.z);
    if depth > target {
        return Outcome::Through;
    }
    let reason = format!(
        "found the projectile still moving at {speed:.3} m/s after {:e} s, {:.2} mm deep: give it a longer scene.end_time",
        simulation.time(),
        1e3 * depth
    );
    Outcome::Failed(reason)
}
