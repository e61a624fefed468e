//! Shots with a projectile that has left the gel of a finished run.

use super::{Said, folder, gelfmu_in, json, refused};
use crate::stage;
use ballistic_gel::contact::{BodyState, RigidBody};
use ballistic_gel::math::Vector3;
use ballistic_gel::output::{DriverInterface, FinalState, RunRecorder};
use ballistic_gel::scene::{self, BodyShape, Dimension, GelSymmetry, ProjectileSpec, Scene};
use ballistic_gel::simulation::{
    BodyKinematics, BodyReport, ExitReport, ExpansionMotion, Observation, ShapeMotion, free_body,
};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Times of the rows of a history, s: the projectile leaves the gel before the second one.
const TIMES: [f64; 2] = [0.0008, 0.001];
/// Time of the exit, s.
const EXIT: f64 = 0.00093;

/// The ball of the calibration shot through 12 mm of its gel, on cells of R/3.
const THIN: [&str; 9] = [
    "scene.end_time=1e-3",
    "scene.communication_step=1e-5",
    "scene.stop_after_exit=1e-5",
    "scene.await_cavity=false",
    "gel.shape.cylinder={radius=0.03,height=0.012}",
    "gel.supports.z_min=free",
    "mesh.size=7e-4",
    "remesh.smallest=3.5e-4",
    "output.frames=0",
];

/// A rod in flight behind a gel of 0.05 m: yawed, spinning, and tumbling.
fn rod() -> (Scene, BodyKinematics) {
    let mut scene = stage::scene("spatial");
    scene.mesh.size = 2e-3;
    scene.projectile.shape = BodyShape::Cylinder { radius: 0.005, length: 0.02, edge_radius: 0.0 };
    let flying = BodyKinematics {
        position: Vector3::new(1e-3, 2e-3, -0.064),
        velocity: Vector3::new(3.0, -2.0, -150.0),
        orientation: [0.9, 0.3, -0.1, 0.3],
        angular_velocity: Vector3::new(900.0, -500.0, 4000.0),
    };
    (scene, flying)
}

fn body(kinematics: BodyKinematics, exit: Option<ExitReport>) -> BodyReport {
    let seen = stage::observation(&stage::scene("spatial"), 0.0);
    BodyReport { kinematics, exit, ..seen.bodies[0].clone() }
}

/// Writes the folder of a run that ends with these bodies; all of them are in the gel a row before.
fn write_run(folder: &Path, scene: &Scene, bodies: &[BodyReport]) {
    let mut recorder = RunRecorder::create(folder, scene, DriverInterface::Direct, 1).unwrap();
    let inside = |body: &BodyReport| {
        let mut body = body.clone();
        body.kinematics.position.z = -0.02;
        BodyReport { exit: None, ..body }
    };
    let observation = |time: f64, bodies: Vec<BodyReport>| Observation { bodies, ..stage::observation(scene, time) };
    let before = observation(TIMES[0], bodies.iter().map(inside).collect());
    let after = observation(TIMES[1], bodies.to_vec());
    let frame = || stage::frame(scene, TIMES[1]);
    recorder.record_observation(&before, frame).unwrap();
    recorder.record_observation(&after, frame).unwrap();
    let last = FinalState { observation: &after, frame: &frame(), digest: 1, failure: None };
    recorder.conclude(&last).unwrap();
}

fn exit_of(kinematics: &BodyKinematics) -> ExitReport {
    ExitReport { time: EXIT, velocity: kinematics.velocity, residual_energy: 1.0 }
}

/// `gelfmu new --from-exit run` with these options: its result as JSON.
fn from_exit(folder: &Path, options: &[&str]) -> Value {
    let said = called(folder, options);
    assert_eq!(said.status, Some(0), "{}", said.err);
    json(&said.out)
}

fn called(folder: &Path, options: &[&str]) -> Said {
    gelfmu_in(folder, &[&["new", "--from-exit", "run", "--json"], options].concat())
}

