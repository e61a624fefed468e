use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};
use std::time::Instant;

/// A finished run.
pub struct Run {
    /// What was seen last.
    pub last: Observation,
    /// The diagnosis if it stopped early.
    pub failure: Option<String>,
    /// CPU time on one thread is not known to the standard library: wall time, s.
    pub seconds: f64,
}

/// A built-in scene with some keys replaced.
pub fn scene(name: &str, replaced: &[(&str, String)]) -> Scene {
    let nothing = |file: &str| panic!("{name} names the file {file}");
    scene_with_files(name, replaced, &nothing)
}

/// The same with files that the keys name.
pub fn scene_with_files(name: &str, replaced: &[(&str, String)], files: &scene::FileSource<'_>) -> Scene {
    let overrides: Vec<Override> =
        replaced.iter().map(|(key, value)| Override { key: (*key).into(), value: value.clone() }).collect();
    let text = scene::builtin(name).expect("a built-in scene");
    let resolved = scene::resolve(text, &overrides).expect("keys of the scene");
    scene::read_with_files(&resolved, files).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Says on standard error when no new mesh was taken, and why not.
pub fn tell_refusals(name: &str, simulation: &Simulation) {
    simulation.failed_remeshings().iter().for_each(|refusal| eprintln!("{name}: {refusal}"));
}

/// Runs a scene to its end on all cores, looking at it `looks` times.
pub fn run(scene: &Scene, looks: u32, mut look: impl FnMut(&Simulation)) -> Run {
    let begun = Instant::now();
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 0).expect("a scene that can be built");
    let mut failure = None;
    for i in 1..=looks {
        let (inputs, end) = (simulation.inputs(), scene.scene.end_time * f64::from(i) / f64::from(looks));
        if let Err(error) = simulation.step(&inputs, end) {
            failure = Some(error.to_string());
            break;
        }
        look(&simulation);
    }
    Run { last: simulation.observe(), failure, seconds: begun.elapsed().as_secs_f64() }
}
