//! The files of an instance: where they are, how they follow it, and what is said when they cannot be written.

use super::host::{ERROR, Host, OK, WARNING, coarse};
use ballistic_gel::fmi2::abi::*;
use std::path::Path;

/// An instance that writes to its own folder, started.
fn writing() -> (Host, std::path::PathBuf) {
    let mut host = Host::with(&coarse());
    let (folder, own) = (host.path(""), host.path("gel"));
    assert_eq!(host.set_text("output_directory", &folder), OK);
    host.start();
    (host, own)
}

fn rows(folder: &Path) -> usize {
    let text = std::fs::read_to_string(folder.join("history.csv")).unwrap();
    text.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())).count()
}

fn summary(folder: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// Puts a folder where the summary is to be written.
fn block(folder: &Path) {
    std::fs::create_dir(folder.join("summary.json")).unwrap();
}

/// Goes to a state and frees it.
fn go_to(host: &Host, mut state: *mut std::ffi::c_void) -> i32 {
    let status = unsafe { fmi2SetFMUstate(host.c, state) };
    assert_eq!(unsafe { fmi2FreeFMUstate(host.c, &raw mut state) }, OK);
    status
}

#[test]
fn the_files_of_an_instance_are_in_a_folder_of_its_name() {
    let (mut host, folder) = writing();
    host.steps(0.0, 1e-4, 4);
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK, "{:?}", host.lines());
    for file in ["scene.toml", "summary.json", "history.csv", "report.html", "series.pvd"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
    assert_eq!(rows(&folder), 5);
}

#[test]
fn freeing_an_instance_completes_its_files() {
    let mut host = Host::with(&coarse());
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(host.set_text("output_directory", folder.path()), OK);
    host.start();
    host.steps(0.0, 1e-4, 1);
    assert!(!folder.path().join("gel/summary.json").exists());
    drop(host);
    assert!(folder.path().join("gel/summary.json").is_file());
}

#[test]
fn files_that_cannot_be_written_any_more_are_given_up_with_one_warning() {
    let (mut host, folder) = writing();
    let frames = folder.join("frames");
    std::fs::remove_dir_all(&frames).unwrap();
    std::fs::write(&frames, "in the way").unwrap();
    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1e-3, 0) }, WARNING, "{:?}", host.lines());
    assert!(host.one_line().contains("output_directory"));
    host.steps(1e-3, 1e-4, 2);
    assert!(host.lines().is_empty());
}

#[test]
fn going_back_truncates_the_files() {
    let (mut host, folder) = writing();
    host.steps(0.0, 1e-4, 2);
    let state = host.state();
    host.steps(2e-4, 1e-4, 5);
    assert_eq!(go_to(&host, state), OK, "{:?}", host.lines());
    host.steps(2e-4, 1e-4, 1);
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
    assert_eq!(rows(&folder), 4);
}

#[test]
fn terminating_and_resetting_are_done_also_when_the_files_cannot_be_completed() {
    for end in [fmi2Terminate, fmi2Reset] {
        let (mut host, folder) = writing();
        host.steps(0.0, 1e-4, 1);
        block(&folder);
        assert_eq!(unsafe { end(host.c) }, WARNING);
        let text = host.one_line();
        assert!(text.starts_with("output_directory: cannot write ") && text.contains("summary.json"), "{text}");
        assert_eq!(text.matches("move the file away").count(), 1, "{text}");
        assert_eq!(unsafe { fmi2Reset(host.c) }, OK, "what was given up is not tried again: {:?}", host.lines());
        host.start();
    }
}

#[test]
fn a_state_is_restored_also_when_the_files_cannot_follow() {
    let (mut host, folder) = writing();
    let state = host.state();
    let bits = host.bits();
    host.steps(0.0, 1e-3, 1);
    std::fs::remove_dir_all(&folder).unwrap();
    std::fs::write(&folder, "in the way").unwrap();
    assert_eq!(go_to(&host, state), WARNING);
    assert!(host.one_line().contains("output_directory"));
    assert_eq!(host.bits(), bits);
    let again = host.state();
    assert_eq!(go_to(&host, again), OK, "what was given up stays so: {:?}", host.lines());
    host.steps(0.0, 1e-4, 1);
}

#[test]
fn a_run_is_completed_when_a_state_from_before_it_is_restored() {
    let mut host = Host::with(&coarse());
    let (folder, own) = (host.path(""), host.path("gel"));
    assert_eq!(host.set_text("output_directory", &folder), OK);
    let made = host.state();
    host.enter();
    let initialized = host.state();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, OK);
    host.steps(0.0, 1e-4, 2);
    assert_eq!(go_to(&host, initialized), OK, "{:?}", host.lines());
    assert_eq!((rows(&own), &summary(&own)["end_time"]), (3, &2e-4.into()));
    assert!(own.join("report.html").is_file());
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, OK, "{:?}", host.lines());
    assert_eq!(rows(&own), 1);
    host.steps(0.0, 1e-4, 1);
    assert_eq!(go_to(&host, made), OK, "{:?}", host.lines());
    assert_eq!((rows(&own), &summary(&own)["end_time"]), (2, &1e-4.into()));
}

