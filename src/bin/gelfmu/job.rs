//! Run of a scene: job, ending and errors.

use crate::failure::RunError;
use crate::forecast::RunPoint;
use crate::source::SceneSource;
use ballistic_gel::fmi2::{self, MemoryReserve, RoomError};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Scene to run, and the destination of its results.
#[derive(Debug)]
pub struct RunJob {
    /// Scene with all overrides.
    pub source: SceneSource,
    /// Folder for the results.
    pub folder: PathBuf,
    /// Communication step, s; the step of the scene if absent.
    pub step: Option<f64>,
    /// Number of threads; 0 is all cores.
    pub threads: usize,
}

/// Callback after each communication step; it may ask the run to stop.
pub type ProgressCallback<'a> = dyn FnMut(RunPoint) -> ControlFlow<()> + 'a;

/// Ending of a run.
#[derive(Debug, PartialEq, Eq)]
pub enum RunEnding {
    /// The run reached its end time, or the end after the exit or the rest of the projectile.
    Completed,
    /// The run stopped early; the diagnosis.
    Stopped(String),
    /// The user interrupted the run.
    Interrupted,
}

impl RunEnding {
    /// Returns the diagnosis of a run that stopped early.
    pub fn failure(&self) -> Option<&str> {
        match self {
            Self::Completed | Self::Interrupted => None,
            Self::Stopped(diagnosis) => Some(diagnosis),
        }
    }
}

/// Builds the simulation of a scene, after a check that the memory is large enough.
pub fn build_simulation(scene: &Scene, mode: CouplingMode, threads: usize) -> Result<Simulation, RunError> {
    let _reserve = reserve_for_building(scene)?;
    Ok(Simulation::new(scene, mode, threads)?)
}

/// Reserves the memory for building a scene, or returns the reason why its mesh is refused.
pub fn reserve_for_building(scene: &Scene) -> Result<MemoryReserve, RunError> {
    fmi2::reserve_for_building(scene).map_err(|error| match error {
        RoomError::Build(error) => RunError::Build(error),
        RoomError::Memory(short) => RunError::Memory(short),
    })
}

impl RunJob {
    /// Returns the ends of the communication steps, s.
    pub fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let scene = &self.source.scene;
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
    use super::step_ends;
    use ballistic_gel::scene;

    fn ends(step: f64) -> Vec<f64> {
        step_ends(&scene::read(scene::builtin("sphere-block").unwrap()).unwrap(), step).collect()
    }

    #[test]
    fn communication_steps_end_at_the_end_time_exactly() {
        for step in [1e-5, 1e-4, 3e-4, 7e-3, 0.01, 1.0] {
            assert_eq!(ends(step).last(), Some(&0.01), "step {step}");
        }
    }

    #[test]
    fn a_step_that_divides_the_end_time_gives_no_sliver() {
        assert_eq!(ends(1e-5).len(), 1000);
        assert_eq!(ends(0.01 / 3.0).len(), 3);
        assert_eq!(ends(0.01 / 12_345.0).len(), 12_345);
    }

    #[test]
    fn a_step_that_does_not_divide_the_end_time_ends_with_a_shorter_one() {
        assert_eq!(ends(4e-3), [4e-3, 8e-3, 0.01]);
    }
}
