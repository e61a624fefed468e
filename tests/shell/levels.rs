//! Levels of fidelity of a scene, as a user meets them, and the answers to commands that the Python package has.

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
    Said { status: output.status.code(), out: text(output.stdout), err: crate::lines::joined(&text(output.stderr)) }
}

fn folder(scene: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tiny.toml"), scene).unwrap();
    folder
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
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
        other.contains("found scene tiny.toml without a curve")
            && other.contains("python -m ballistic_gel trade tiny.toml"),
        "{other}"
    );
    let none = refused(&["run", "tiny.toml", "--fidelity", "draft"]);
    assert!(
        none.contains("scene.fidelity: found \"draft\", expected \"standard\", or a table fidelity.draft"),
        "{none}"
    );
    let unknown = refused(&["run", "tiny.toml", "--fidelity", "best"]);
    assert!(unknown.contains("[possible values: draft, coarse, standard, fine, reference, instant]"), "{unknown}");
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

#[test]
fn a_command_of_many_runs_names_that_of_the_python_package() {
    let folder = tempfile::tempdir().unwrap();
    for (words, present) in [
        (&["trade", "ball-square", "--only", "cfl", "--jobs", "2"][..], "python -m ballistic_gel trade SCENE"),
        (&["validate", "--level", "draft"], "python -m ballistic_gel validate"),
        (&["calibrate", "--shots", "gelatin-10"], "python -m ballistic_gel calibrate SHOTS.csv"),
        (&["calibrate", "--sensitivity", "stress,rate"], "python -m ballistic_gel calibrate SHOTS.csv"),
    ] {
        let said = gelfmu(folder.path(), words);
        assert_eq!(said.status, Some(2), "{words:?}: {}", said.err);
        assert!(
            said.err.contains(present) && said.err.contains("pip install \"ballistic-gel[sweep]\""),
            "{}",
            said.err
        );
    }
    let said = gelfmu(folder.path(), &["remesh-demo", "ball-square", "--at", "3e-4"]);
    assert!(said.status == Some(2) && said.err.contains("docs/pictures/paper.py"), "{}", said.err);
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none(), "nothing was written");
}
