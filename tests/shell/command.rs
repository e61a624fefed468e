//! The command as a user meets it: exit status, messages, results.

#[path = "../command/check.rs"]
mod check;
#[path = "../command/expansion.rs"]
mod expansion;
#[path = "../command/from_exit.rs"]
mod from_exit;
#[path = "../command/shots.rs"]
mod shots;

use crate::lines::joined;
use ballistic_gel::output::{FolderClaim, RUN, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene;
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// What one call of the command gave.
struct Said {
    status: Option<i32>,
    out: String,
    err: String,
}

/// Calls the command in `folder`.
fn gelfmu_in(folder: &Path, arguments: &[&str]) -> Said {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    let output = command.args(arguments).current_dir(folder).env_remove("NO_COLOR").output();
    said(output.expect("the command starts"))
}

fn said(output: Output) -> Said {
    let text = |bytes| String::from_utf8(bytes).expect("the command prints UTF-8");
    Said { status: output.status.code(), out: text(output.stdout), err: joined(&text(output.stderr)) }
}

fn gelfmu(arguments: &[&str]) -> Said {
    gelfmu_in(folder().path(), arguments)
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder can be made")
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

/// The command refuses its input with exactly this message.
#[track_caller]
fn refused(arguments: &[&str], message: &str) {
    let said = gelfmu(arguments);
    assert_eq!(said.err, format!("error: {message}\n"));
    assert_eq!((said.status, said.out.as_str()), (Some(2), ""));
}

#[test]
fn scenes_prints_a_scene_that_can_be_kept_and_changed() {
    for (name, text) in scene::builtins() {
        assert_eq!(gelfmu(&["scenes", name]).out, text, "{name}");
    }
    assert_eq!(json(&gelfmu(&["scenes", "l-beam", "--json"]).out)["name"], "l-beam");
    let known: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    let known = known.join(", ");
    refused(&["scenes", "x"], &format!("scene x: found no built-in scene of this name, expected one of {known}"));
}

#[test]
fn a_bad_file_is_refused_with_key_and_line() {
    let folder = folder();
    let text = scene::builtin("ball-bounce").unwrap().replace("growth = 1.15", "growth = 0.9");
    let line = 1 + text.lines().position(|line| line.starts_with("grading")).unwrap();
    std::fs::write(folder.path().join("bad.toml"), text).unwrap();
    for command in ["check", "run"] {
        let said = gelfmu_in(folder.path(), &[command, "bad.toml"]);
        let place = format!("scene bad.toml: line {line}: mesh.grading.growth");
        assert_eq!(said.err, format!("error: {place}: found 0.9, expected a ratio above 1\n"));
        assert_eq!(said.status, Some(2), "{command}");
    }
}

#[test]
fn a_failure_is_json_too_where_json_is_wanted() {
    let said = gelfmu(&["run", "--set", "mesh.size=0", "--json"]);
    assert_eq!(said.status, Some(2));
    let error = "scene fbi-bb with --set mesh.size=0: mesh.size: found 0.0, expected a positive length, m";
    let parts = [("key", "mesh.size"), ("found", "0.0"), ("expected", "a positive length, m")];
    let told = json(&said.out);
    assert_eq!(told["error"], error);
    assert!(parts.iter().all(|(name, text)| told[name] == *text) && told["line"].is_null(), "{told}");
}

#[test]
fn a_command_line_that_makes_no_sense_is_json_too() {
    let said = gelfmu(&["run", "--speed", "3", "--json"]);
    assert_eq!(said.status, Some(2));
    let error = json(&said.out)["error"].as_str().unwrap().to_owned();
    assert!(error.starts_with("unexpected argument '--speed'") && said.err.contains(&error), "{error}");
    assert_eq!(gelfmu(&["run", "--speed", "3"]).out, "");
    assert!(gelfmu(&["--help", "--json"]).out.contains("Usage"));
}

#[test]
fn a_folder_that_cannot_be_used_is_bad_input() {
    let folder = folder();
    std::fs::write(folder.path().join("file"), "").unwrap();
    let colon: &[&str] = &["run", "--out", "a:b"];
    for (arguments, word) in [
        (colon, "or --direct"),
        (&["run", "--out", " "], "or --direct"),
        (&["run", "--out", ".."], "or --direct"),
        (&["run", "--out", "file/x"], "a folder that can be written"),
        (&["run", "--out", "file/x", "--direct"], "a folder that can be written"),
    ] {
        let said = gelfmu_in(folder.path(), arguments);
        assert_eq!(said.status, Some(2), "{arguments:?}: {}", said.err);
        let start = format!("error: --out {}: found ", arguments[2]);
        assert!(said.err.starts_with(&start) && said.err.contains(word), "{arguments:?}: {}", said.err);
    }
    let held = folder.path().join("held");
    let claim = FolderClaim { command: RUN, policy: TakeoverPolicy::Refuse, needs: &[], inputs: &[], is_of_fmu: false };
    let claim = ResultFolder::claim(&held, &claim).unwrap();
    let said = gelfmu_in(folder.path(), &["run", "--out", "held", "--direct"]);
    assert_eq!((said.status, said.err.contains("another run is writing there")), (Some(2), true), "{}", said.err);
    drop(claim);
}

#[test]
fn a_scene_that_does_not_exist_is_refused_with_the_names_that_do() {
    let said = gelfmu(&["check", "nowhere.toml"]);
    assert_eq!(said.status, Some(2));
    assert!(said.err.starts_with("error: scene nowhere.toml: found neither a built-in scene nor a readable file"));
    assert!(said.err.contains(
        "expected one of fbi-bb, fbi-bb-3d, sphere-720, bullet-yaw, hydro-drag, sphere-block, sphere-deep, ball-bounce, bounce-visco, backface-dent, cavity-exact, ball-square, l-beam, sphere-graded-4"
    ));
}

#[test]
fn an_override_at_fault_is_named_and_a_fault_of_the_file_keeps_its_line() {
    refused(
        &["run", "--set", "mesh.sizes=1"],
        "scene fbi-bb with --set mesh.sizes=1: mesh.sizes: found the unknown key `sizes` (did you mean `size`?), \
         expected one of `size`, `lattice`, `element`, `grading`, `tree`",
    );
    refused(
        &["run", "l-beam", "--set", "mesh.size=[1,"],
        "scene l-beam with --set mesh.size=[1,: mesh.size: found `[1,`, expected a TOML value, \
         such as 2e-3, [0, 0, -2], true or \"text\"",
    );
    let folder = folder();
    std::fs::write(folder.path().join("bad.toml"), "[scene]\nname = 3\n").unwrap();
    let said = gelfmu_in(folder.path(), &["run", "bad.toml", "--set", "mesh.size=1"]);
    assert_eq!(said.err, "error: scene bad.toml: line 2: scene.name: found 3, expected text in quotes\n");
}

#[test]
fn a_command_line_that_makes_no_sense_is_bad_input() {
    let cases: [(&[&str], &str); 14] = [
        (&["fly"], "unrecognized subcommand 'fly'"),
        (&["run", "--speed", "3"], "unexpected argument '--speed'"),
        (&["run", "--step", "0"], "expected a positive time, s"),
        (&["run", "--step", "nan"], "expected a positive time, s"),
        (&["run", "--set", "mesh.size"], "mesh.size: found no value, expected key=value, such as mesh.size=2e-3"),
        (&["run", "--threads", "-1"], "expected 0 for all cores, or a number of threads up to 1024"),
        (&["run", "--step", "-1e-6"], "expected a positive time, s"),
        (&["run", "--accuracy", "-1"], "expected a positive error in percent, such as 2%"),
        (&["calibrate", "--depth", "-0.08"], "expected a positive length, m"),
        (&["run", "--threads", "5000"], "expected 0 for all cores, or a number of threads up to 1024"),
        (&["bench", "--elements", "0"], "expected a number of elements from 7000 to 20000000"),
        (&["bench", "--elements", "many"], "expected a number of elements from 7000 to 20000000"),
        (&["bench", "--threads", "5000"], "expected 0 for all cores, or a number of threads up to 1024"),
        (&["run", "sphere-block", "--step", "1e-20"], "expected at most 1e9: a step of 1.000e-11 s or more"),
    ];
    for (arguments, message) in cases {
        let said = gelfmu(arguments);
        assert_eq!(said.status, Some(2), "{arguments:?}");
        assert!(said.err.contains(message), "{arguments:?}: {}", said.err);
    }
}

#[test]
fn a_mode_of_coupling_that_a_run_does_not_take_is_said() {
    let folder = folder();
    let said = small(folder.path(), &["--set", "coupling.mode=corrected"]);
    assert!(said.err.contains("coupling.mode of the scene is for importers of the packed FMU"), "{}", said.err);
}

#[test]
fn ports_for_more_fragments_than_the_scene_has_are_refused() {
    refused_pack(&["--fragments", "1"], "--fragments: found 1, expected ");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/conformance/fragments.toml");
    for named in [&["--scene", scene][..], &[scene]] {
        refused_pack(&[named, &["--fragments", "3"]].concat(), "--fragments: found 3, expected ");
    }
    refused_pack(&[scene, "--scene", "fbi-bb"], "the argument '[SCENE]' cannot be used with '--scene <SCENE>'");
}

#[test]
fn ports_for_more_sensors_than_the_scene_has_are_refused() {
    refused_pack(&["--sensors", "2"], "--sensors: found 2, expected at most the [[sensor]] tables of the scene, 0");
}

#[track_caller]
fn refused_pack(arguments: &[&str], message: &str) {
    let folder = folder();
    let said = gelfmu_in(folder.path(), &[&["pack"], arguments].concat());
    assert_eq!(said.status, Some(2), "{}", said.err);
    assert!(said.err.starts_with(&format!("error: {message}")), "{}", said.err);
    assert_eq!(std::fs::read_dir(folder.path()).expect("it is there").count(), 0, "nothing is written");
}

#[test]
fn a_platform_without_a_library_inside_is_refused() {
    refused_pack(&["sphere-block", "--platforms", "amiga"], "--platforms: found amiga, expected of ");
}

#[test]
fn a_folder_that_is_not_empty_is_refused_and_left_as_it_is() {
    let folder = folder();
    std::fs::write(folder.path().join("diary.txt"), "mine").unwrap();
    let said = gelfmu_in(folder.path(), &["run", "--out", "."]);
    let expected = "found a folder that is not empty and was not made by gelfmu (it has \"diary.txt\" and no gelfmu.jsonl), \
                    expected an empty or new folder";
    assert_eq!((said.status, said.err), (Some(2), format!("error: --out .: {expected}\n")));
    let said = gelfmu_in(folder.path(), &["run", "--out", "diary.txt"]);
    assert_eq!(said.status, Some(2));
    assert!(said.err.starts_with("error: --out diary.txt: found "), "{}", said.err);
    assert_eq!(std::fs::read_to_string(folder.path().join("diary.txt")).unwrap(), "mine");
}

/// All property names and alternatives of a JSON schema.
fn names(schema: &Value, found: &mut Vec<String>) {
    match schema {
        Value::Object(map) => {
            if let Some(Value::Object(properties)) = map.get("properties") {
                found.extend(properties.keys().cloned());
            }
            found.extend(map.get("const").and_then(Value::as_str).map(str::to_owned));
            map.values().for_each(|inner| names(inner, found));
        }
        Value::Array(list) => list.iter().for_each(|inner| names(inner, found)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

#[test]
fn schema_is_json_and_knows_every_key() {
    let mut found = Vec::new();
    names(&json(&gelfmu(&["schema"]).out), &mut found);
    let keys = "scene gel projectile mesh integrator contact output name title dimension end_time communication_step \
         planar axisymmetric spatial shape block cylinder l-beam size radius height leg thickness width angle corner \
         material neo-hookean density shear_modulus bulk_modulus supports x_min x_max y_min y_max z_min z_max side \
         free roller fixed velocity sphere capsule bullet nose ogive cone round flat arc_radius meplat_radius tail edge_radius \
         preset gelatin-10 gelatin-20 synthetic-clear mooney-rivlin constants c1 c2 ogden terms modulus exponent \
         half-space length normal mass inertia position orientation angular_velocity \
         lattice centred kuhn element plain patch grading core growth largest tree coarsest slope schedule bins queue cfl law moreau reversal restitution bias \
         load on within pressure ramp table low high inner outer bore shell damping frames force_window";
    for key in keys.split_whitespace() {
        assert!(found.iter().any(|name| name == key), "the schema does not know {key}");
    }
}

#[test]
fn the_schema_of_a_summary_has_every_key_of_a_run_and_the_unit_of_each_number() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    std::fs::write(folder.path().join("lab.csv"), "time_ms,depth_mm\n0,0\n0.05,2\n").unwrap();
    let (lab, out_text) = (folder.path().join("lab.csv"), out.to_str().unwrap());
    let run =
        ["run", "ball-square", "--direct", "--quiet", "--set=scene.end_time=1e-4", "--out", out_text, "--measured"];
    assert_eq!(gelfmu(&[&run[..], &[lab.to_str().unwrap()]].concat()).status, Some(0));
    let summary = json(&std::fs::read_to_string(out.join("summary.json")).unwrap());
    let schema = json(&gelfmu(&["schema", "summary"]).out);
    let known = schema["properties"].as_object().unwrap();
    for (key, value) in summary.as_object().unwrap() {
        assert!(known.contains_key(key), "the schema does not know {key}");
        let is_number = value.is_number() || value.as_array().is_some_and(|all| all.iter().any(Value::is_number));
        assert!(!is_number || key == "format" || known[key]["x-unit"].is_string(), "{key}");
    }
    assert!(summary["measured"].is_object());
    let accounts = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(accounts(&summary["energy"]), accounts(&known["energy"]["properties"]));
    assert_eq!(known["peak_force"]["x-unit"], "N");
}

/// Names of all keys of a TOML table.
fn keys(table: &toml::Table, found: &mut Vec<String>) {
    for (name, value) in table {
        found.push(name.clone());
        if let Some(inner) = value.as_table() {
            keys(inner, found);
        }
    }
}

#[test]
fn schema_knows_every_key_that_a_builtin_scene_uses() {
    let mut known = Vec::new();
    names(&scene::schema(), &mut known);
    for (scene, text) in scene::builtins() {
        let mut used = Vec::new();
        keys(&text.parse().unwrap(), &mut used);
        for key in used {
            assert!(known.contains(&key), "{scene}: {key}");
        }
    }
}

#[test]
fn completions_are_written_for_each_shell() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let said = gelfmu(&["completions", shell]);
        assert_eq!(said.status, Some(0), "{shell}");
        assert!(said.out.contains("gelfmu") && said.out.contains("schema"), "{shell}");
    }
    assert_eq!(json(&gelfmu(&["completions", "bash", "--json"]).out)["shell"], "bash");
}

#[test]
fn quiet_leaves_only_errors_and_what_was_asked_for_by_name() {
    assert_eq!(gelfmu(&["check", "l-beam", "--quiet"]).out, "");
    assert!(gelfmu(&["schema", "--quiet"]).out.starts_with('{'));
    assert!(gelfmu(&["check", "x", "--quiet"]).err.starts_with("error: "));
}

#[test]
fn colour_is_used_when_asked_for_and_never_in_a_pipe() {
    let painted = |arguments: &[&str]| gelfmu(arguments).out.contains('\u{1b}');
    assert!(painted(&["check", "l-beam", "--color", "always"]));
    assert!(!painted(&["check", "l-beam", "--color", "never"]));
    assert!(!painted(&["check", "l-beam"]));
}

#[test]
fn version_is_that_of_the_package() {
    let version = format!("gelfmu {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(gelfmu(&["-V"]).out, version);
    assert!(gelfmu(&["--version"]).out.starts_with(&(version + "libraries of the FMU: ")));
}

/// A run that takes a moment.
const SMALL: [&str; 8] =
    ["run", "ball-square", "--direct", "--set", "mesh.size=1e-2", "--set", "projectile.velocity=[0, 0, -1]", "--json"];

fn small(folder: &Path, more: &[&str]) -> Said {
    gelfmu_in(folder, &[&SMALL, more].concat())
}

#[test]
fn a_run_leaves_a_folder_to_look_at_and_prints_its_summary() {
    let folder = folder();
    let said = small(folder.path(), &[]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let out = folder.path().join("gelfmu-out/ball-square");
    for file in ["scene.toml", "summary.json", "history.csv", "series.pvd", "report.html", "frames"] {
        assert!(out.join(file).exists(), "{file}");
    }
    let summary = json(&said.out);
    let file = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert_eq!(said.out.trim_end(), file.trim_end(), "the same text, in the same order");
    assert_eq!((&summary["completed"], &summary["end_time"]), (&Value::from(true), &Value::from(2e-3)));
    let again =
        gelfmu_in(folder.path(), &["run", "gelfmu-out/ball-square/scene.toml", "--direct", "--json", "--out", "again"]);
    assert_eq!(
        json(&again.out)["digest"],
        summary["digest"],
        "the scene that is kept is the one that was run: {}",
        again.err
    );
    assert_eq!(small(folder.path(), &[]).status, Some(2), "the folder is not empty any more");
    assert_eq!(small(folder.path(), &["--force"]).status, Some(0));
}

#[test]
fn step_and_threads_do_not_change_the_digest_and_the_scene_does() {
    let folder = folder();
    let digest = |out: &str, more: &[&str]| {
        let said = small(folder.path(), &[&["--out", out], more].concat());
        json(&said.out)["digest"].as_str().map(str::to_owned).expect("a run has a digest")
    };
    let reference = digest("a", &[]);
    assert_eq!(digest("b", &["--step", "7e-4"]), reference);
    assert_eq!(digest("c", &["--threads", "2"]), reference);
    assert_ne!(digest("d", &["--set", "gel.density=1031"]), reference);
}

#[test]
fn a_run_whose_mesh_fails_says_why_and_keeps_what_it_has() {
    let folder = folder();
    let said = gelfmu_in(folder.path(), &["run", "ball-square", "--direct", "--json"]);
    assert_eq!(said.status, Some(1));
    assert!(said.err.contains("error: the run stopped before its end: "), "{}", said.err);
    assert!(said.err.contains("mesh.size") && said.err.contains("Kept in gelfmu-out/ball-square"), "{}", said.err);
    let summary = json(&said.out);
    assert_eq!(summary["completed"], false);
    assert!(summary["end_time"].as_f64().is_some_and(|end| end > 1e-4 && end < 2e-3), "{summary}");
}

#[test]
fn a_mesh_that_is_too_fine_is_bad_input() {
    let folder = folder();
    let said = gelfmu_in(folder.path(), &["run", "sphere-block", "--direct", "--set", "mesh.size=1e-5"]);
    assert_eq!(said.status, Some(2), "{}", said.err);
    assert!(said.err.contains("raise mesh.size"), "{}", said.err);
}

/// Starts a run into `here`, ends it once it has written a row, and checks that what it has is kept; returns the folder.
fn cut_short(options: &[&str], end: impl FnOnce(&mut Child)) -> TempDir {
    let folder = folder();
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(["run", "ball-bounce", "--direct", "--out", "here"]).args(options).current_dir(folder.path());
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let history = folder.path().join("here/history.csv");
    for _ in 0..1000 {
        if history.exists() {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    end(&mut child);
    let said = said(child.wait_with_output().expect("it ends"));
    assert_eq!(said.status, Some(130), "{}", said.err);
    assert!(said.err.contains("error: interrupted; the results up to now are in here"), "{}", said.err);
    let manifest = std::fs::read_to_string(folder.path().join("here/gelfmu.jsonl")).expect("a manifest");
    assert!(manifest.ends_with("{\"state\":\"interrupted\"}\n"), "{manifest}");
    folder
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_what_it_has() {
    let folder = cut_short(&[], |child| {
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    });
    let summary = json(&std::fs::read_to_string(folder.path().join("here/summary.json")).unwrap());
    assert_eq!((&summary["completed"], &summary["failure"]), (&Value::from(false), &Value::Null));
    let page = std::fs::read_to_string(folder.path().join("here/report.html")).unwrap();
    assert!(page.contains("This run stopped early") && page.contains("The run was ended there"));
}

#[test]
fn a_run_that_ends_with_its_input_keeps_what_it_has() {
    cut_short(&["--end-with-input"], |child| drop(child.stdin.take()));
}

#[test]
fn bench_measures_updates_with_the_same_bits_on_each_number_of_threads() {
    let said = gelfmu(&["bench", "--quick", "--threads", "2", "--json", "--quiet"]);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    let value = json(&said.out);
    assert!(value["elements"].as_u64() >= Some(6000) && value["bytes_per_element"].as_f64() > Some(100.0), "{value}");
    let rows = value["rows"].as_array().unwrap();
    assert_eq!((rows.len(), &rows[0]["threads"], &rows[1]["threads"]), (2, &Value::from(1), &Value::from(2)));
    assert_eq!((&rows[1]["updates"], &rows[1]["same_bits"]), (&rows[0]["updates"], &Value::from(true)));
    for key in ["updates", "million_per_wall_s", "million_per_cpu_s", "times_as_fast_as_one_thread"] {
        assert!(rows.iter().all(|row| row[key].as_f64() > Some(0.0)), "{key}: {value}");
    }
    let said = gelfmu(&["bench", "--quick", "--threads", "1", "--elements", "8000"]);
    assert!(said.out.contains("million updates per s") && said.out.contains("the same"), "{}", said.out);
}
