//! `gelfmu calibrate` as a user meets it: a fitted strength, what is refused, and how it is interrupted.

#![cfg(feature = "cli")]

use serde_json::Value;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// A slow BB into a small block of coarse cells, with a slower wave and more damping than the scene has: a run takes a second.
const SMALL: [&str; 22] = [
    "calibrate",
    "--threads=1",
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
    "scene.end_time=3e-3",
    "--set",
    "gel.shear_modulus=0.08e6",
    "--set",
    "gel.branches=[{ shear_modulus = 4.8e6, power_law = { stress = 600.0, exponent = 0.8 } }]",
    "--set",
    "gel.cavity=vented",
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

/// Rest depths on cells of a quarter of the radius scatter by 2 % with the last digits of the strength: a fit to 0.1 % is luck.
#[test]
fn the_strength_that_is_printed_rests_the_bb_at_the_depth() {
    let fit = |more: &[&str]| {
        let output = small(&[&["--speed", "60", "--depth", "0.0199", "--tolerance", "1%", "--json"], more].concat());
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((output.status.code(), &value["status"]), (Some(0), &Value::from("fitted")), "{value:#}");
        (value, crate::lines::joined(&text(&output.stderr)))
    };
    let (value, told) = fit(&[]);
    let depth = value["reached_depth"].as_f64().unwrap();
    assert!((depth / 0.0199 - 1.0).abs() <= 1e-2, "{depth}");
    let trials = value["trials"].as_array().unwrap();
    assert_eq!(told.matches(": strength scale ").count(), trials.len(), "{told}");
    assert!(told.contains(" mm deep after "), "{told}");
    let lines = value["lines"].as_str().unwrap();
    let scene: toml::Table = toml::from_str(lines).unwrap();
    assert_eq!(scene["gel"]["strength_scale"].as_float(), value["strength_scale"].as_f64());
    assert_eq!(scene["projectile"]["velocity"][2].as_float(), Some(-60.0));
    let again = format!("gel.strength_scale={}", value["strength_scale"]);
    let (again, _) = fit(&["--set", &again]);
    assert_eq!(again["trials"].as_array().map(Vec::len), Some(1), "the strength fits at once");
    assert_eq!(again["reached_depth"], value["reached_depth"], "to the bit");
}

#[test]
fn invalid_calibration_inputs_are_refused_with_the_value_found() {
    let cases: [(&[&str], &str); 12] = [
        (
            &["sphere-block"],
            "scene sphere-block: gel.material: found another one, expected \"two-network\", whose moduli",
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
        let told = crate::lines::joined(&text(&output.stderr));
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(message), "{arguments:?}: {told}");
    }
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
    assert_eq!(output.status.code(), Some(130), "{}", crate::lines::joined(&text(&output.stderr)));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&value["status"], &value["scene"]), (&Value::from("interrupted"), &Value::from("fbi-bb")));
    assert!(crate::lines::joined(&text(&output.stderr)).contains("error: interrupted"));
}
