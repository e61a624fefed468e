//! The built-in scenes as they are measured.

use super::stand;
use crate::failure::Failure;
use crate::job::RunError;
use crate::options::ElementName;
use crate::source;
use ballistic_gel::scene::{Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// A built-in scene with some keys replaced.
pub fn scene(name: &str, keys: &[(&str, String)]) -> Result<Scene, Failure> {
    let overrides: Vec<Override> =
        keys.iter().map(|(key, value)| Override { key: (*key).to_owned(), value: value.clone() }).collect();
    Ok(source::load(name, &overrides)?.scene)
}

/// Gel that drifts towards the ball, slowly: every node moves and nothing is skipped.
pub fn awake() -> (&'static str, String) {
    ("gel.velocity", "[0.0, 0.0, 0.01]".to_owned())
}

/// Cells of `sphere-block` for about so many elements.
pub fn size(n_elements: usize) -> (&'static str, String) {
    ("mesh.size", format!("{:e}", stand::cell_of_block(n_elements)))
}

/// Plain elements, or patches.
pub fn elements(kind: ElementName) -> (&'static str, String) {
    ("mesh.element", format!("{:?}", kind.as_str()))
}

/// The simulation of a scene, its ball integrated inside.
pub fn simulation(scene: &Scene, threads: usize) -> Result<Simulation, Failure> {
    Ok(Simulation::new(scene, CouplingMode::Integrated, threads).map_err(RunError::from)?)
}

/// Steps to a time, s, nothing acting on the ball from outside.
pub fn advance(simulation: &mut Simulation, end: f64) -> Result<(), Failure> {
    let inputs = simulation.inputs();
    simulation
        .step(&inputs, end)
        .map_err(|error| Failure::Run(RunError::Component { call: "Simulation::step", reason: error.to_string() }))
}
