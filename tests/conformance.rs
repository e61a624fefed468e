//! A real importer accepts and runs the packed FMU: fmpy, in a virtual environment of its own under `target/`.
#![allow(clippy::unwrap_used)] // a test that cannot go on fails

#[path = "command/lines.rs"]
mod lines;

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;
use xxhash_rust::xxh3::xxh3_64;

/// Variables that would mix other Python installations, or this test's own libraries, into the interpreter.
const FOREIGN: [&str; 4] = ["LD_LIBRARY_PATH", "PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV"];

/// Prints the version, whether it is new enough, and the path of the interpreter.
const QUESTION: &str = "import sys; print(sys.version.split()[0], sys.version_info >= (3, 11), sys.executable)";

/// What is run as Python; `PYTHON` names another one.
fn python() -> (String, PathBuf) {
    let named = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let help = "install Python 3.11 or later with venv (Debian: python3 python3-venv), or set PYTHON to one";
    let output = command(&named).args(["-c", QUESTION]).output();
    let output = output.unwrap_or_else(|error| panic!("cannot run {named}: {error}; {help}"));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut words = text.trim().splitn(3, ' ');
    let (version, new_enough, path) = (words.next(), words.next(), words.next());
    assert_eq!(new_enough, Some("True"), "{named} is version {version:?}; {help}");
    (version.unwrap().to_owned(), path.unwrap().into())
}

/// The interpreter of the virtual environment with exactly the locked packages, made if it is not there yet.
fn environment(folder: &Path) -> PathBuf {
    let lock = root().join("tests/conformance/requirements.txt");
    let (version, python) = python();
    let mut key = fs::read(&lock).unwrap();
    key.extend(format!("{version} {}", python.display()).bytes());
    let venv = folder.join(format!("venv-{:016x}", xxh3_64(&key)));
    let (interpreter, complete) = (interpreter_in(&venv), venv.join("complete"));
    let guard = File::create(folder.join("venv.lock")).unwrap();
    guard.lock().unwrap();
    if !complete.exists() {
        let _ = fs::remove_dir_all(&venv);
        install(&venv, &python, &lock);
        fs::write(&complete, version).unwrap();
    }
    interpreter
}

fn install(venv: &Path, python: &Path, lock: &Path) {
    let has_uv = command("uv").arg("--version").output().is_ok_and(|o| o.status.success());
    let (mut make, mut fill) = if has_uv {
        let (mut make, mut fill) = (command("uv"), command("uv"));
        make.args(["venv", "--quiet", "--python"]).arg(python).arg(venv);
        fill.args(["pip", "install", "--quiet", "--python"]).arg(interpreter_in(venv));
        (make, fill)
    } else {
        let (mut make, mut fill) = (command(python), command(interpreter_in(venv)));
        make.args(["-m", "venv"]).arg(venv);
        fill.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        (make, fill)
    };
    expect(&mut make, "make the virtual environment; Debian has venv in the package python3-venv");
    fill.args(["--require-hashes", "--only-binary", ":all:", "-r"]).arg(lock);
    expect(&mut fill, "install the locked packages");
}

fn interpreter_in(venv: &Path) -> PathBuf {
    if cfg!(windows) { venv.join("Scripts/python.exe") } else { venv.join("bin/python") }
}

fn command(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(program);
    for name in FOREIGN {
        command.env_remove(name);
    }
    command
}

fn expect(command: &mut Command, what: &str) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("cannot {what}: {command:?}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let said = text(&output.stdout) + &lines::joined(&text(&output.stderr));
    assert!(output.status.success(), "cannot {what}: {command:?} ended with {}\n{said}", output.status);
    output
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Program with the libraries of a release, which then stands for that of the tests.
static RELEASE: LazyLock<Option<PathBuf>> =
    LazyLock::new(|| std::env::var_os("BALLISTIC_GEL_RELEASE").map(|file| fs::canonicalize(file).unwrap()));

/// Path of the program that packs and runs.
fn program() -> PathBuf {
    RELEASE.clone().unwrap_or_else(|| env!("CARGO_BIN_EXE_gelfmu").into())
}

fn has_libraries_of_a_release() -> bool {
    RELEASE.is_some() || cfg!(feature = "bundled")
}

fn gelfmu() -> Command {
    Command::new(program())
}

/// Digest of a run of the scene, as `summary.json` gives it.
fn digest(scene: &str, out: &Path, more: &[&str]) -> String {
    expect(gelfmu().args(["run", scene, "--quiet", "--force", "--out"]).arg(out).args(more), "run");
    let summary = fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["interface"], if more.contains(&"--direct") { "direct" } else { "fmi2" });
    summary["digest"].as_str().unwrap().to_owned()
}

