//! `gelfmu calibrate` as a user meets it: a fitted strength, what is refused, and how it is interrupted.

#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use serde_json::Value;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// A slow BB into a small block of coarse cells, with a slower wave and more damping than the scene has: a run takes a second, and depths
/// scatter by less than the search asks for. The confinement is carried along and changes no bit.
const SMALL: [&str; 18] = [
    "calibrate",
    "--threads=1",
    "--speed",
    "60",
    "--set",
    "mesh.size=0.54e-3",
    "--set",
    "remesh.smallest=0.27e-3",
    "--set",
    "gel.shape.cylinder.height=0.04",
    "--set",
    "gel.shape.cylinder.radius=0.03",
    "--set",
    "gel.bulk_modulus=370.8e6",
    "--set",
    "gel.viscosity.linear=0.1",
    "--set",
    "gel.strength={ yield_stress = 66.5e3, reference_rate = 500.0, rate_exponent = 0.95, cap = 4.2e6, confined = { pressure = 1e9, factor = 1.0, time = 1e-6 } }",
];

fn gelfmu(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gelfmu")).args(arguments).output().unwrap()
}

fn small(more: &[&str]) -> Output {
    gelfmu(&[&SMALL, more].concat())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[test]
fn the_strength_that_is_printed_stops_the_bb_at_the_depth() {
    let output = small(&["--depth", "0.015", "--json"]);
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((output.status.code(), &value["status"]), (Some(0), &Value::from("fitted")), "{value:#}");
    let depth = value["reached_depth"].as_f64().unwrap();
    assert!((depth / 0.015 - 1.0).abs() <= 1e-3, "{depth}");
    let trials = value["trials"].as_array().unwrap();
    let told = text(&output.stderr);
    assert_eq!(told.lines().filter(|line| line.starts_with("run ")).count(), trials.len(), "{told}");
    let lines = value["lines"].as_str().unwrap();
    let scene: toml::Table = toml::from_str(lines).unwrap();
    let strength = &scene["gel"]["strength"];
    assert_eq!(strength["yield_stress"].as_float(), value["yield_stress"].as_f64());
    assert_eq!(strength["confined"]["factor"].as_float(), Some(1.0), "{lines}");
    assert_eq!(strength["confined"]["time"].as_float(), Some(1e-6), "{lines}");
    assert_eq!(scene["projectile"]["velocity"][2].as_float(), Some(-60.0));
    let again = format!("gel.strength.yield_stress={}", value["yield_stress"]);
    let again = small(&["--depth", "0.015", "--json", "--set", &again]);
    let again: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(again["trials"].as_array().map(Vec::len), Some(1), "the strength fits at once");
    assert_eq!(again["reached_depth"], value["reached_depth"], "to the bit");
}

#[test]
fn what_cannot_be_calibrated_is_refused_with_what_was_found() {
    let cases: [(&[&str], &str); 12] = [
        (
            &["sphere-block"],
            "scene sphere-block: gel.strength: found none, expected gel.material = \"flowing\" with the strength to begin with",
        ),
        (&["--depth", "0"], "expected a positive length, m"),
        (&["--depth", "deep"], "expected a positive length, m"),
        (&["--depth", "nan"], "expected a positive length, m"),
        (&["--speed", "0"], "expected a positive speed, m/s"),
        (
            &["--depth", "85"],
            "--depth: found 85.0 m, expected less than the depth of the gel, 0.15 m; were millimetres meant? They are 0.085 m",
        ),
        (&["--depth", "650"], "the depth of the gel, 0.15 m; were millimetres meant? They are 0.65 m"),
        (&["--depth", "1e300"], "--depth: found 1e300 m, expected less than the depth of the gel, 0.15 m\n"),
        (
            &["--speed", "180000"],
            "--speed: found 180000.0 m/s, expected at most 5000.0 m/s; were mm/s meant? They are 180 m/s",
        ),
        (&["--depth", "0.2"], "--depth: found 0.2 m, expected less than the depth of the gel, 0.15 m"),
        (&["--set", "projectile.velocity=[0, 0, 1]"], "found [0.0, 0.0, 1.0], expected a projectile that runs"),
        (&["nowhere.toml"], "scene nowhere.toml: found neither a built-in scene nor a readable file"),
    ];
    for (arguments, message) in cases {
        let output = gelfmu(&[&["calibrate"], arguments].concat());
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(message), "{arguments:?}: {told}");
    }
}

#[test]
fn a_depth_that_no_strength_gives_is_refused_with_the_one_that_the_strongest_gives() {
    let output = small(&["--depth", "0.001"]);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(
        told.contains("--depth: found 0.001 m, less than that with the greatest strength, its cap (4.2000e6 Pa"),
        "{told}"
    );
}

#[cfg(unix)]
#[test]
fn an_interrupted_calibration_keeps_its_best() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(["calibrate", "--json", "--threads=1"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&value["status"], &value["scene"]), (&Value::from("interrupted"), &Value::from("fbi-bb")));
    assert!(text(&output.stderr).contains("error: interrupted"));
}
