//! Shots with a bullet of the library that expands.

use super::{folder, gelfmu_in, json};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Runs a command that must succeed, and returns its result as JSON.
fn result(folder: &Path, arguments: &[&str]) -> Value {
    let said = gelfmu_in(folder, arguments);
    assert_eq!(said.status, Some(0), "{arguments:?}: {}", said.err);
    json(&said.out)
}

/// Runs the first 0.1 ms of a shot at `draft`, and returns the summary.
fn run(folder: &Path, scene: &str, out: &str, more: &[&str]) -> Value {
    let options = ["run", scene, "--fidelity", "draft", "--set", "scene.end_time=1e-4", "--out", out, "--json"];
    result(folder, &[&options, more].concat())
}

/// Last value of a column of the history of a run.
fn last(folder: &Path, out: &str, column: &str) -> f64 {
    let text = fs::read_to_string(folder.join(out).join("history.csv")).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|name| name == column).unwrap();
    lines.last().unwrap().split(',').nth(at).unwrap().parse().unwrap()
}

#[test]
fn a_load_of_the_library_opens_with_the_same_bits_as_an_fmu_and_is_told_by_name() {
    let place = folder();
    let folder = place.path();
    let shot = ["new", "--projectile", "45acp-230-xtp", "--block", "10x10x10cm", "--out", "shot.toml", "--json"];
    result(folder, &shot);
    let summary = run(folder, "shot.toml", "direct", &["--direct"]);
    let opening = summary["expansion"].as_f64().unwrap();
    assert!((0.5..1.0).contains(&opening), "{opening}");
    let diameter = summary["expanded_diameter"].as_f64().unwrap();
    assert!((0.0115..0.0183).contains(&diameter), "{diameter}");
    let part = summary["energy"]["expansion"].as_f64().unwrap() / summary["energy_deposited"].as_f64().unwrap();
    assert!((summary["expansion_work_fraction"].as_f64().unwrap() / part - 1.0).abs() < 1e-12);
    assert_eq!(last(folder, "direct", "expansion"), opening);
    assert_eq!(last(folder, "direct", "energy_expansion_J"), summary["energy"]["expansion"].as_f64().unwrap());
    let page = fs::read_to_string(folder.join("direct/report.html")).unwrap();
    assert!(page.contains("It opens to "), "the report tells the opening");
    let through_fmu = run(folder, "shot.toml", "fmu", &["--no-report"]);
    assert_eq!(through_fmu["digest"], summary["digest"]);
}

#[test]
fn a_load_below_its_threshold_stays_closed_and_the_report_says_so() {
    let place = folder();
    let folder = place.path();
    let shot = ["new", "--projectile", "9mm-115-jhp", "--speed", "150", "--block", "10x10x10cm", "--out", "shot.toml"];
    result(folder, &[&shot[..], &["--json"]].concat());
    let summary = run(folder, "shot.toml", "direct", &["--direct"]);
    assert_eq!((summary["expansion"].as_f64(), summary["energy"]["expansion"].as_f64()), (Some(0.0), Some(0.0)));
    let page = fs::read_to_string(folder.join("direct/report.html")).unwrap();
    assert!(page.contains("It does not open."));
}
