//! Run by direct calls of the library, without the FMU.

use crate::failure::RunError;
use crate::forecast::RunPoint;
use crate::job::{self, ProgressCallback, RunEnding, RunJob};
use ballistic_gel::fmi2;
use ballistic_gel::output::{DriverInterface, ResultFolder, RunRecorder};
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Runs the job to its end, to the first step that fails, or until `progress` asks to stop, and writes all computed
/// results.
pub fn run(job: &RunJob, folder: ResultFolder, progress: &mut ProgressCallback<'_>) -> Result<RunEnding, RunError> {
    let scene = &job.source.scene;
    let mut simulation = job::build_simulation(scene, CouplingMode::Integrated, job.threads)?;
    let mut recorder = RunRecorder::within(folder, scene, DriverInterface::Direct, job.threads)?;
    recorder.record(&simulation)?;
    let ending = step_to_end(&mut simulation, &mut recorder, job.times(), progress)?;
    recorder.finish(&simulation, ending.failure())?;
    Ok(ending)
}

/// Steps to the end by these ends of communication steps, s, and records each.
pub fn step_to_end(
    simulation: &mut Simulation,
    recorder: &mut RunRecorder,
    times: impl Iterator<Item = f64>,
    progress: &mut ProgressCallback<'_>,
) -> Result<RunEnding, RunError> {
    if progress(point_of(simulation)).is_break() {
        return Ok(RunEnding::Interrupted);
    }
    for time in times {
        let inputs = simulation.inputs();
        let _reserve = fmi2::reserve_for_step(simulation)?;
        if let Err(error) = simulation.step(&inputs, time) {
            return Ok(RunEnding::Stopped(simulation.diagnosis().unwrap_or_else(|| error.to_string())));
        }
        recorder.record(simulation)?;
        if simulation.is_over() {
            return Ok(RunEnding::Completed);
        }
        if progress(point_of(simulation)).is_break() {
            return Ok(RunEnding::Interrupted);
        }
    }
    Ok(RunEnding::Completed)
}

/// Returns the state of the projectile for the progress.
fn point_of(simulation: &Simulation) -> RunPoint {
    RunPoint { time: simulation.time(), depth: simulation.depth(0), exit: simulation.exit(0).map(|exit| exit.time) }
}
