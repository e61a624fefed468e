//! `gelfmu trade`, and the levels of fidelity that it measures, as a user meets them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A disc falls on a small slice of gel, on 200 elements.
const SCENE: &str = r#"
[scene]
name = "tiny"
dimension = "planar"
end_time = 4e-3
communication_step = 20e-6

[gel]
shape.block.size = [0.06, 0.03]
material = "neo-hookean"
density = 1030.0
shear_modulus = 70e3
bulk_modulus = 350e3
supports.z_min = "fixed"

[projectile]
shape.sphere.radius = 0.010
mass = 0.5
position = [0.0, 0.0, 0.010]
velocity = [0.0, 0.0, -2.0]

[mesh]
size = 6e-3
"#;

const LEVELS: &str = r#"
[fidelity.coarse]
set = ["mesh.size=10e-3"]
error = 0.08
updates = 1e3

[fidelity.standard]
set = []
error = 0.02
updates = 2e4

[fidelity.fine]
set = ["mesh.size=3e-3"]
error = 0.005
updates = 1e5
"#;

struct Said {
    status: Option<i32>,
    out: String,
    err: String,
}

fn gelfmu(folder: &Path, arguments: &[&str]) -> Said {
    let output = Command::new(env!("CARGO_BIN_EXE_gelfmu")).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Said { status: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

fn folder(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tiny.toml"), scene).unwrap();
    folder
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

fn run_of<'a>(value: &'a Value, label: &str) -> &'a Value {
    value["runs"]
        .as_array()
        .unwrap()
        .iter()
        .find(|run| run["run"] == label)
        .unwrap_or_else(|| panic!("no {label}: {value}"))
}

#[test]
fn a_curve_is_measured_written_and_taken_up_again() {
    let folder = folder(SCENE);
    let words = ["trade", "tiny.toml", "--only", "cfl", "--finer", "2", "--jobs", "2", "--out", "curve", "--json"];
    let first = gelfmu(folder.path(), &words);
    assert_eq!(first.status, Some(0), "{}", first.err);
    let value = json(&first.out);
    let (base, fine) = (run_of(&value, "as it comes"), run_of(&value, "mesh.size=0.003"));
    assert!(fine["row"]["element_updates"].as_f64() > base["row"]["element_updates"].as_f64());
    let refused = run_of(&value, "mesh.size=0.012")["refused"].as_str().unwrap();
    assert!(refused.contains("mesh.size") && refused.contains("radius of the greatest ball"), "{refused}");
    let text = |name: &str| fs::read_to_string(folder.path().join("curve").join(name)).unwrap();
    let (csv, markdown, picture) = (text("trade.csv"), text("trade.md"), text("trade.svg"));
    assert_eq!(csv.lines().count(), 1 + value["runs"].as_array().unwrap().len());
    assert!(csv.starts_with("knob,run,elements,element_updates,cpu_seconds,") && csv.contains("integrator.cfl=1.0"));
    assert!(markdown.contains("mesh.size=0.012 | - | - | - | refused") && markdown.contains("depth:"), "{markdown}");
    assert!(picture.starts_with("<svg") && picture.contains("element updates") && picture.contains("CPU seconds"));
    let again = gelfmu(folder.path(), &words);
    assert_eq!(json(&again.out), value, "rows that are kept are not run again: their times are those of the first run");
    let afresh: Vec<&str> = words.into_iter().chain(["--afresh"]).collect();
    let afresh = json(&gelfmu(folder.path(), &afresh).out);
    let (old, new) = (&base["row"], &run_of(&afresh, "as it comes")["row"]);
    assert_eq!((&old["digest"], old["cpu_seconds"] == new["cpu_seconds"]), (&new["digest"], false));
}

#[test]
fn runs_that_fail_are_shown_and_meshes_that_are_replaced_go_on() {
    let folder = folder(SCENE);
    let set = "projectile.velocity=[0, 0, -60]";
    let words = [
        "trade",
        "tiny.toml",
        "--set",
        set,
        "--only",
        "cfl",
        "--finer",
        "1",
        "--jobs",
        "2",
        "--out",
        "curve",
        "--json",
    ];
    let said = gelfmu(folder.path(), &words);
    let value = json(&said.out);
    let failure = run_of(&value, "as it comes")["row"]["failure"].as_str().unwrap();
    assert!(failure.contains("inverted"), "{failure}");
    assert_eq!(run_of(&value, "as it comes")["error"], Value::Null);
    run_of(&value, "remesh.quality=0.3");
    let markdown = fs::read_to_string(folder.path().join("curve/trade.md")).unwrap();
    assert!(markdown.contains("as it comes: failed after") && markdown.contains("| failed |"), "{markdown}");
}

#[test]
fn runs_of_other_codes_stand_in_the_picture() {
    let folder = folder(SCENE);
    fs::write(folder.path().join("peers.csv"), "run,peak_depth,cpu_seconds\nanother code,0.009,12.5\n").unwrap();
    let words = ["trade", "tiny.toml", "--only", "cfl", "--finer", "2", "--out", "curve", "--quiet", "--with"];
    let with = |file: &'static str| words.into_iter().chain([file]).collect::<Vec<_>>();
    let said = gelfmu(folder.path(), &with("peers.csv"));
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    assert!(fs::read_to_string(folder.path().join("curve/trade.svg")).unwrap().contains("another code"));
    let said = gelfmu(folder.path(), &with("none.csv"));
    assert_eq!(said.status, Some(2));
    assert!(said.err.starts_with("error: --with none.csv: found "), "{}", said.err);
}

#[test]
fn options_that_are_off_leave_the_bits_and_those_that_are_on_are_counted() {
    let folder = folder(SCENE);
    let said = gelfmu(folder.path(), &["trade", "tiny.toml", "--options", "--out", "options", "--json"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let value = json(&said.out);
    let options = value["options"].as_array().unwrap();
    let digest = |run: &str| options.iter().find(|option| option["run"] == run).unwrap()["row"]["digest"].clone();
    for off in ["contact.friction=0.0", "integrator.damping=0.0", "load=[]", "mesh.element=\"plain\"", "fragment=[]"] {
        assert_eq!(digest(off), digest("as it comes"), "{off}");
    }
    assert_ne!(digest("integrator.damping=1.0"), digest("as it comes"));
    let table = fs::read_to_string(folder.path().join("options/options.md")).unwrap();
    assert!(table.contains("| friction | contact.friction=0.0: the same bits |"), "{table}");
}

fn summary(folder: &Path) -> Value {
    json(&fs::read_to_string(folder.join("summary.json")).unwrap())
}

#[test]
fn a_level_or_an_accuracy_picks_a_setting_and_says_what_to_expect() {
    let folder = folder(&format!("{SCENE}{LEVELS}"));
    let run = |choice: &[&str], out: &str| {
        let words = ["run", "tiny.toml", "--direct", "--set", "output.frames=1", "--out", out];
        let said = gelfmu(folder.path(), &words.into_iter().chain(choice.iter().copied()).collect::<Vec<_>>());
        assert_eq!(said.status, Some(0), "{}", said.err);
        (said, summary(&folder.path().join(out)))
    };
    let (said, coarse) = run(&["--accuracy", "10%"], "a");
    assert!(
        said.err.contains("fidelity coarse: expect an error of 8 %, 0.001 million element updates"),
        "{}",
        said.err
    );
    assert_eq!((&coarse["fidelity"], coarse["expected_error"].as_f64()), (&Value::from("coarse"), Some(0.08)));
    let (_, fine) = run(&["--fidelity", "3"], "b");
    assert!(fine["elements"].as_u64() > coarse["elements"].as_u64());
    let (_, standard) = run(&["--accuracy", "2"], "c");
    assert_eq!((&standard["fidelity"], standard["expected_error"].as_f64()), (&Value::from("standard"), Some(0.02)));
    let (said, other) = run(&["--fidelity", "fine", "--set", "projectile.velocity=[0, 0, -1]"], "d");
    assert!(said.err.contains("nothing was measured with these values"), "{}", said.err);
    assert_eq!(other["expected_error"], Value::Null);
}

#[test]
fn an_accuracy_that_no_curve_knows_is_refused_with_a_remedy() {
    let folder = folder(&format!("{SCENE}{LEVELS}"));
    let refused = |words: &[&str]| {
        let said = gelfmu(folder.path(), words);
        assert_eq!(said.status, Some(2));
        said.err
    };
    let beyond = refused(&["run", "tiny.toml", "--accuracy", "0.1%"]);
    assert!(beyond.contains("--accuracy 0.1%: found nothing so accurate, expected at least 0.5%"), "{beyond}");
    let other = refused(&["run", "tiny.toml", "--accuracy", "5%", "--set", "gel.density=900.0"]);
    assert!(
        other.contains("found scene tiny.toml without a curve") && other.contains("gelfmu trade tiny.toml"),
        "{other}"
    );
    let none = refused(&["run", "tiny.toml", "--fidelity", "draft"]);
    assert!(
        none.contains("scene.fidelity: found \"draft\", expected \"standard\", or a table fidelity.draft"),
        "{none}"
    );
    let unknown = refused(&["run", "tiny.toml", "--fidelity", "best"]);
    assert!(unknown.contains("[possible values: draft, coarse, standard, fine, reference]"), "{unknown}");
}

#[test]
fn check_prints_the_levels() {
    let folder = folder(&format!("{SCENE}{LEVELS}"));
    let said = gelfmu(folder.path(), &["check", "tiny.toml"]);
    assert!(
        said.out.contains("fine (mesh.size=3e-3)") || said.out.contains("fine: expect an error of 0.5 %"),
        "{}",
        said.out
    );
    assert_eq!(json(&gelfmu(folder.path(), &["check", "tiny.toml", "--json"]).out)["fidelity"]["fine"]["error"], 0.005);
}
