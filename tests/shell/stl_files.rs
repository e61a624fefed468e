//! The STL file of a scene goes where the scene goes: into the command, the archive, the FMU and its state.

#![allow(dead_code, reason = "the bodies are shared with the tests of their geometry")]

#[path = "../solid/bodies.rs"]
mod bodies;

use ballistic_gel::fmi2::ArchiveManifest;
use bodies::{Triangles, binary, moved, sphere};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with `scenes/ball.toml`, whose body is in `bodies/ball.stl`, and an empty folder `elsewhere`.
fn layout(file: &str, body: &Triangles) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for inner in ["scenes/near", "bodies", "elsewhere"] {
        fs::create_dir_all(folder.path().join(inner)).unwrap();
    }
    let text = ballistic_gel::scene::builtin("sphere-block").unwrap();
    let shape = format!("shape.stl = {{ file = {file:?}, scale = 1e-3 }} # a ball");
    let text = text.replace("size = 5e-3", "size = 8e-3").replace("shape.sphere.radius = 0.010", &shape);
    let text = text.replace("end_time = 10e-3", "end_time = 1e-3");
    assert!(text.contains(&shape));
    fs::write(folder.path().join("scenes/ball.toml"), text).unwrap();
    fs::write(folder.path().join("scenes").join(file.replace('\\', "/")), binary(body)).unwrap();
    folder
}

fn ball() -> Triangles {
    sphere(10.0, 8)
}

/// Calls the command in the folder `elsewhere`.
fn gelfmu(folder: &TempDir, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelfmu"));
    command.args(arguments).current_dir(folder.path().join("elsewhere")).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[track_caller]
fn done(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

fn digest(folder: &TempDir, more: &[&str]) -> String {
    let arguments = ["run", "../scenes/ball.toml", "--out", "out", "--force", "--quiet", "--json"];
    let said = done(&gelfmu(folder, &[&arguments[..], more].concat()));
    serde_json::from_str::<serde_json::Value>(&said).unwrap()["digest"].as_str().unwrap().to_owned()
}

#[test]
fn the_file_is_found_from_any_working_directory() {
    let folder = layout("../bodies/ball.stl", &ball());
    let said = crate::lines::joined(&done(&gelfmu(&folder, &["check", "../scenes/ball.toml"])));
    assert!(said.contains(", a closed surface of 224 triangles, 0.020000 x 0.020000"), "{said}");
    let whole: PathBuf = folder.path().join("scenes/ball.toml");
    done(&gelfmu(&folder, &["check", whole.to_str().unwrap()]));
    let first = digest(&folder, &["--direct"]);
    // What is kept can be run again where it is.
    let again = ["run", "out/scene.toml", "--direct", "--quiet", "--json", "--out", "again"];
    let again: serde_json::Value = serde_json::from_str(&done(&gelfmu(&folder, &again))).unwrap();
    assert_eq!(again["digest"], first);
    let drawn = fs::read(folder.path().join("elsewhere/out/report.html")).unwrap();
    assert!(!drawn.is_empty());
}

#[test]
fn a_file_that_is_not_there_is_named_with_the_line_of_the_scene() {
    let folder = layout("ball.stl", &ball());
    fs::remove_file(folder.path().join("scenes/ball.stl")).unwrap();
    for command in ["check", "run"] {
        let output = gelfmu(&folder, &[command, "../scenes/ball.toml"]);
        let said = crate::lines::joined(&text(&output.stderr));
        assert_eq!(output.status.code(), Some(2));
        assert!(said.starts_with("error: scene ../scenes/ball.toml: line "), "{said}");
        let found = "projectile.shape.stl.file: found \"ball.stl\": cannot read ../scenes/ball.stl: ";
        assert!(said.contains(found) && said.contains("relative to the folder of the scene"), "{said}");
    }
}

/// Name and bytes of everything in `resources/` of an archive.
fn resources(folder: &TempDir, archive: &str) -> Vec<(String, Vec<u8>)> {
    done(&gelfmu(folder, &["pack", "../scenes/ball.toml", "--out", archive]));
    let unpacked = folder.path().join("elsewhere/unpacked");
    let file = fs::File::open(folder.path().join("elsewhere").join(archive)).unwrap();
    zip::ZipArchive::new(file).unwrap().extract(&unpacked).unwrap();
    let mut found = vec![];
    collect(&unpacked.join("resources"), "", &mut found);
    found.retain(|(name, _)| name != ArchiveManifest::FILE);
    found.sort();
    found
}

fn collect(folder: &Path, prefix: &str, found: &mut Vec<(String, Vec<u8>)>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), found);
        } else {
            found.push((name, fs::read(entry.path()).unwrap()));
        }
    }
}

/// Packs the scene, and expects the file under this name beside a scene that names it so, and nothing else.
#[track_caller]
fn expect_packed(folder: &TempDir, file: &str, inner: &str) {
    let own = fs::read_to_string(folder.path().join("scenes/ball.toml")).unwrap();
    let packed = resources(folder, "ball.fmu");
    let scene = own.replace(&format!("{file:?}"), &format!("{inner:?}"));
    let mut expected = vec![(inner.to_owned(), binary(&ball())), ("scene.toml".to_owned(), scene.into_bytes())];
    expected.sort();
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&packed), names(&expected));
    assert!(packed == expected, "{file}");
}

#[test]
fn paths_of_windows_and_names_of_the_archive_become_names_that_every_system_takes() {
    for (file, inner) in [
        ("SCENE.TOML", "2-SCENE.TOML"),
        ("near\\ball.stl", "near/ball.stl"),
        ("..\\bodies\\Manifest.json", "2-Manifest.json"),
    ] {
        expect_packed(&layout(file, &ball()), file, inner);
    }
}

#[test]
fn the_archive_holds_the_file_and_the_fmu_runs_with_it() {
    for (file, inner) in [("near/ball.stl", "near/ball.stl"), ("../bodies/ball.stl", "ball.stl")] {
        let folder = layout(file, &ball());
        expect_packed(&folder, file, inner);
        let first = fs::read(folder.path().join("elsewhere/ball.fmu")).unwrap();
        resources(&folder, "ball.fmu");
        assert!(first == fs::read(folder.path().join("elsewhere/ball.fmu")).unwrap(), "the same bytes again");
        let direct = digest(&folder, &["--direct"]);
        assert_eq!(digest(&folder, &[]), direct);
        let other = layout(file, &moved(&sphere(10.0, 9), ballistic_gel::math::Vector3::x()));
        assert_ne!(digest(&other, &["--direct"]), direct);
    }
}
