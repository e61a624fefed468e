//! Meshes whose cells double away from the impact: every shape that has a point of entry, and the scenes that come with it.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{BuildError, CouplingMode, Observation, Simulation};

fn with(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    let text = scene::resolve(scene::builtin(name).unwrap(), &changes).unwrap();
    scene::read(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn start(scene: &Scene) -> Simulation {
    Simulation::new(scene, CouplingMode::Integrated, 1).unwrap()
}

fn after(scene: &Scene, time: f64) -> Observation {
    let mut simulation = start(scene);
    let inputs = simulation.inputs();
    simulation.step(&inputs, time).unwrap();
    simulation.observe()
}

/// Planar block, axisymmetric and spatial cylinder, spatial block; without their meshes.
const SHAPES: [(&str, &[&str]); 4] = [
    ("ball-square", &["projectile.velocity=[0, 0, -5]"]),
    ("ball-bounce", &["mesh={size=2.5e-3}"]),
    ("sphere-block", &["gel.shape={cylinder={radius=0.05, height=0.05}}"]),
    ("sphere-block", &[]),
];

#[test]
fn every_shape_with_a_point_of_entry_has_its_tree_and_its_books_close() {
    for (name, changes) in SHAPES {
        let size = "mesh.size=2.5e-3";
        let uniform = start(&with(name, &[changes, &[size]].concat())).observe();
        let tree = with(name, &[changes, &[size, "mesh.tree={coarsest=8, core=5e-3, slope=0.5}"]].concat());
        let last = after(&tree, 5e-4);
        assert!(last.cost.elements < uniform.cost.elements / 3, "{name}: {:?}", last.cost);
        assert!(last.cost.largest_step >= 4.0 * last.cost.smallest_step, "{name}: {:?}", last.cost);
        assert!(last.projectile().contact.total_impulse.z > 0.0, "{name}: nothing was touched");
        assert!(last.energy.energy_error < 1e-11, "{name}: {:?}", last.energy);
    }
}

#[test]
fn the_graded_scenes_have_small_elements_in_a_small_part_only() {
    for coarsest in [4.0, 8.0, 16.0] {
        let frame = start(&with(&format!("sphere-graded-{coarsest}"), &[])).frame();
        let steps = &frame.cells.step;
        let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let most = steps.iter().copied().fold(0.0, f64::max);
        assert!(most / least >= coarsest, "1:{coarsest}: {least:e} s to {most:e} s");
        let shortest = steps.iter().filter(|step| **step == least).count();
        assert!(10 * shortest < steps.len(), "1:{coarsest}: {shortest} of {} elements", steps.len());
    }
}

#[test]
fn a_tree_of_too_many_cells_is_refused_before_it_is_built() {
    let scene = with("sphere-block", &["mesh.size=1e-4", "mesh.tree={coarsest=2, core=1, slope=1}"]);
    let error = Simulation::new(&scene, CouplingMode::Integrated, 1).err().expect("500 million cells are too many");
    assert!(matches!(error, BuildError::TooLarge { .. }), "{error}");
}
