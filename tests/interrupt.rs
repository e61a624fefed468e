//! Requests to terminate, as a system sends them: one is enough.

#![cfg(all(unix, feature = "cli"))]
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

#[path = "command/lines.rs"]
mod lines;

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest time between a request to terminate and the end, s: five seconds, and some for a machine that is busy.
const LONGEST: f64 = 20.0;

fn started(folder: &Path, more: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(["run", "sphere-block", "--direct", "--threads", "1", "--out", "out"]).args(more);
    command.current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for the first row of the history.
fn has_begun(folder: &Path, child: &mut Child) {
    let rows = || std::fs::read_to_string(folder.join("out/history.csv")).unwrap_or_default().lines().count();
    while rows() < 2 {
        assert_eq!(child.try_wait().unwrap(), None, "the run ended before its first row");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Sends a signal and waits for the end.
fn ended(child: Child, signal: &str) -> (Output, f64) {
    let begun = Instant::now();
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    (output, begun.elapsed().as_secs_f64())
}

#[test]
fn one_request_to_terminate_ends_a_run_after_its_step_and_keeps_what_was_computed() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = started(folder.path(), &["--set", "mesh.size=10e-3", "--set", "scene.end_time=1.0"]);
    has_begun(folder.path(), &mut child);
    let (output, seconds) = ended(child, "-TERM");
    let said = lines::joined(&String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(seconds < LONGEST && said.contains("asked to terminate"), "{seconds} s: {said}");
    let summary = std::fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
    assert!(summary.contains("\"completed\": false"), "{summary}");
}

/// A step of minutes: it used to take a second request.
#[test]
fn one_request_to_terminate_ends_a_long_step_in_a_bounded_time_and_keeps_the_rows() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = started(folder.path(), &["--set", "mesh.size=2e-3", "--step", "1"]);
    has_begun(folder.path(), &mut child);
    let (output, seconds) = ended(child, "-TERM");
    let said = lines::joined(&String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(seconds < LONGEST, "{seconds} s: {said}");
    let history = std::fs::read_to_string(folder.path().join("out/history.csv")).unwrap();
    assert!(history.lines().count() == 2 && history.ends_with('\n'), "{history}");
}

/// Before there is anything to keep, while a large mesh is built.
#[test]
fn one_request_to_terminate_ends_a_run_that_has_not_begun() {
    let folder = tempfile::tempdir().unwrap();
    let child = started(folder.path(), &["--set", "mesh.size=2.5e-3"]);
    while !folder.path().join("out/scene.toml").exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    // The scene is kept just before the command listens.
    std::thread::sleep(Duration::from_millis(300));
    let (output, seconds) = ended(child, "-TERM");
    let said = lines::joined(&String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(seconds < LONGEST, "{seconds} s: {said}");
}
