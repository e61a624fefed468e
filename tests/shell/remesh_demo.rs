//! `gelfmu remesh-demo` as a user meets it.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn gelfmu(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(arguments).current_dir(folder).output().expect("the command starts")
}

fn err(said: &Output) -> String {
    String::from_utf8_lossy(&said.stderr).into_owned()
}

#[test]
fn remesh_demo_draws_the_steps_of_a_remeshing() {
    let folder = tempfile::tempdir().unwrap();
    let coarse = ["--set", "mesh.size=5e-3", "--set", "projectile.velocity=[0, 0, -20]"];
    let said = gelfmu(
        folder.path(),
        &[&["remesh-demo", "--at", "0.8e-3", "--output", "steps", "--json"], coarse.as_slice()].concat(),
    );
    assert_eq!(said.status.code(), Some(0), "{}", err(&said));
    let json: Value = serde_json::from_slice(&said.stdout).unwrap();
    let figures = &json["figures"];
    assert!((figures["time"].as_f64().unwrap() - 0.8e-3).abs() < 1e-4, "{figures}");
    for (i, method) in ["immersed", "local"].iter().enumerate() {
        let outcome = &figures["methods"][i];
        assert_eq!(outcome["method"], *method);
        assert!(outcome["mesh"]["elements"].as_u64() > Some(100), "{outcome}");
        assert!(outcome["mesh"]["momentum"].as_f64().unwrap() < 1e-12, "{outcome}");
    }
    let page = std::fs::read_to_string(folder.path().join("steps/index.html")).unwrap();
    let pictures: Vec<&str> = page.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(pictures.len(), 22);
    for picture in pictures {
        let bytes = std::fs::read(folder.path().join("steps").join(picture)).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 1000, "{picture}");
    }
}

#[test]
fn remesh_demo_says_why_there_is_nothing_to_draw() {
    let folder = tempfile::tempdir().unwrap();
    let said = gelfmu(folder.path(), &["remesh-demo", "sphere-block"]);
    assert_eq!(said.status.code(), Some(2));
    assert!(
        err(&said).starts_with("error: scene sphere-block: found a spatial gel, expected a planar"),
        "{}",
        err(&said)
    );
    let slow = ["--set", "mesh.size=5e-3", "--set", "projectile.velocity=[0, 0, -0.1]"];
    let said = gelfmu(folder.path(), &[&["remesh-demo", "ball-square", "--quiet"], slow.as_slice()].concat());
    assert_eq!(said.status.code(), Some(1));
    assert!(
        err(&said).contains("the mesh is not distorted up to scene.end_time, 0.002 s: give a time with --at"),
        "{}",
        err(&said)
    );
}
