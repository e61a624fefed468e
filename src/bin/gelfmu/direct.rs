//! Run by direct calls of the library, without the FMU.

use crate::job::{self, Ending, Job, Progress, RunError};
use ballistic_gel::fmi2;
use ballistic_gel::output::{Interface, Recorder, ResultFolder};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Runs the job to its end, to the first step that fails, or until `progress` asks to stop, and writes all computed
/// results.
pub fn run(job: &Job, folder: ResultFolder, progress: &mut Progress<'_>) -> Result<Ending, RunError> {
    let scene = job.read_scene()?;
    let mut simulation = job::build_simulation(&scene, CouplingMode::Integrated, job.threads)?;
    let mut recorder = Recorder::within(folder, &scene, Interface::Direct, job.threads)?;
    recorder.record(&simulation)?;
    let ending = step_to_end(&mut simulation, &mut recorder, job, &scene, progress)?;
    let failure = match &ending {
        Ending::Completed | Ending::Interrupted => None,
        Ending::Stopped(diagnosis) => Some(diagnosis.as_str()),
    };
    recorder.finish(&simulation, failure)?;
    Ok(ending)
}

/// Steps to the end and records every communication step.
fn step_to_end(
    simulation: &mut Simulation,
    recorder: &mut Recorder,
    job: &Job,
    scene: &Scene,
    progress: &mut Progress<'_>,
) -> Result<Ending, RunError> {
    if progress(0.0, scene.scene.end_time).is_break() {
        return Ok(Ending::Interrupted);
    }
    for time in job.times(scene) {
        let inputs = simulation.inputs();
        let _reserve = fmi2::reserve_for_step(simulation)?;
        if let Err(error) = simulation.step(&inputs, time) {
            return Ok(Ending::Stopped(simulation.diagnosis().unwrap_or_else(|| error.to_string())));
        }
        recorder.record(simulation)?;
        if simulation.is_over() {
            return Ok(Ending::Completed);
        }
        if progress(time, scene.scene.end_time).is_break() {
            return Ok(Ending::Interrupted);
        }
    }
    Ok(Ending::Completed)
}
