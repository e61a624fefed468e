//! Reduced model: a whole shot, and communication steps within it.

use ballistic_gel::scene::{self, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use divan::Bencher;

fn scene() -> Scene {
    let level = "scene.fidelity=instant".parse().expect("an override");
    let text = scene::resolve(scene::builtin("fbi-bb").expect("a built-in scene"), &[level]).expect("a level");
    scene::read(&text).expect("a scene at a level")
}

/// Shot of a BB to its end in one communication step.
#[divan::bench]
fn shot(bencher: Bencher) {
    let scene = scene();
    bencher.bench(|| {
        let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a model");
        let inputs = simulation.inputs();
        simulation.step(&inputs, scene.scene.end_time).expect("a step");
        simulation.digest()
    });
}

/// Thousand communication steps of a microsecond.
#[divan::bench]
fn thousand_steps(bencher: Bencher) {
    let scene = scene();
    bencher.with_inputs(|| Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a model")).bench_local_values(
        |mut simulation| {
            for step in 1..=1000 {
                let inputs = simulation.inputs();
                simulation.step(&inputs, f64::from(step) * 1e-6).expect("a step");
            }
        },
    );
}
