//! Run of a scene: job, ending and errors.

use crate::failure::CommandError;
use ballistic_gel::fmi2::{self, MemoryShortage, RoomError};
use ballistic_gel::output::OutputError;
use ballistic_gel::scene::{self, MOST_STEPS, Scene, SceneError};
use ballistic_gel::simulation::{BuildError, CouplingMode, Simulation};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Scene to run, and the destination of its results.
#[derive(Debug)]
pub struct RunJob {
    /// Scene text with all overrides, and the base folder of relative file names.
    pub scene: (String, PathBuf),
    /// Folder for the results.
    pub folder: PathBuf,
    /// Communication step, s; the step of the scene if absent.
    pub step: Option<f64>,
    /// Number of threads; 0 is all cores.
    pub threads: usize,
}

/// Callback after each communication step with the time reached and the end time, s; it may ask the run to stop.
pub type ProgressCallback<'a> = dyn FnMut(f64, f64) -> ControlFlow<()> + 'a;

/// Ending of a run.
#[derive(Debug, PartialEq, Eq)]
pub enum RunEnding {
    /// The run reached its end time, or the end after the exit of the projectile.
    Completed,
    /// The run stopped early; the diagnosis.
    Stopped(String),
    /// The user interrupted the run.
    Interrupted,
}

/// Errors that prevent a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The memory is too small.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// The results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A file cannot be used.
    #[error("cannot {verb} {}: {source}", path.display())]
    File {
        /// Attempted action, a verb.
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The FMU answered a call with an error.
    #[error("the FMU failed in {call}: {reason}")]
    Component {
        /// Name of the FMI function.
        call: &'static str,
        /// Message that the FMU logged.
        reason: String,
    },
}

/// Builds the simulation of a scene, after a check that the memory is large enough.
pub fn build_simulation(scene: &Scene, mode: CouplingMode, threads: usize) -> Result<Simulation, RunError> {
    let _reserve = fmi2::reserve_for_building(scene).map_err(|error| match error {
        RoomError::Build(error) => RunError::Build(error),
        RoomError::Memory(short) => RunError::Memory(short),
    })?;
    Ok(Simulation::new(scene, mode, threads)?)
}

/// Refuses a communication step, s, too short for the run to end in a lifetime.
pub fn check_communication_step(step: f64, scene: &Scene) -> Result<(), CommandError> {
    let end = scene.scene.end_time;
    let n_steps = end / step;
    // The message rounds the shortest step; the rounded value must be accepted.
    if n_steps * (1.0 - 1e-3) <= MOST_STEPS {
        return Ok(());
    }
    let shortest = end / MOST_STEPS;
    Err(CommandError::BadInput(format!(
        "--step {step:e}: found {n_steps:.3e} steps to the end time, {end:?} s, expected at most {MOST_STEPS:e}: a step of \
         {shortest:.3e} s or more"
    )))
}

impl RunJob {
    /// Parses the scene and reads its files.
    pub fn read_scene(&self) -> Result<Scene, SceneError> {
        let (text, folder) = &self.scene;
        scene::read_with_files(text, &fmi2::scene_file_reader(folder))
    }

    /// Returns the ends of the communication steps, s.
    pub fn times(&self, scene: &Scene) -> impl Iterator<Item = f64> + use<> {
        step_ends(scene, self.step.unwrap_or(scene.scene.communication_step))
    }
}

/// Returns the ends of the communication steps of a scene, s: multiples of the step; the last one is the end time.
pub fn step_ends(scene: &Scene, step: f64) -> impl Iterator<Item = f64> + use<> {
    /// Fraction of a step below which a last step is round-off.
    const ROUND_OFF: f64 = 1e-6;
    let end = scene.scene.end_time;
    let n_steps = (end / step - ROUND_OFF).ceil().max(1.0) as u64;
    (1..=n_steps).map(move |k| if k == n_steps { end } else { k as f64 * step })
}

#[cfg(test)]
mod tests {
    use super::{PathBuf, RunJob, check_communication_step};
    use ballistic_gel::scene;

    fn step_ends(step: f64) -> Vec<f64> {
        let text = scene::builtin("sphere-block").unwrap();
        let job =
            RunJob { scene: (text.to_owned(), PathBuf::new()), folder: "unused".into(), step: Some(step), threads: 1 };
        job.times(&scene::read(text).unwrap()).collect()
    }

    #[test]
    fn communication_steps_end_at_the_end_time_exactly() {
        for step in [1e-5, 1e-4, 3e-4, 7e-3, 0.01, 1.0] {
            assert_eq!(step_ends(step).last(), Some(&0.01), "step {step}");
        }
    }

    #[test]
    fn a_step_that_divides_the_end_time_gives_no_sliver() {
        assert_eq!(step_ends(1e-5).len(), 1000);
        assert_eq!(step_ends(0.01 / 3.0).len(), 3);
        assert_eq!(step_ends(0.01 / 12_345.0).len(), 12_345);
    }

    #[test]
    fn a_step_without_an_end_is_refused_with_the_shortest_valid_step() {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let refused = check_communication_step(1e-20, &scene).unwrap_err().to_string();
        assert!(refused.starts_with("--step 1e-20: found 1.000e18 steps"), "{refused}");
        assert!(refused.ends_with("a step of 1.000e-11 s or more"), "{refused}");
        assert!(check_communication_step(1e-11, &scene).is_ok() && check_communication_step(1.0, &scene).is_ok());
    }

    #[test]
    fn a_step_that_does_not_divide_the_end_time_ends_with_a_shorter_one() {
        assert_eq!(step_ends(4e-3), [4e-3, 8e-3, 0.01]);
    }
}