fn scene_of(told: &Value) -> Scene {
    let text = told["text"].as_str().unwrap();
    scene::read(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// State of the body of a scene that has this motion.
fn moving(scene: &Scene, kinematics: &BodyKinematics) -> (RigidBody, BodyState) {
    let spec = ProjectileSpec {
        position: kinematics.position.into(),
        velocity: kinematics.velocity.into(),
        orientation: kinematics.orientation,
        angular_velocity: kinematics.angular_velocity.into(),
        ..scene.projectile.clone()
    };
    free_body(&Scene { projectile: spec, ..scene.clone() }, 0)
}

#[test]
fn a_sphere_enters_the_next_block_as_it_has_left_the_first() {
    let folder = folder();
    let set = THIN.iter().flat_map(|change| ["--set", change]);
    let run = ["run", "fbi-bb", "--direct", "--no-report", "--out", "run"].into_iter().chain(set).collect::<Vec<_>>();
    let said = gelfmu_in(folder.path(), &run);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let summary = json(&fs::read_to_string(folder.path().join("run/summary.json")).unwrap());
    let told = from_exit(folder.path(), &["--gap", "1m", "--block", "10x10x20cm", "--out", "next.toml"]);
    let next = scene::read(&fs::read_to_string(folder.path().join("next.toml")).unwrap()).unwrap();
    let first = scene::read(&fs::read_to_string(folder.path().join("run/scene.toml")).unwrap()).unwrap();
    let [x, y, speed] = next.projectile.velocity;
    let exit = summary["exit_velocity"][2].as_f64().unwrap();
    assert!((x, y) == (0.0, 0.0) && (speed / exit - 1.0).abs() < 1e-14, "{speed} and {exit} m/s");
    let (rigid, state) = free_body(&next, 0);
    let residual = summary["residual_energy"].as_f64().unwrap();
    assert!((rigid.kinetic_energy(&state) / residual - 1.0).abs() < 1e-14, "{residual} J");
    assert_eq!(next.scene.dimension, Dimension::Axisymmetric);
    assert_eq!((next.projectile.mass, &next.projectile.shape), (first.projectile.mass, &first.projectile.shape));
    assert_eq!(next.projectile.position, [0.0, 0.0, 2.185e-3], "touching");
    assert_eq!(told["from_exit"]["exit_time"], summary["exit_time"]);
    let flown = told["from_exit"]["flight_time"].as_f64().unwrap() * -exit;
    assert!((0.98..1.0).contains(&flown), "{flown} m: the ball has come some way in the row after the exit");
    assert_eq!(told["shot"]["speed"].as_f64(), Some(-speed));
    let checked = gelfmu_in(folder.path(), &["check", "next.toml", "--set", "scene.fidelity=draft"]);
    assert!(checked.out.contains("The scene is valid"), "{}{}", checked.out, checked.err);
}

#[test]
fn a_spinning_yawed_rod_flies_through_the_gap_as_a_free_body() {
    let (folder, (scene, flying)) = (folder(), rod());
    write_run(&folder.path().join("run"), &scene, &[body(flying, Some(exit_of(&flying)))]);
    let told = from_exit(folder.path(), &["--gap", "3m"]);
    let next = scene_of(&told);
    assert_eq!((next.scene.dimension, next.gel.symmetry), (Dimension::Spatial, GelSymmetry::None));
    assert_eq!(told["from_exit"]["start_time"].as_f64(), Some(TIMES[1]), "the row after the exit");
    let (rigid, start) = moving(&scene, &flying);
    let (next_rigid, arrived) = free_body(&next, 0);
    assert!(next_rigid.depth(&arrived).abs() < 1e-12, "it touches the block");
    assert_eq!(arrived.position.xy().norm(), 0.0);
    assert_eq!(arrived.velocity, start.velocity);
    let change = (arrived.angular_momentum.norm() / start.angular_momentum.norm() - 1.0).abs();
    let energies = (next_rigid.kinetic_energy(&arrived) / rigid.kinetic_energy(&start) - 1.0).abs();
    assert!(change < 1e-12 && energies < 1e-9, "{change:e}, {energies:e}");
    let (duration, steps) = (told["from_exit"]["flight_time"].as_f64().unwrap(), 400_000);
    let fine =
        (1..=steps).fold(start, |at, step| at.at(&rigid, start.time + duration * f64::from(step) / f64::from(steps)));
    let error = fine.orientation.angle_to(&arrived.orientation).to_degrees();
    assert!(error < 0.02, "{error} degrees");
    let turned = start.orientation.angle_to(&arrived.orientation).to_degrees();
    assert!(turned > 5.0, "{turned} degrees");
    // The lowest point has come from its place behind the first block to 3 m behind that.
    let lowest = -rigid.depth(&start) + (3.0 + 0.05);
    let reach = rigid.reach(&start, &-Vector3::z()) - next_rigid.reach(&arrived, &-Vector3::z());
    assert!((150.0 * duration - (lowest + reach)).abs() < 1e-6, "{duration} s");
    let drift = &told["from_exit"]["drift"];
    assert!((drift[0].as_f64().unwrap() - (1e-3 + 3.0 * duration)).abs() < 1e-12, "{drift}");
}

#[test]
fn fragments_keep_their_places_beside_the_projectile_and_the_foremost_touches() {
    let (folder, (mut scene, flying)) = (folder(), rod());
    let bead = ProjectileSpec {
        shape: BodyShape::Sphere { radius: 2e-3 },
        mass: Some(3e-4),
        position: [0.02, 0.0, 0.05],
        ..scene.projectile.clone()
    };
    scene.fragment = vec![bead.clone(), ProjectileSpec { position: [-0.02, 0.0, 0.05], ..bead }];
    let fast = BodyKinematics {
        position: Vector3::new(6e-3, -1e-3, -0.06),
        velocity: Vector3::new(5.0, 1.0, -180.0),
        ..flying
    };
    let held = BodyKinematics { position: Vector3::new(0.0, 0.0, -0.049), ..fast };
    let bodies = [body(flying, Some(exit_of(&flying))), body(fast, None), body(held, None)];
    write_run(&folder.path().join("run"), &scene, &bodies);
    let told = from_exit(folder.path(), &["--gap", "40 cm"]);
    let next = scene_of(&told);
    assert_eq!(
        (&told["from_exit"]["fragments"][0], &told["from_exit"]["left_out"][0]),
        (&"fragment[1]".into(), &"fragment[2]".into())
    );
    assert!(told["text"].as_str().unwrap().contains("# projectile: fragment[2]."));
    assert_eq!(next.fragment.len(), 1);
    let duration = told["from_exit"]["flight_time"].as_f64().unwrap();
    let apart = fast.position - flying.position + (fast.velocity - flying.velocity) * duration;
    let found = Vector3::from(next.fragment[0].position) - Vector3::from(next.projectile.position);
    assert!((found - apart).norm() < 1e-12, "{found} for {apart}");
    assert!((next.fragment[0].position[2] - 2e-3).abs() < 1e-12, "the fragment touches the block");
    let (rigid, state) = free_body(&next, 0);
    assert!(rigid.depth(&state) < -0.01, "the projectile is above it");
    assert_eq!((next.projectile.position[0], next.projectile.position[1]), (0.0, 0.0));
}

#[test]
fn an_expanding_bullet_keeps_its_opening_and_its_name() {
    let folder = folder();
    let shot = ["new", "--projectile", "45acp-185-silvertip", "--block", "15x15x4cm"];
    let scene = scene::read(&gelfmu_in(folder.path(), &shot).out).unwrap();
    let flying = BodyKinematics {
        position: Vector3::new(0.0, 0.0, -0.06),
        velocity: Vector3::new(0.0, 0.0, -150.0),
        orientation: [1.0, 0.0, 0.0, 0.0],
        angular_velocity: Vector3::zeros(),
    };
    let opened = ShapeMotion::Expansion(ExpansionMotion::at_rest(0.6, 1e-3));
    let report = BodyReport { shape_motion: Some(opened), ..body(flying, Some(exit_of(&flying))) };
    write_run(&folder.path().join("run"), &scene, &[report]);
    let next = scene_of(&from_exit(folder.path(), &["--gap", "10cm"]));
    assert_eq!(next.projectile.library.as_deref(), Some("45acp-185-silvertip"));
    let (first, expansion) = (scene.projectile.expansion.unwrap(), next.projectile.expansion.unwrap());
    assert_eq!((expansion.opening, expansion.opened, expansion.path), (0.6, first.opened, first.path));
    let (rigid, state) = free_body(&next, 0);
    assert!(rigid.depth(&state).abs() < 1e-12 && next.scene.dimension == Dimension::Axisymmetric);
}

#[test]
fn a_half_model_stays_one_while_the_motion_is_in_its_plane() {
    for (spin, symmetry) in [([0.0, 700.0, 0.0], GelSymmetry::Half), ([0.0, 700.0, 9.0], GelSymmetry::None)] {
        let (folder, (scene, _)) = (folder(), rod());
        let flying = BodyKinematics {
            velocity: Vector3::new(3.0, 0.0, -150.0),
            position: Vector3::new(1e-3, 0.0, -0.064),
            orientation: [0.8, 0.0, 0.6, 0.0],
            angular_velocity: spin.into(),
        };
        write_run(&folder.path().join("run"), &scene, &[body(flying, Some(exit_of(&flying)))]);
        let next = scene_of(&from_exit(folder.path(), &["--gap", "1m"]));
        assert_eq!((next.scene.dimension, next.gel.symmetry), (Dimension::Spatial, symmetry));
    }
}

#[test]
fn a_run_without_an_exit_and_options_that_the_run_answers_are_refused() {
    let (folder, (scene, flying)) = (folder(), rod());
    let told = |said: Said| {
        assert_eq!(said.status, Some(2), "{}", said.err);
        json(&said.out)["error"].as_str().unwrap().to_owned()
    };
    let error = told(called(folder.path(), &[]));
    assert!(error.contains("--from-exit run: found no scene.toml, expected a folder that gelfmu run"), "{error}");
    write_run(&folder.path().join("run"), &scene, &[body(flying, None)]);
    let error = told(called(folder.path(), &[]));
    assert!(
        error.contains("--from-exit run: run/summary.json: found a projectile that has not left the gel"),
        "{error}"
    );
    assert!(error.contains("expected a run whose projectile leaves through the back face: a shorter block"), "{error}");
    fs::remove_file(folder.path().join("run/summary.json")).unwrap();
    let error = told(called(folder.path(), &[]));
    assert!(error.contains("--from-exit run: cannot read run/summary.json"), "{error}");
    assert!(error.ends_with("expected the folder of a finished run"), "{error}");
    for (option, value, what) in [
        ("--projectile", "bb", "projectile"),
        ("--speed", "100", "speed"),
        ("--yaw", "2", "attitude"),
        ("--roll", "0", "attitude"),
    ] {
        let message = format!("{option}: the run of --from-exit gives the {what}; leave {option} or --from-exit out");
        refused(&["new", "--from-exit", "run", option, value], &message);
    }
    refused(&["new", "--from-exit", "run", "--gap", "1 km"], "--gap 1000 m: expected at most 100 m of air");
    assert_eq!(gelfmu_in(folder.path(), &["new", "--projectile", "bb", "--gap", "1m"]).status, Some(2));
    assert_eq!(gelfmu_in(folder.path(), &["new", "--out", "a.toml"]).status, Some(2));
}
