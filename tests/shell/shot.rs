//! What a run leaves of a shot: tables by depth, the cavity, and their figures, from a motion and a cavity in closed form.

use crate::page;
use crate::stage;
use ballistic_gel::math::Vector3;
use ballistic_gel::output::{DriverInterface, FinalState, RunRecorder};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{ExitReport, FrameCells, MeshFrame, Observation};
use page::page_of;
use std::fs;
use std::path::{Path, PathBuf};

pub const SPEED: f64 = 5.0;
/// Deceleration, m/s²: 30 mm and 1 m/s after 10 ms.
pub const SLOWING: f64 = 400.0;
pub const STEPS: usize = 50;
pub const END: f64 = 0.01;
pub const MASS: f64 = 0.033;
/// Radius of the ball, m.
const BALL: f64 = 0.002;

pub fn scene() -> Scene {
    stage::scene_of_ball("axisymmetric", BALL)
}

pub fn depth(t: f64) -> f64 {
    SPEED * t - 0.5 * SLOWING * t * t
}

/// Radius of the cavity, m: 10 mm after 8 ms, 8.5 mm at the end.
fn radius(t: f64) -> f64 {
    0.010 - 0.0075 * (t / END - 0.8).abs()
}

/// The ball slows down evenly, `part` of the way.
fn observation(scene: &Scene, t: f64, part: f64) -> Observation {
    let mut seen = stage::observation(scene, t);
    let (step, body) = (scene.scene.communication_step, &mut seen.bodies[0]);
    body.depth = part * depth(t);
    body.kinematics.position.z = BALL - body.depth;
    body.kinematics.velocity = Vector3::new(0.0, 0.0, -part * (SPEED - SLOWING * t));
    body.exchange.impulse =
        if t > 0.0 { Vector3::new(0.0, 0.0, part * MASS * SLOWING * step) } else { Vector3::zeros() };
    seen
}

/// A cylinder with a bore as deep as the ball; the gel beside the bore is half damaged.
fn frame(scene: &Scene, t: f64, part: f64) -> MeshFrame {
    let (a, d) = (radius(t), (part * depth(t)).max(1e-6));
    let points = [(a, 0.0), (0.05, 0.0), (0.05, -d), (0.05, -0.05), (0.0, -0.05), (0.0, -d), (a, -d)];
    let points: Vec<Vector3> = points.iter().map(|(x, z)| Vector3::new(*x, 0.0, *z)).collect();
    let nodes = vec![[6, 2, 1, 0], [6, 1, 0, 0], [5, 4, 6, 0], [4, 3, 6, 0], [3, 2, 6, 0]];
    let facets = (0..7).map(|i| [(i + 1) % 7, i, 0]).collect();
    let rest = vec![Vector3::zeros(); 7];
    let mut bodies = stage::frame(scene, t).bodies;
    bodies[0].kinematics = observation(scene, t, part).bodies[0].kinematics;
    let cells = FrameCells {
        nodes,
        step: vec![1e-6; 5],
        jacobian: vec![1.0; 5],
        energy_density: vec![0.0; 5],
        damage: vec![0.5, 0.5, 0.0, 0.0, 0.0],
        facets,
    };
    let (velocities, displacements, fields) = (rest.clone(), rest, vec![]);
    let frame = stage::frame(scene, t);
    MeshFrame { mass: 1.0, points, velocities, displacements, cells, fields, bodies, ..frame }
}

pub fn record(recorder: &mut RunRecorder, scene: &Scene, steps: std::ops::RangeInclusive<usize>, part: f64) {
    for step in steps {
        let t = END * step as f64 / STEPS as f64;
        recorder.record_observation(&observation(scene, t, part), || frame(scene, t, part)).unwrap();
    }
}

pub fn conclude(recorder: &mut RunRecorder, scene: &Scene, part: f64) {
    let (o, f) = (observation(scene, END, part), frame(scene, END, part));
    recorder.conclude(&FinalState { observation: &o, frame: &f, digest: 1, failure: None }).unwrap();
}

