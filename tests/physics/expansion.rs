//! Bullets that expand: the work of an opening against a closed form, what it keeps, and that no bit depends on how time is
//! sliced.

use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Observation, SavedSimulation, ShapeMotion, Simulation, StepInputs};
use std::f64::consts::PI;

/// A hollow point on a cylinder of gelatin; it opens in the first 12 mm.
const SHOT: &str = include_str!("expansion.toml");

/// Changes that put the shot into half of a block, with yaw.
const IN_SPACE: [&str; 6] = [
    "scene.dimension=spatial",
    "scene.end_time=3e-5",
    "gel.shape={block={size=[0.04, 0.04, 0.03]}}",
    "gel.symmetry=half",
    "projectile.orientation=[0.9990482, 0.0, 0.0436194, 0.0]",
    "mesh.size=2.5e-3",
];

fn scene_of(text: &str, changes: &[&str]) -> Scene {
    let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
    scene::read(&scene::resolve(text, &changes).unwrap()).unwrap_or_else(|error| panic!("{error}"))
}

fn run(scene: &Scene, steps: u32, threads: usize, mut inputs: impl FnMut(f64, &mut StepInputs)) -> Simulation {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, threads).unwrap();
    for step in 1..=steps {
        let mut given = simulation.inputs();
        inputs(simulation.time(), &mut given[0]);
        simulation.step(&given, scene.scene.end_time * f64::from(step) / f64::from(steps)).unwrap();
    }
    simulation
}

/// Sets the opening and its rate, 1/s.
fn open(inputs: &mut StepInputs, opening: f64, rate: f64) {
    let Some(ShapeMotion::Expansion(motion)) = &mut inputs.shape_motion else { panic!("the body expands") };
    (motion.opening, motion.rate, motion.end) = (opening, rate, 1.0);
}

fn closes(seen: &Observation) {
    assert!(seen.energy.energy_error < 1e-10, "{}", seen.energy.energy_error);
    assert!(seen.momentum_error < 1e-12 && seen.angular_momentum_error < 1e-12, "{seen:?}");
}

#[test]
fn a_bullet_opens_along_its_path_and_its_bits_do_not_depend_on_slices_or_threads() {
    for changes in [&[][..], &IN_SPACE] {
        let scene = scene_of(SHOT, changes);
        let digests = [(1, 1), (7, 1), (60, 2)].map(|(steps, threads)| {
            let simulation = run(&scene, steps, threads, |_, _| ());
            let seen = simulation.observe();
            closes(&seen);
            let expected = if changes.is_empty() { 1.0 } else { 0.7 };
            assert!((seen.bodies[0].expansion() - expected).abs() < 0.1, "{}", seen.bodies[0].expansion());
            let part = seen.energy.expansion / seen.bodies[0].energy_deposited;
            assert!(part != 0.0 && part.abs() < 0.15, "{part}");
            simulation.digest()
        });
        assert!(digests.iter().all(|digest| *digest == digests[0]), "{changes:?}");
    }
}

#[test]
fn a_bullet_that_was_saved_while_it_opens_goes_on_with_the_same_bits() {
    let scene = scene_of(SHOT, &["scene.end_time=6e-5"]);
    let whole = run(&scene, 10, 1, |_, _| ());
    let mut first = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let inputs = first.inputs();
    first.step(&inputs, 2.4e-5).unwrap();
    assert!((0.3..0.9).contains(&first.expansion(0)), "{}", first.expansion(0));
    let (mut bytes, mut saved) = (vec![], SavedSimulation::empty());
    first.save().write(&mut |run| bytes.extend_from_slice(run));
    assert!(saved.read(&bytes));
    let mut second = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    second.restore(&saved).unwrap();
    let inputs = second.inputs();
    second.step(&inputs, 6e-5).unwrap();
    assert_eq!(second.digest(), whole.digest());
}

#[test]
fn a_bullet_below_its_threshold_stays_as_it_is() {
    let slow = ["projectile.velocity=[0, 0, -180.0]", "scene.end_time=6e-5"];
    let seen = run(&scene_of(SHOT, &slow), 1, 1, |_, _| ()).observe();
    assert_eq!((seen.bodies[0].expansion(), seen.energy.expansion), (0.0, 0.0));
    let rigid =
        SHOT.split("[projectile.expansion]").next().unwrap().to_owned() + SHOT.split("path = 12e-3\n").nth(1).unwrap();
    let same = run(&scene_of(&rigid, &slow), 1, 1, |_, _| ()).observe();
    let speeds = [&seen, &same].map(|seen| seen.bodies[0].kinematics.velocity.z);
    assert!((speeds[0] / speeds[1] - 1.0).abs() < 1e-3, "{speeds:?}");
}