/// Packs a scene, by name or path.
fn pack(scene: &str, file: &Path, more: &[&str]) -> Vec<u8> {
    expect(gelfmu().args(["pack", scene, "--out"]).arg(file).args(more), "pack");
    fs::read(file).unwrap()
}

/// The packer of the partners and the systems, built once with the partners: they are a package of their own, and share no crate with
/// the gel as it is built here.
static PACKER: LazyLock<PathBuf> = LazyLock::new(|| {
    let target = Path::new(env!("CARGO_BIN_EXE_gelfmu")).ancestors().nth(2).unwrap().join("partners");
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.args(["build", "--release", "--locked", "--bins", "--examples", "--manifest-path"]);
    cargo.arg(root().join("partners/Cargo.toml")).arg("--target-dir").arg(&target);
    expect(&mut cargo, "build the partners");
    target.join("release").join(format!("ssp{}", std::env::consts::EXE_SUFFIX))
});

/// The command that packs the partners of the gel and the systems with them into a folder.
fn packer(out: &Path) -> Command {
    let mut ssp = command(&*PACKER);
    ssp.env_remove("CARGO").arg("--gelfmu").arg(program()).arg(out);
    ssp
}

/// Packs the systems with a scene.
fn systems(out: &Path, scene: &str) -> PathBuf {
    expect(packer(out).arg(scene), "pack the partners");
    out.to_owned()
}

/// Descriptions of the armour and of the body behind it when they are packed with changes to their scene, or the refusal.
fn armour_system(changes: &[(&str, &str)]) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(root().join("partners/armour-block.toml")).unwrap();
    let text = changes.iter().fold(text, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let (scene, out) = (folder.path().join("armour.toml"), folder.path().join("out"));
    fs::write(&scene, text).unwrap();
    let output = packer(&out).arg(coarse_scene(folder.path())).arg(&scene).output().unwrap();
    if !output.status.success() {
        assert!(!out.exists(), "something was written");
        return Err(String::from_utf8(output.stderr).unwrap());
    }
    let description = |partner: &str| {
        let unpacked = folder.path().join(partner);
        unpack(&out.join(partner), &unpacked);
        fs::read_to_string(unpacked.join("modelDescription.xml")).unwrap()
    };
    Ok(description("Armour.fmu") + &description("RigidBodyBehindArmour.fmu"))
}

#[test]
fn the_armour_of_a_system_starts_as_its_scene_says() {
    let capsule = "shape.capsule = { radius = 0.008, length = 0.032 }\norientation = [0.8, 0.6, 0.0, 0.0]";
    let descriptions = armour_system(&[
        ("shape.sphere.radius = 0.010", capsule),
        ("[0.0, 0.0, 0.015]", "[0.0, 0.0, 0.02]"),
        ("height = 0.0, radius = 0.015", "height = 0.004, radius = 0.012"),
        // Beside the gel, into which the bulge would reach.
        ("[0.0, 0.0, 0.0]", "[0.2, 0.0, 0.0]"),
        ("mass = 0.033", "mass = 0.05"),
        ("size = 5e-3", "size = 8e-3"),
    ]);
    let descriptions = descriptions.unwrap();
    let value = |name: &str| -> f64 {
        let (_, rest) = descriptions.split_once(&format!("<ScalarVariable name=\"{name}\"")).unwrap();
        rest.split_once("start=\"").unwrap().1.split('"').next().unwrap().parse().unwrap()
    };
    // The capsule is turned by 2 acos(0.8): its axis has the cosine 0.28 to the vertical.
    for (name, expected) in
        [("nose", 0.008 * 1.28), ("initial_height", 0.004), ("initial_radius", 0.012), ("projectile_mass", 0.05)]
    {
        assert!((value(name) / expected - 1.0).abs() < 1e-12, "{name}: {}", value(name));
    }
    assert_eq!((value("mass"), value("initial_position[3]"), value("initial_orientation[2]")), (0.05, 0.02, 0.6));
    assert!(value("inertia[3]") < value("inertia[1]"), "that of a capsule: least about its axis");
}