/// A new folder: an earlier run of the tests may have left one.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shot").join(name);
    drop(fs::remove_dir_all(&folder));
    folder
}

fn run(name: &str, part: f64) -> PathBuf {
    let (scene, folder) = (scene(), folder(name));
    drop(fs::remove_dir_all(&folder));
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    record(&mut recorder, &scene, 0..=STEPS, part);
    conclude(&mut recorder, &scene, part);
    folder
}

/// The rows of a table of numbers, and its head.
fn table(file: &Path) -> (String, Vec<Vec<f64>>) {
    let text = fs::read_to_string(file).unwrap();
    let numbers = |line: &str| line.split(',').map(|value| value.parse().unwrap()).collect();
    (text.lines().next().unwrap().to_owned(), text.lines().skip(1).map(numbers).collect())
}

pub fn summary(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn speed_force_and_energy_stand_by_depth() {
    let (head, rows) = table(&run("track", 1.0).join("shot.csv"));
    assert_eq!(head, "depth_m,time_s,velocity_m_per_s,force_N,energy_J,yaw_rad,side_force_N,expansion");
    assert_eq!((rows.len(), rows[30][0]), (31, depth(END)), "every millimetre");
    for row in &rows {
        let [x, t, v, force, energy, yaw, side_force, expansion] = row[..] else { panic!("eight columns") };
        let speed = (SPEED * SPEED - 2.0 * SLOWING * x).sqrt();
        assert!((v / speed - 1.0).abs() < 1e-9, "{x}: {v}, {speed}");
        assert!((t - (SPEED - speed) / SLOWING).abs() < 1e-5, "{x}: {t}");
        assert!((force / (MASS * SLOWING) - 1.0).abs() < 1e-9, "{x}: {force}");
        assert!((energy - MASS * SLOWING * x).abs() < 1e-12, "{x}: {energy}");
        assert_eq!((yaw, side_force, expansion), (0.0, 0.0, 0.0), "nose first, and rigid");
    }
}

#[test]
fn a_projectile_that_has_just_turned_back_keeps_its_yaw_on_the_way_in() {
    let scene = scene();
    let folder = folder("turned");
    drop(fs::remove_dir_all(&folder));
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    record(&mut recorder, &scene, 0..=STEPS - 1, 1.0);
    // Deeper than a step before, and on its way out.
    let mut last = observation(&scene, END, 1.0);
    last.bodies[0].kinematics.velocity *= -1.0;
    recorder.record_observation(&last, || frame(&scene, END, 1.0)).unwrap();
    let frame = frame(&scene, END, 1.0);
    recorder.conclude(&FinalState { observation: &last, frame: &frame, digest: 1, failure: None }).unwrap();
    let (_, rows) = table(&folder.join("shot.csv"));
    let deepest = rows.last().unwrap();
    assert_eq!((deepest[0], deepest[5]), (depth(END), 0.0));
}

#[test]
fn energy_is_given_for_each_centimetre() {
    let summary = summary(&run("centimetres", 1.0));
    let energies: Vec<f64> =
        summary["energy_per_centimetre"].as_array().unwrap().iter().map(|energy| energy.as_f64().unwrap()).collect();
    assert_eq!(energies.len(), 3);
    assert!(energies.iter().all(|energy| (energy - MASS * SLOWING * 0.01).abs() < 1e-12), "{energies:?}");
}

#[test]
fn the_cavity_is_as_wide_as_the_bore() {
    let folder = run("cavity", 1.0);
    let (head, rows) = table(&folder.join("cavity.csv"));
    assert_eq!(head, "time_s,depth_m,radius_m,diameter_m");
    for row in &rows {
        assert!(row[1] <= depth(row[0]) - 2.0 * BALL + 1e-12, "{row:?} is filled by the ball");
        assert!((row[2] - radius(row[0])).abs() < 1e-15 && row[3] == 2.0 * row[2], "{row:?}");
    }
    let last = rows.iter().filter(|row| row[0] == END).count();
    assert!((25..=26).contains(&last), "{last} millimetres of 26 behind the ball at the end");
    let summary = summary(&folder);
    let figure = |key: &str| summary[key].as_f64().unwrap();
    assert!((figure("greatest_cavity_diameter") - 0.02).abs() < 1e-12);
    assert!((figure("time_of_greatest_cavity") - 0.8 * END).abs() < 1e-12);
    assert!((figure("final_cavity_diameter") - 0.017).abs() < 1e-12);
    assert_eq!(summary["cavity_still_opening"], false);
    assert!((2.0 * BALL..=2.0 * BALL + 0.0011).contains(&figure("depth_of_greatest_cavity")));
    let course = summary["cavity_course"].as_array().unwrap();
    for point in course {
        let [time, diameter] = ["time", "diameter"].map(|key| point[key].as_f64().unwrap());
        assert!(depth(time) > 4.0 * BALL && (diameter - 2.0 * radius(time)).abs() < 1e-12, "{point}");
    }
    let rows = course.len();
    assert!((41..=42).contains(&rows), "{rows} steps after which the rear is deeper than a diameter of the ball");
    for absent in ["time_of_cavity_collapse", "cavity_pulsation_diameter", "rest_depth", "time_of_rest"] {
        assert!(summary[absent].is_null(), "{absent}: {}", summary[absent]);
    }
}

#[test]
fn a_cavity_that_grows_until_the_end_is_marked_as_still_opening() {
    let (scene, folder, step) = (scene(), folder("opening"), 35);
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    record(&mut recorder, &scene, 0..=step, 1.0);
    let t = END * step as f64 / STEPS as f64;
    let (last, frame) = (observation(&scene, t, 1.0), frame(&scene, t, 1.0));
    // A projectile that rests ends a run, too.
    let last = Observation { is_over: true, ..last };
    recorder.conclude(&FinalState { observation: &last, frame: &frame, digest: 1, failure: None }).unwrap();
    let found = summary(&folder);
    assert_eq!((&found["ended_by"], &found["completed"]), (&"rest".into(), &true.into()));
    assert_eq!(found["cavity_still_opening"], true);
    let page = page_of(&folder);
    assert!(page.contains(" at the end, still opening</dd>"), "{page}");
}

#[test]
fn the_track_is_the_damaged_gel_as_a_circle() {
    let folder = run("damaged", 1.0);
    let (head, rows) = table(&folder.join("track.csv"));
    assert_eq!(head, "depth_m,track_diameter_m,energy_in_centimetre_J");
    let diameter = 2.0 * (0.5 * (0.05f64.powi(2) - radius(END).powi(2))).sqrt();
    for (i, row) in rows.iter().enumerate() {
        assert!((row[0] - (i as f64 + 0.5) * 1e-3).abs() < 1e-12 && (row[1] / diameter - 1.0).abs() < 1e-12, "{row:?}");
        assert!((row[2] - MASS * SLOWING * 0.01).abs() < 1e-12, "{row:?}");
    }
    assert_eq!(rows.len(), 30);
    assert!((summary(&folder)["greatest_track_diameter"].as_f64().unwrap() - diameter).abs() < 1e-12);
}

#[test]
fn cracks_are_estimated_in_each_centimetre_from_the_cavity_and_the_ball() {
    // 25.5 mm deep: the last slice is 5.5 mm thick.
    let (part, end) = (0.85, 0.85 * depth(END));
    let folder = run("cracks", part);
    let (head, rows) = table(&folder.join("cracks.csv"));
    assert_eq!(head, "depth_from_m,depth_to_m,cavity_diameter_m,tear_diameter_m,energy_J,crack_length_m");
    assert_eq!(rows.len(), 3);
    for (i, row) in rows.iter().enumerate() {
        let [from, to, cavity, tear, _, cracks] = row[..] else { panic!("six columns") };
        assert!(
            (from - 0.01 * i as f64).abs() < 1e-15 && (to - end.min(0.01 * (i + 1) as f64)).abs() < 1e-12,
            "{row:?}"
        );
        // The bore is 20 mm wide after 8 ms; the rear of the ball enters the last slice in the step that ends at 8.8 ms.
        let widest = 2.0 * radius(if i < 2 { 0.008 } else { 0.0088 });
        assert!((cavity - widest).abs() < 1e-12 && (tear - 2.0 * BALL).abs() < 1e-12, "{row:?}");
        assert!((cracks - std::f64::consts::PI * (widest - 2.0 * BALL)).abs() < 1e-12, "{row:?}");
    }
    let (_, track) = table(&folder.join("shot.csv"));
    let energy: f64 = rows.iter().map(|row| row[4]).sum();
    assert!((energy / track.last().unwrap()[4] - 1.0).abs() < 1e-12, "{energy} J");
    let page = page_of(&folder);
    assert_eq!([">50 mm<", ">46 mm<"].map(|label| page.matches(label).count()), [2, 1]);
    assert!(page.contains(">2–2.6 cm<") && page.contains("the simulation models no crack"));
}

#[test]
fn a_ball_that_stays_in_the_gel_has_a_rest_depth() {
    let (scene, folder, stop) = (scene(), folder("rest"), 0.004);
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    let seen = |t: f64| Observation { time: t, ..observation(&scene, t.min(stop), 1.0) };
    for step in 0..=STEPS {
        let t = END * step as f64 / STEPS as f64;
        recorder.record_observation(&seen(t), || frame(&scene, t.min(stop), 1.0)).unwrap();
    }
    let frame = frame(&scene, stop, 1.0);
    recorder.conclude(&FinalState { observation: &seen(END), frame: &frame, digest: 1, failure: None }).unwrap();
    let summary = summary(&folder);
    let figure = |key: &str| summary[key].as_f64().unwrap();
    assert!((figure("rest_depth") - depth(stop)).abs() < 1e-12 && (figure("time_of_rest") - stop).abs() < 1e-9);
    let page = page_of(&folder);
    assert!(page.contains("<dt>rest depth</dt><dd>16.8 mm from 4.00 ms</dd>"), "{page}");
}

#[test]
fn an_opening_ahead_of_the_projectile_is_not_part_of_the_cavity() {
    let (scene, folder) = (scene(), Path::new(env!("CARGO_TARGET_TMPDIR")).join("shot").join("ahead"));
    drop(fs::remove_dir_all(&folder));
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    // A bore half as deep again as the ball has come.
    let bored = |t: f64| MeshFrame { bodies: frame(&scene, t, 1.0).bodies, ..frame(&scene, t, 1.5) };
    for step in 0..=STEPS {
        let t = END * step as f64 / STEPS as f64;
        recorder.record_observation(&observation(&scene, t, 1.0), || bored(t)).unwrap();
    }
    let (last, frame) = (observation(&scene, END, 1.0), bored(END));
    recorder.conclude(&FinalState { observation: &last, frame: &frame, digest: 1, failure: None }).unwrap();
    let (_, rows) = table(&folder.join("cavity.csv"));
    let deepest = rows.iter().map(|row| row[1]).fold(0.0, f64::max);
    let rear = depth(END) - 2.0 * BALL;
    assert!(deepest > rear - 1.001e-3, "{deepest} m of {rear}");
    for row in &rows {
        assert!(row[1] <= depth(row[0]) - 2.0 * BALL + 1e-12, "{row:?} is filled by the ball");
    }
}

#[test]
fn the_tables_of_a_projectile_that_has_left_end_at_the_back_face() {
    let (scene, folder) = (scene(), Path::new(env!("CARGO_TARGET_TMPDIR")).join("shot").join("left"));
    let exit = ExitReport { time: 0.009, velocity: Vector3::new(0.0, 0.0, -3.0), residual_energy: 0.15 };
    // Twice as fast: 60 mm at the end, in a gel of 50 mm.
    let seen = |t: f64| {
        let mut seen = observation(&scene, t, 2.0);
        seen.bodies[0].contact.peak_depth = ((2.0 * depth(t)).min(0.05), t);
        seen.bodies[0].exit = (t > exit.time).then_some(exit);
        seen.is_over = t >= 0.0098;
        seen
    };
    drop(fs::remove_dir_all(&folder));
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    for step in 0..STEPS {
        let t = END * step as f64 / STEPS as f64;
        recorder.record_observation(&seen(t), || frame(&scene, t, 1.0)).unwrap();
    }
    let t = END * (STEPS - 1) as f64 / STEPS as f64;
    let (last, frame) = (seen(t), frame(&scene, t, 1.0));
    recorder.conclude(&FinalState { observation: &last, frame: &frame, digest: 1, failure: None }).unwrap();
    let (_, rows) = table(&folder.join("shot.csv"));
    assert_eq!(rows.last().unwrap()[0], 0.05);
    let found = summary(&folder);
    assert_eq!((found["final_depth"].as_f64(), found["peak_depth"].as_f64()), (Some(0.05), Some(0.05)));
    assert_eq!((found["ended_by"].as_str(), found["completed"].as_bool()), (Some("exit"), Some(true)));
    assert!(found["rebound_velocity"].is_null() && found["perforated"].as_bool() == Some(true), "{found}");
    let page = page_of(&folder);
    assert!(
        page.contains("has perforated the gel: it left the back face with <strong>3.00 m/s</strong> at 9.00 ms"),
        "{page}"
    );
    assert!(
        page.contains("<dt>exit</dt>")
            && !page.contains("<dt>rebound velocity</dt>")
            && !page.contains("stopped early")
    );
}

#[test]
fn a_ball_that_goes_less_deep_than_its_diameter_is_no_shot() {
    let folder = run("shallow", 0.1);
    for file in ["shot.csv", "cavity.csv", "track.csv", "cracks.csv"] {
        assert!(!folder.join(file).exists(), "{file}");
    }
    let (shallow, deep) = (summary(&folder), run("deep", 1.0));
    assert_eq!(shallow["greatest_cavity_diameter"], serde_json::Value::Null);
    assert_eq!(shallow["energy_per_centimetre"], serde_json::Value::Null);
    let page = page_of;
    assert!(!page(&folder).contains("Along the path") && page(&deep).contains("Along the path"));
    let titles = [
        "Speed of the projectile by depth",
        "Wound profile",
        "Slices of 1 cm with estimated cracks",
        "Diameter of cavity and permanent track by depth",
        "temporary cavity",
        "Energy given to the gel by time",
        "Diameter of the cavity by time",
    ];
    for title in titles {
        assert!(page(&deep).contains(title), "{title}");
    }
}

#[test]
fn rewinding_and_repeating_leaves_the_tables_of_a_straight_run() {
    let straight = run("straight", 1.0);
    let (scene, folder) = (scene(), straight.with_file_name("rewound"));
    drop(fs::remove_dir_all(&folder));
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    record(&mut recorder, &scene, 0..=37, 1.0);
    recorder.rewind(END * 12.0 / STEPS as f64).unwrap();
    record(&mut recorder, &scene, 13..=STEPS, 1.0);
    conclude(&mut recorder, &scene, 1.0);
    for file in ["shot.csv", "cavity.csv", "track.csv", "cracks.csv"] {
        assert_eq!(fs::read(folder.join(file)).unwrap(), fs::read(straight.join(file)).unwrap(), "{file}");
    }
}
