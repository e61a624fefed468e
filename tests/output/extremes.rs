//! Numbers that no sensible run has: the tables stay small and free of what is no number, and the page is made all the same.

use super::page::page_of;
use super::stage::{frame, observation, scene};
use super::{folder, written};
use ballistic_gel::output::{DriverInterface, FinalState, RunRecorder};
use ballistic_gel::scene::LayerSpec;
use ballistic_gel::simulation::Observation;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The files of a run of these observations, of which the frame of each is the one of its time.
fn recorded(name: &str, seen: &[Observation]) -> PathBuf {
    let (mut scene, folder) = (scene("axisymmetric"), folder(name));
    scene.layer = ["skin", "fat"].map(layer).to_vec();
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).unwrap();
    for observation in seen {
        recorder.record_observation(observation, || frame(&scene, observation.time)).unwrap();
    }
    let last = seen.last().unwrap();
    let frame = frame(&scene, last.time);
    recorder.conclude(&FinalState { observation: last, frame: &frame, digest: 1, failure: None }).unwrap();
    folder
}

/// A layer of 15 mm, of the gel.
fn layer(name: &str) -> LayerSpec {
    toml::from_str(&format!("name = \"{name}\"\nthickness = 0.015\n")).unwrap()
}

/// Observations at the start of the run and after each tenth of it, the later ones at these depths, m.
fn at_depths(depths: &[f64]) -> Vec<Observation> {
    let scene = scene("axisymmetric");
    let mut seen = vec![observation(&scene, 0.0)];
    seen.extend((1..).zip(depths).map(|(i, depth)| {
        let mut seen = observation(&scene, 0.1 * f64::from(i) * scene.scene.end_time);
        seen.bodies[0].depth = *depth;
        seen
    }));
    seen
}

fn rows(folder: &Path, file: &str) -> usize {
    fs::read_to_string(folder.join(file)).unwrap().lines().count() - 1
}

#[test]
fn a_way_of_a_single_place_has_no_force() {
    let mut start = at_depths(&[]);
    start[0].bodies[0].depth = 0.04;
    let folder = recorded("single", &start);
    assert_eq!(written::defect(&folder), Ok(()));
    let shot = fs::read_to_string(folder.join("shot.csv")).unwrap();
    let cells: Vec<&str> = shot.lines().nth(1).unwrap().split(',').collect();
    assert_eq!((cells[0], cells[3]), ("4e-2", ""), "{shot}");
    assert!(page_of(&folder).contains("Force on the projectile by depth"));
}

#[test]
fn numbers_that_are_none_reach_no_file() {
    for (i, strange) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308].into_iter().enumerate() {
        let mut seen = at_depths(&[0.01, 0.02, 0.03, 0.04]);
        let body = &mut seen[2].bodies[0];
        (body.kinematics.velocity.z, body.kinematics.position.x, body.exchange.impulse.z) = (strange, strange, strange);
        seen[3].bodies[0].depth = strange;
        (seen[4].energy.elastic, seen[4].momentum_error, seen[4].cost.min_jacobian) = (strange, strange, strange);
        let folder = recorded(&format!("strange-{i}"), &seen);
        assert_eq!(written::defect(&folder), Ok(()), "{strange}");
        assert_eq!(rows(&folder, "history.csv"), 5);
    }
}

/// Gigabytes of millimetres, and a report that was never done.
#[test]
fn a_projectile_that_is_far_below_the_gel_leaves_small_tables() {
    let begun = Instant::now();
    for (i, depth) in [1e6, 1e15, 1e300].into_iter().enumerate() {
        let folder = recorded(&format!("far-{i}"), &at_depths(&[0.01, 0.03, depth, 2.0 * depth]));
        assert_eq!(written::defect(&folder), Ok(()), "{depth}");
        assert!(rows(&folder, "shot.csv") <= 2002 && rows(&folder, "cavity.csv") <= 2002 * 6);
        assert!(rows(&folder, "cracks.csv") <= 2000);
        assert_eq!(rows(&folder, "layers.csv"), 3);
        let summary: serde_json::Value =
            serde_json::from_slice(&fs::read(folder.join("summary.json")).unwrap()).unwrap();
        assert!(summary["energy_per_centimetre"].as_array().unwrap().len() <= 2000);
    }
    assert!(begun.elapsed().as_secs_f64() < 60.0, "{:?}", begun.elapsed());
}