#[test]
fn a_scene_that_is_not_behind_the_armour_is_refused_before_anything_is_written() {
    for (from, to, said) in [
        ("[0.0, 0.0, 0.015]", "[0.0, 0.0, 0.014]", "projectile.position: found its lowest point at z = 0.004 m"),
        ("fixed = true", "mass = 1.0\ninertia = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]", "fragment[1].fixed: found false"),
        ("shape.dome = { height = 0.0, radius = 0.015 }", "shape.half-space.normal = [0, 0, -1]", "fragment[1].shape"),
        ("fixed = true", "fixed = true\nactive = false", "fragment[1].active: found false"),
        ("[0.0, 0.0, 0.0]", "[0.0, 0.0, 0.001]", "fragment[1].position"),
        (
            "mass = 0.033\nposition = [0.0, 0.0, 0.015]\nvelocity = [0.0, 0.0, -20.0]",
            "position = [0.0, 0.0, 0.015]\nfixed = true",
            "projectile.fixed: found true",
        ),
    ] {
        let refused = armour_system(&[(from, to)]).unwrap_err();
        assert!(refused.contains("armour.toml: ") && refused.contains(said), "{said}: {refused}");
    }
}

/// A scene with two fragments.
const FRAGMENTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/conformance/fragments.toml");

fn unpack(archive: &Path, folder: &Path) {
    zip::ZipArchive::new(File::open(archive).unwrap()).unwrap().extract(folder).unwrap();
}

/// Names of the variables of a packed scene.
fn names(fmu: &Path) -> Vec<String> {
    let unpacked = tempfile::tempdir().unwrap();
    unpack(fmu, unpacked.path());
    let description = fs::read_to_string(unpacked.path().join("modelDescription.xml")).unwrap();
    let variables = description.split("<ScalarVariable name=\"").skip(1);
    variables.map(|rest| rest.split('"').next().unwrap().to_owned()).collect()
}

#[test]
fn fragments_get_variables_all_by_default_or_as_many_as_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let count = |file: &str, more: &[&str]| {
        let file = folder.path().join(file);
        expect(gelfmu().args(["pack", "--scene", FRAGMENTS, "--out"]).arg(&file).args(more), "pack");
        let names = names(&file);
        (1..=3).map(|i| names.iter().filter(|name| name.starts_with(&format!("fragment[{i}]."))).count()).collect()
    };
    let (all, one, none): (Vec<usize>, Vec<usize>, Vec<usize>) =
        (count("all.fmu", &[]), count("one.fmu", &["--fragments", "1"]), count("none.fmu", &["--fragments", "0"]));
    // The second fragment is a fixed dome: without the 19 inputs that would move it, with those of its bulge and two impulses.
    assert!(all[0] > 80 && all[1] == all[0] - 19 + 4 + 2 && all[2] == 0, "{all:?}");
    assert_eq!((one, none), (vec![all[0], 0, 0], vec![0, 0, 0]));
}

fn coarse_scene(folder: &Path) -> String {
    let text = ballistic_gel::scene::builtin("sphere-block").unwrap();
    let coarse = text.replace("size = 5e-3", "size = 10e-3").replace("end_time = 10e-3", "end_time = 2e-3");
    assert_ne!(coarse, text);
    let file = folder.join("coarse.toml");
    fs::write(&file, coarse).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn one_gelfmu_packs_a_scene_into_the_same_bytes_and_a_release_has_no_build_path_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let first = pack("ball-bounce", &folder.path().join("first.fmu"), &[]);
    assert_eq!(first, pack("ball-bounce", &folder.path().join("second.fmu"), &[]));
    let unpacked = folder.path().join("unpacked");
    unpack(&folder.path().join("first.fmu"), &unpacked);
    let description = fs::read_to_string(unpacked.join("modelDescription.xml")).unwrap();
    assert_eq!(
        description.contains("(development)\""),
        !has_libraries_of_a_release(),
        "generationTool names the library"
    );
    if has_libraries_of_a_release() {
        let home = std::env::home_dir().filter(|home| home.components().count() > 1);
        for folder in fs::read_dir(unpacked.join("binaries")).unwrap() {
            let file = fs::read_dir(folder.unwrap().path()).unwrap().next().unwrap().unwrap().path();
            let library = fs::read(&file).unwrap();
            for path in [Some(root().to_path_buf()), home.clone()].into_iter().flatten() {
                let path = path.to_str().unwrap();
                let is_there = library.windows(path.len()).any(|w| w == path.as_bytes());
                assert!(!is_there, "{path} stands in {}", file.display());
            }
        }
    }
}

