//! Scenes of the benchmark: built-in scenes with some keys replaced.

use super::options::ElementName;
use crate::failure::{CommandError, RunError};
use crate::source;
use ballistic_gel::scene::{Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Returns an override of a key with a TOML value.
pub fn new_override(key: &str, value: impl Into<String>) -> Override {
    Override { key: key.to_owned(), value: value.into() }
}

/// Loads a built-in scene with overrides.
pub fn load_scene(name: &str, overrides: &[Override]) -> Result<Scene, CommandError> {
    Ok(source::load(name, overrides)?.scene)
}

/// Returns an override that lets the gel drift slowly towards the ball: every node moves and no update is skipped.
pub fn drifting_gel() -> Override {
    new_override("gel.velocity", "[0.0, 0.0, 0.01]")
}

/// Returns an override with cells of `sphere-block` for about `n_elements`: at 5 mm it has 51 200.
pub fn cell_size(n_elements: usize) -> Override {
    new_override("mesh.size", format!("{:e}", 5e-3 * (51_200.0 / n_elements as f64).cbrt()))
}

/// Returns an override with the kind of element.
pub fn element_kind(kind: ElementName) -> Override {
    new_override("mesh.element", format!("{:?}", kind.as_str()))
}

/// Builds the simulation of a scene that integrates its ball.
pub fn new_simulation(scene: &Scene, threads: usize) -> Result<Simulation, CommandError> {
    Ok(Simulation::new(scene, CouplingMode::Integrated, threads).map_err(RunError::from)?)
}

/// Steps to a time, s, without external loads on the ball.
pub fn step_to(simulation: &mut Simulation, end: f64) -> Result<(), CommandError> {
    let inputs = simulation.inputs();
    simulation
        .step(&inputs, end)
        .map_err(|error| CommandError::Run(RunError::Component { call: "Simulation::step", reason: error.to_string() }))
}
