//! `gelfmu calibrate` as a user meets it: a fitted strength, what is refused, and how it is interrupted.

#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

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

/// Returns the path of a file of shots with these rows, in a folder that is removed after the test.
fn shot_file(rows: &[&str]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shots.csv");
    std::fs::write(&path, format!("name,speed,measure,value,band,set\n{}\n", rows.join("\n"))).unwrap();
    (folder, path.to_str().unwrap().to_owned())
}

/// Rest depths on cells of a quarter of the radius scatter by 2 % with the last digits of the strength: a fit to 0.1 % is luck.
#[test]
fn the_strength_that_is_printed_rests_the_bb_at_the_depth() {
    let fit = |more: &[&str]| {
        let output = small(&[&["--speed", "60", "--depth", "0.0199", "--tolerance", "1%", "--json"], more].concat());
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((output.status.code(), &value["status"]), (Some(0), &Value::from("fitted")), "{value:#}");
        (value, text(&output.stderr))
    };
    let (value, told) = fit(&[]);
    let depth = value["reached_depth"].as_f64().unwrap();
    assert!((depth / 0.0199 - 1.0).abs() <= 1e-2, "{depth}");
    let trials = value["trials"].as_array().unwrap();
    assert_eq!(
        told.lines().filter(|line| line.starts_with("run ") && line.contains(" after ")).count(),
        trials.len(),
        "{told}"
    );
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
fn a_fit_to_shots_prints_residuals_and_lines_that_give_the_computed_values() {
    let rows = ["bb,60,depth,0.0181,5e-3,", "wide,60,cavity,4.7e-3,1e-3,"];
    let (_folder, path) = shot_file(&rows);
    let run = |more: &[&str]| {
        let output = small(&[&["--shots", &path, "--fit", "stress", "--level", "standard", "--json"], more].concat());
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!((output.status.code(), &value["status"]), (Some(0), &Value::from("fitted")), "{value:#}");
        value
    };
    let value = run(&[]);
    let shots = value["shots"].as_array().unwrap();
    assert_eq!(shots.len(), 2, "{value:#}");
    for shot in shots {
        let number = |key: &str| shot[key].as_f64().unwrap();
        let residual = (number("computed") - number("value")) / number("band");
        assert!((residual - number("residual")).abs() < 1e-9, "{shot}");
    }
    let lines: toml::Table = toml::from_str(value["lines"].as_str().unwrap()).unwrap();
    let power_law = &lines["gel"]["branches"][0]["power_law"];
    assert_eq!(power_law["stress"].as_float(), value["values"]["stress"].as_f64());
    let again = run(&["--set", &format!("gel.branches={}", lines["gel"]["branches"])]);
    assert_eq!(again["shots"], value["shots"], "the lines give the computed values to the bit");
}

#[test]
fn the_sensitivity_of_a_depth_has_the_sign_of_its_parameter() {
    let output = small(&["--speed", "60", "--sensitivity", "stress,branches.shear_modulus", "--json"]);
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{value:#}");
    let rows = value["sensitivity"].as_array().unwrap();
    let parameters: Vec<&str> = rows.iter().map(|row| row["parameter"].as_str().unwrap()).collect();
    assert_eq!(parameters, ["stress", "branches.shear_modulus"]);
    for row in rows {
        let derivative = row["shots"][0]["derivative"].as_f64().unwrap();
        assert!((-0.03..-1e-4).contains(&derivative), "a stronger gel is not penetrated as deep: {row}");
    }
}

#[test]
fn shots_that_cannot_be_fitted_are_refused_by_name_and_remedy() {
    let (_folder, path) =
        shot_file(&["bb,60,depth,0.018,0.2e-3,", "through,60,depth,0.01,1e-3,gel.shape.cylinder.height=0.01"]);
    let refused = |more: &[&str]| {
        let output = small(&[&["--shots", &path, "--level", "standard"], more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", text(&output.stderr));
        text(&output.stderr)
    };
    let few = refused(&[]);
    assert!(
        few.contains("found 2 shots, expected at least 3, as many as --fit stress,exponent,shear_modulus"),
        "{few}"
    );
    let through = refused(&["--fit", "stress"]);
    let message = "shots.csv: line 3: through: found a projectile of velocity [0.0, 0.0, -60.0] m/s that perforates the \
                   gel of 10 mm, expected one that comes to rest: give the scene a deeper gel.shape, or measure its cavity";
    assert!(through.contains(message), "{through}");
    let moving = refused(&["--fit", "stress", "--set", "scene.end_time=2e-5"]);
    assert!(moving.contains("line 2: bb: found a projectile") && moving.contains("still moves at"), "{moving}");
    assert!(moving.contains("give the scene a longer scene.end_time"), "{moving}");
    let (_other, strong) = shot_file(&["strong,60,depth,0.018,0.2e-3,gel.strength_scale=6"]);
    let thrown = text(&small(&["--shots", &strong, "--level", "standard", "--fit", "stress"]).stderr);
    assert!(thrown.contains("line 2: strong: found a projectile") && thrown.contains("is thrown back"), "{thrown}");
    let fixed = refused(&["--fit", "delay"]);
    assert!(fixed.contains("--fit: found delay, expected any of stress, rate, exponent, shear_modulus"), "{fixed}");
}

#[test]
fn what_cannot_be_calibrated_is_refused_with_what_was_found() {
    let cases: [(&[&str], &str); 14] = [
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
        (&["--shots", "nowhere.csv"], "--shots nowhere.csv: found no readable file"),
        (&["--shots", "gelatin-10", "--depth", "0.08"], "cannot be used with"),
        (&["nowhere.toml"], "scene nowhere.toml: found neither a built-in scene nor a readable file"),
    ];
    for (arguments, message) in cases {
        let output = gelfmu(&[&["calibrate"], arguments].concat());
        let told = text(&output.stderr);
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
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&value["status"], &value["scene"]), (&Value::from("interrupted"), &Value::from("fbi-bb")));
    assert!(text(&output.stderr).contains("error: interrupted"));
}