#[test]
fn a_file_that_cannot_be_written_is_bad_input() {
    for out in [".", "Cargo.toml/x.fmu"] {
        let output = gelfmu().args(["pack", "--out", out]).current_dir(root()).output().unwrap();
        let said = lines::joined(&String::from_utf8(output.stderr).unwrap());
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.starts_with(&format!("error: --out {out}: found ")), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_second_interruption_ends_a_long_step_at_once_and_leaves_no_temporary_folder() {
    let folder = tempfile::tempdir().unwrap();
    let scratch = folder.path().join("scratch");
    fs::create_dir(&scratch).unwrap();
    let mut run = gelfmu();
    run.args(["run", "sphere-block", "--set", "mesh.size=2e-3", "--step", "1", "--out", "out"]);
    run.current_dir(folder.path()).env("TMPDIR", &scratch).stderr(Stdio::piped());
    let mut child = run.spawn().unwrap();
    let pause = || std::thread::sleep(std::time::Duration::from_millis(300));
    while !folder.path().join("out/history.csv").exists() {
        assert_eq!(child.try_wait().unwrap(), None, "the run ended before its first row");
        pause();
    }
    assert_ne!(fs::read_dir(&scratch).unwrap().count(), 0, "the FMU is unpacked there");
    for signal in ["-INT", "-TERM"] {
        assert_eq!(child.try_wait().unwrap(), None, "the step takes longer than this test");
        pause();
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        pause();
    }
    let output = child.wait_with_output().unwrap();
    let said = lines::joined(&String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("Ctrl-C again ends it at once"), "{said}");
    assert_eq!(fs::read_dir(&scratch).unwrap().count(), 0);
}

#[test]
fn fmpy_accepts_and_runs_the_fmu() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("conformance");
    fs::create_dir_all(&folder).unwrap();
    let interpreter = environment(&folder);
    let (fmu, coarse) = (folder.join("sphere-block.fmu"), folder.join("coarse.fmu"));
    pack("sphere-block", &fmu, &[]);
    pack(&coarse_scene(&folder), &coarse, &[]);
    let (fragments, other) = (folder.join("fragments.fmu"), folder.join("fbi-bb.fmu"));
    pack(FRAGMENTS, &fragments, &["--terminals"]);
    let sets = folder.join("sets");
    fs::create_dir_all(&sets).unwrap();
    for outputs in ["integrated", "corrected", "full"] {
        pack("sphere-block", &sets.join(outputs).with_extension("fmu"), &["--terminals", "--outputs", outputs]);
    }
    pack("fbi-bb", &other, &["--set", "mesh.size=2e-3"]);
    let coarse_systems = systems(&folder.join("systems"), &coarse_scene(&folder));
    let tumbling = root().join("tests/conformance/tumbling.toml");
    let tumbling = systems(&folder.join("tumbling"), tumbling.to_str().unwrap());
    let mut pytest = command(interpreter);
    // The gate has run all of them with the program of the tests, and names a file for that of the wheel.
    let file = std::env::var("BALLISTIC_GEL_CONFORMANCE").unwrap_or_default();
    let tests = root().join("tests/conformance").join(file);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(tests);
    pytest.env("BALLISTIC_GEL_FMU", &fmu).env("BALLISTIC_GEL_COARSE_FMU", &coarse);
    pytest.env("BALLISTIC_GEL_SYSTEMS", coarse_systems).env("BALLISTIC_GEL_TUMBLING_SYSTEMS", tumbling);
    pytest.env("BALLISTIC_GEL_FRAGMENTS_FMU", &fragments).env("BALLISTIC_GEL_OTHER_FMU", &other);
    pytest.env("BALLISTIC_GEL_OUTPUT_SETS", &sets);
    let output = expect(pytest.env("PYTHONDONTWRITEBYTECODE", "1"), "pass the tests of the importer");
    println!("{}", String::from_utf8_lossy(&output.stdout));
}

#[test]
fn the_library_and_the_fmu_give_the_same_digest_for_every_communication_step() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, out) = (coarse_scene(folder.path()), folder.path().join("out"));
    let digests = ["bins", "queue"].map(|schedule| {
        let schedule = format!("integrator.schedule={schedule}");
        let direct = digest(&scene, &out, &["--direct", "--set", &schedule]);
        for n in [1.0, 7.0, 100.0, 12_345.0] {
            let step = format!("{:e}", 2e-3 / n);
            assert_eq!(digest(&scene, &out, &["--set", &schedule, "--step", &step]), direct, "{n} steps, {schedule}");
        }
        direct
    });
    assert_ne!(digests[0], digests[1]);
    assert_ne!(digest(&scene, &out, &["--set", "projectile.mass=0.034"]), digests[0]);
}
