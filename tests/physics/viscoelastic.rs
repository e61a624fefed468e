//! A gel of two networks with linear branches: what a bounce keeps, what the books say, and that no bit depends on how it is run.

use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Observation, SavedSimulation, Simulation};

/// A few hundred elements in the plane, in space and about an axis.
const SMALL: &str = r#"
[scene]
name = "viscoelastic"
dimension = "spatial"
end_time = 3e-3
communication_step = 1e-4
[gel]
shape.block.size = [0.06, 0.06, 0.03]
material = "two-network"
density = 1030.0
shear_modulus = 30e3
bulk_modulus = 667e3
branches = [{ shear_modulus = 30e3, time = 1e-3 }, { shear_modulus = 60e3, time = 4e-4 }, { shear_modulus = 20e3, time = 1e-5 }]
[projectile]
shape.sphere.radius = 0.03
mass = 0.05
position = [0.0, 0.0, 0.03]
velocity = [0.0, 0.0, -2.0]
[mesh]
size = 0.01
"#;

fn changed(text: &str, changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().expect("key=value")).collect();
    let text = scene::resolve(text, &changes).map_err(|error| format!("{error:?}"))?;
    scene::read(&text).map_err(|error| error.to_string())
}

fn small(changes: &[&str]) -> Scene {
    changed(SMALL, changes).expect("a scene")
}

fn simulation(scene: &Scene, threads: usize) -> Simulation {
    Simulation::new(scene, CouplingMode::Integrated, threads).expect("the scene is small")
}

fn go_on(simulation: &mut Simulation, instants: impl IntoIterator<Item = f64>) {
    for instant in instants {
        let inputs = simulation.inputs();
        simulation.step(&inputs, instant).expect("a shallow impact");
    }
}

fn finished(scene: &Scene) -> Observation {
    let mut simulation = simulation(scene, 1);
    go_on(&mut simulation, [scene.scene.end_time]);
    simulation.observe()
}

const PLANAR: [&str; 3] = ["scene.dimension=planar", "gel.shape.block.size=[0.06, 0.03]", "mesh.size=5e-3"];
const AXISYMMETRIC: [&str; 3] =
    ["scene.dimension=axisymmetric", "gel.shape={cylinder={radius=0.04, height=0.03}}", "mesh.size=5e-3"];

fn scenes() -> Vec<Scene> {
    let patches = ["mesh.element=patch", "mesh.size=5e-3", AXISYMMETRIC[0], AXISYMMETRIC[1]];
    let remeshed = ["remesh.times=[0.8e-3, 2e-3]", AXISYMMETRIC[0], AXISYMMETRIC[1], AXISYMMETRIC[2]];
    let queue = ["integrator.schedule=queue"];
    [&[] as &[&str], &PLANAR, &AXISYMMETRIC, &patches, &["mesh.element=patch"], &queue, &remeshed].map(small).into()
}

#[test]
fn the_books_close_and_what_is_forgotten_is_lost() {
    for scene in scenes() {
        let energy = finished(&scene).energy;
        assert!(energy.imbalance.abs() < 1e-10 * energy.initial, "closure {:e}", energy.imbalance);
        assert!(energy.viscous < -0.02 * energy.initial, "lost {:e} of {:e}", energy.viscous, energy.initial);
        assert!(energy.energy_defect < 0.01, "defect {:e}", energy.energy_defect);
    }
}

#[test]
fn communication_steps_leave_no_trace() {
    for scene in scenes() {
        let digests = [1_u32, 7, 100].map(|n| {
            let mut simulation = simulation(&scene, 1);
            go_on(&mut simulation, (1..=n).map(|i| scene.scene.end_time * f64::from(i) / f64::from(n)));
            simulation.digest()
        });
        assert!(digests.iter().all(|digest| *digest == digests[0]), "{:?}", scene.scene.dimension);
    }
}

#[test]
fn a_restart_from_bytes_and_another_number_of_threads_give_the_same_bits() {
    for scene in scenes() {
        let end = scene.scene.end_time;
        let mut whole = simulation(&scene, 1);
        go_on(&mut whole, [0.4 * end]);
        let mut bytes = Vec::new();
        whole.save().write(&mut |run| bytes.extend_from_slice(run));
        go_on(&mut whole, [end]);
        let mut saved = SavedSimulation::empty();
        assert!(saved.read(&bytes));
        let mut restarted = simulation(&scene, 2);
        restarted.restore(&saved).expect("a state of this scene");
        go_on(&mut restarted, [end]);
        assert_eq!(restarted.digest(), whole.digest(), "{:?}", scene.scene.dimension);
    }
}

/// A foundation of springs keeps 0.844 of the speed at tan δ = 1/6 and ωτ = 1, whatever the speed (`bounce-visco` in the studies); waves
/// take the rest, as from the elastic gel of the same mesh.
#[test]
fn restitution_is_that_of_the_elastic_gel_times_that_of_springs_with_branches() {
    let coarse = [
        "mesh.size=2e-3",
        "mesh.grading={core=6e-3, growth=1.3, largest=12e-3}",
        "gel.bulk_modulus=2e6",
        "scene.end_time=44e-3",
    ];
    let text = scene::builtin("bounce-visco").expect("a built-in scene");
    let bounce = |gel: &[&str]| {
        let seen = finished(&changed(text, &[gel, &coarse].concat()).expect("a scene"));
        let touched = seen.projectile().contact.clone();
        (seen.projectile().kinematics.velocity.z / 0.05, touched.last.unwrap() - touched.first.unwrap())
    };
    let (elastic, contact) = bounce(&["gel.material=neo-hookean", "gel.branches=[]"]);
    let branch = format!("gel.branches=[{{shear_modulus=14e3, time={:e}}}]", contact / std::f64::consts::PI);
    let (restitution, _) = bounce(&[&branch]);
    assert!((restitution - 0.844 * elastic).abs() < 0.01, "{restitution} after {elastic}");
}

#[test]
fn invalid_linear_branches_are_refused_with_the_expected_value() {
    let branch = |change: &str| changed(SMALL, &[change]).expect_err("a mistake");
    for (change, said) in [
        ("gel.branches=[{shear_modulus=-1.0, time=1.0}]", "a positive modulus, Pa"),
        ("gel.branches=[{shear_modulus=1.0, time=0.0}]", "a positive relaxation time, s"),
        ("gel.branches=[{shear_modulus=1e6, time=1.0}]", "more than 2/3 of all shear moduli together"),
        (
            "gel.material=neo-hookean",
            "gel.branches: found a value, expected nothing: only a gel of material \"two-network\"",
        ),
    ] {
        assert!(branch(change).contains(said), "{change}: {}", branch(change));
    }
}