#[test]
fn a_body_that_opens_beside_the_gel_changes_its_rotation_alone() {
    let beside = [
        "scene.dimension=spatial",
        "gel.shape={block={size=[0.02, 0.02, 0.02]}}",
        "projectile.position=[0.0, 0.0, 0.1]",
        "projectile.velocity=[0.0, 0.0, 100.0]",
        "projectile.angular_velocity=[300.0, -50.0, 9000.0]",
        "mesh.size=4e-3",
    ];
    let text = SHOT.replace("opening_speed = 200.0\nfull_speed = 250.0\n", "");
    let scene = scene_of(&text, &beside);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let before = simulation.observe();
    let opened = run(&scene, 12, 1, |t, inputs| open(inputs, t / 1.2e-4, 1.0 / 1.2e-4));
    let after = opened.observe();
    closes(&after);
    assert!((after.bodies[0].expansion() - 1.0).abs() < 1e-12);
    let [was, is] = [&before, &after].map(|seen| &seen.bodies[0].kinematics);
    assert_eq!((was.velocity, after.bodies[0].contact.total_impulse), (is.velocity, Vector3::zeros()));
    // The wider body turns more slowly: the spin falls with the axial inertia, and so does its energy.
    let (slower, lost) = (is.angular_velocity.norm() / was.angular_velocity.norm(), after.energy.expansion);
    assert!(slower < 0.8, "{slower}");
    let change = after.energy.kinetic - before.energy.kinetic;
    assert!(
        lost < 0.0 && (change - lost - after.energy.integration).abs() < 1e-9 * before.energy.kinetic,
        "{change} {lost}"
    );
    let inputs = simulation.inputs();
    simulation.step(&inputs, 1.2e-4).unwrap();
    assert_eq!(simulation.expansion(0), 0.0, "without a rate nothing opens");
}

/// A bore of 5 mm is opened to 7 mm by a cylinder that grows in it. In plane strain an incompressible ring goes from R to
/// r, r² = R² + c, and stores ½G (r²/R² + R²/r² − 2) per volume: W = ½πGc ln[B²(A² + c)/(A²(B² + c))] per length.
#[test]
fn a_body_that_opens_at_rest_does_the_work_of_a_quasi_static_cavity() {
    const BORE: &str = r#"
[scene]
name = "bore"
dimension = "axisymmetric"
end_time = 0.04
communication_step = 1e-3
[gel]
shape.cylinder = { radius = 0.02, height = 0.004, bore = 0.005 }
supports = { z_min = "roller", z_max = "roller" }
material = "neo-hookean"
density = 1030.0
shear_modulus = 35e3
bulk_modulus = 7e6
[integrator]
damping = 100.0
[projectile]
shape.bullet = { radius = 4.9e-3, length = 0.02, nose = "flat" }
fixed = true
position = [0.0, 0.0, -0.002]
[projectile.expansion]
opened = { radius = 7e-3, length = 0.02, head_length = 0.02, edge_radius = 0.0, shank_radius = 7e-3 }
[mesh]
size = 0.5e-3
element = "patch"
"#;
    let scene = scene_of(BORE, &[]);
    let simulation = run(&scene, 40, 1, |t, inputs| open(inputs, t / 0.04, 25.0));
    let seen = simulation.observe();
    closes(&seen);
    let (inner, outer, modulus) = (5e-3_f64.powi(2), 2e-2_f64.powi(2), 35e3);
    let grown = 7e-3_f64.powi(2) - inner;
    let work = 0.004 * 0.5 * PI * modulus * grown * (outer * (inner + grown) / (inner * (outer + grown))).ln();
    assert!((seen.energy.expansion / work - 1.0).abs() < 0.03, "{} against {work}", seen.energy.expansion);
    assert!((seen.energy.elastic / work - 1.0).abs() < 0.03, "{} against {work}", seen.energy.elastic);
    let impulse = simulation.exchanges()[0].shape_impulse[0];
    assert!(impulse < 0.0, "the gel resists the opening: {impulse}");
}

/// Opening between the thresholds: it ends where the stagnation pressure of the present speed is in proportion, and grows by
/// the path flown until then.
#[test]
fn a_bullet_between_its_thresholds_opens_along_its_path_in_proportion_to_the_stagnation_pressure() {
    let slow = ["projectile.velocity=[0, 0, -230.0]", "scene.end_time=1e-4"];
    let simulation = run(&scene_of(SHOT, &slow), 100, 1, |_, _| ());
    let opening = simulation.expansion(0);
    // From 230 m/s on: (230² − 200²)/(250² − 200²) = 0.57, and less as the bullet is slowed.
    assert!((0.3..0.573).contains(&opening), "{opening}");
    let fast = run(&scene_of(SHOT, &["scene.end_time=2e-5"]), 20, 1, |_, _| ());
    let path = 12e-3 * fast.expansion(0);
    let flown = 0.0072 - fast.observe().bodies[0].kinematics.position.z;
    assert!((path / (flown - 0.0003) - 1.0).abs() < 0.1, "{path} of {flown}");
}

#[test]
fn a_body_that_is_deactivated_stops_opening() {
    let scene = scene_of(SHOT, &[]);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).unwrap();
    let inputs = simulation.inputs();
    simulation.step(&inputs, 2e-5).unwrap();
    let opening = simulation.expansion(0);
    for (active, end) in [(false, 3e-5), (true, 4e-5)] {
        let mut inputs = simulation.inputs();
        (inputs[0].active, inputs[0].kinematics.position.z, inputs[0].kinematics.velocity) =
            (active, 0.05, Vector3::zeros());
        simulation.step(&inputs, end).unwrap();
        assert_eq!(simulation.expansion(0), opening);
    }
}

#[test]
fn a_bullet_that_has_left_another_gel_starts_as_it_is_opened() {
    let opened = scene_of(SHOT, &["projectile.expansion.opening=1.0", "projectile.position=[0, 0, 0.0047]"]);
    let simulation = Simulation::new(&opened, CouplingMode::Integrated, 1).unwrap();
    assert_eq!(simulation.expansion(0), 1.0);
    let close = scene::resolve(SHOT, &["projectile.position=[0, 0, 0.0047]".parse().unwrap()]).unwrap();
    assert!(scene::read(&close).unwrap_err().to_string().contains("deep in the gel"), "unopened it is longer");
}