#[test]
fn two_instances_do_not_write_into_one_folder() {
    let (one, own) = writing();
    let mut two = Host::with(&coarse());
    assert_eq!(two.set_text("output_directory", own.parent().unwrap()), OK);
    two.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(two.c) }, ERROR);
    let text = two.one_line();
    assert!(text.contains("another run is writing there") && text.contains("output_directory"), "{text}");
    assert_eq!(rows(&own), 1);
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(two.set_text("output_directory", folder.path()), OK);
    assert_eq!(unsafe { fmi2ExitInitializationMode(two.c) }, OK, "{:?}", two.lines());
    drop(one);
}

#[test]
fn an_instance_whose_method_loses_energy_says_so_when_it_ends() {
    let coarse = ballistic_gel::scene::builtin("ball-square").unwrap().replace("size = 1.25e-3", "size = 5e-3");
    let mut host = Host::with(&(coarse + "\n[remesh]\nmethod = \"immersed\"\nquality = 0.3\ngrowth = 1.0\n"));
    let (folder, own) = (host.path(""), host.path("gel"));
    assert_eq!(host.set_text("output_directory", &folder), OK);
    host.start();
    host.steps(0.0, 1e-4, 40);
    assert!(host.lines().is_empty());
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
    // A line of log is a format of C.
    let lines: Vec<String> = host.lines().into_iter().map(|(_, _, text)| text.replace("%%", "%")).collect();
    assert!(lines.len() == 2 && lines[1].contains("beyond 3 radii"), "{lines:?}");
    let told = &lines[0];
    let share =
        told.strip_prefix("the numerical method has changed the energy by ").and_then(|rest| rest.split_once(" %"));
    let percent: f64 = share.and_then(|(percent, _)| percent.parse().ok()).unwrap_or_else(|| panic!("{told}"));
    assert!((10.0..20.0).contains(&percent), "{told}");
    assert_eq!(summary(&own)["doubt"], lines.join("; "));
    assert_eq!(summary(&own)["doubts"], serde_json::json!(lines));
}

/// An importer runs again and again: what an earlier run left is replaced, and nothing else.
#[test]
fn an_instance_takes_over_what_an_earlier_run_of_its_name_has_left() {
    let (mut host, folder) = writing();
    host.steps(0.0, 1e-4, 3);
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
    std::fs::write(folder.join("notes.txt"), "mine").unwrap();
    assert_eq!(unsafe { fmi2Reset(host.c) }, OK);
    assert_eq!(host.set_text("output_directory", folder.parent().unwrap()), OK);
    host.start();
    host.steps(0.0, 1e-4, 1);
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK, "{:?}", host.lines());
    assert_eq!((rows(&folder), std::fs::read_to_string(folder.join("notes.txt")).unwrap()), (2, "mine".to_owned()));
    let manifest = std::fs::read_to_string(folder.join("gelfmu.jsonl")).unwrap();
    assert!(manifest.ends_with("{\"state\":\"interrupted\"}\n"), "before the end of the scene: {manifest}");
}

#[test]
fn a_folder_of_the_user_is_refused_when_initialization_ends() {
    let mut host = Host::with(&coarse());
    let (folder, own) = (host.path(""), host.path("gel"));
    std::fs::create_dir(&own).unwrap();
    std::fs::write(own.join("summary.json"), "mine").unwrap();
    assert_eq!(host.set_text("output_directory", &folder), OK);
    host.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let text = host.one_line();
    assert!(text.starts_with("output_directory: cannot write into ") && text.contains("\"summary.json\""), "{text}");
    assert!(text.contains("remove this one yourself"), "{text}");
    assert_eq!(std::fs::read_to_string(own.join("summary.json")).unwrap(), "mine");
    std::fs::remove_file(own.join("summary.json")).unwrap();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, OK, "{:?}", host.lines());
}

/// The scene of an instance may be one that a run has kept, in the folder that is to be written.
#[test]
fn an_instance_does_not_write_over_the_scene_that_it_reads() {
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("gel/scene.toml");
    std::fs::create_dir(folder.path().join("gel")).unwrap();
    let list = "{\"results_of\":\"run\"}\n{\"file\":\"scene.toml\"}\n{\"state\":\"complete\"}\n";
    std::fs::write(folder.path().join("gel/gelfmu.jsonl"), list).unwrap();
    std::fs::write(&kept, coarse()).unwrap();
    let mut host = Host::with(&coarse());
    assert_eq!(host.set_text("output_directory", folder.path()), OK);
    assert_eq!(host.set_text("scene", &kept), OK);
    host.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    let text = host.one_line();
    assert!(text.contains("scene.toml, which is read, among the files that would be replaced"), "{text}");
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), coarse());
}

#[cfg(unix)]
#[test]
fn a_scene_without_end_is_refused_at_once() {
    for device in ["/dev/zero", "/dev"] {
        let mut host = Host::with(&coarse());
        assert_eq!(host.set_text("scene", Path::new(device)), OK);
        host.enter();
        assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
        let text = host.one_line();
        assert!(text.contains(device) && text.contains("the absolute path of a scene file"), "{text}");
    }
    let mut host = Host::with(&"\n".repeat(ballistic_gel::scene::MOST_BYTES + 1));
    host.enter();
    assert_eq!(unsafe { fmi2ExitInitializationMode(host.c) }, ERROR);
    assert!(host.one_line().contains("found 1048577 bytes, expected the text of a scene, of at most 1048576 bytes"));
}
