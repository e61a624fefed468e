//! Packs the gel, its partners, and the systems of them: `cargo run --release --example ssp -- OUT_DIR`.

mod archive;
mod description;
mod scene;
mod structure;
mod systems;

#[path = "../partners/body.rs"]
mod body;
#[path = "../partners/plate.rs"]
mod plate;
#[path = "../partners/starts.rs"]
mod starts;
#[path = "../partners/table.rs"]
mod table;

use archive::{Entries, zipped};
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, EXE_SUFFIX, OS};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use table::Model;

const USAGE: &str = "usage: ssp OUT_DIR [SCENE [ARMOUR_SCENE]], built-in scenes or files: for gel and body (default \
                     sphere-block), and with a dome as first fragment (default examples/ssp/armour-block.toml)";
const ARMOUR_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/ssp/armour-block.toml");

/// A partner to be packed.
struct Partner {
    model: &'static Model,
    /// Name of its library.
    library: &'static str,
    /// Name of its FMU.
    file: &'static str,
    /// Start values of all components.
    starts: Vec<f64>,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments.as_slice() {
        [out] => pack(Path::new(out), "sphere-block", ARMOUR_SCENE),
        [out, scene] => pack(Path::new(out), scene, ARMOUR_SCENE),
        [out, scene, armour_scene] => pack(Path::new(out), scene, armour_scene),
        _ => Err(USAGE.to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// Nothing is built and written before both scenes are known to go with the partners.
fn pack(out: &Path, scene_name: &str, armour_scene_name: &str) -> Result<(), String> {
    let partners = partners(scene_name, armour_scene_name)?;
    let built = build()?;
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    for each in &partners {
        write(&out.join(each.file), &partner(each, &built)?)?;
    }
    let (wires, armour_wires) = (systems::gel_and_body_wires(), systems::gel_armour_and_body_wires());
    let own = systems::gel_and_body("BallisticGel.fmu", systems::BODY);
    let corrected = systems::gel_and_body("BallisticGelCorrected.fmu", systems::BODY);
    let behind_armour = systems::gel_armour_and_body("BallisticGelBehindArmour.fmu");
    for (name, scene, mode, units, wires) in [
        ("gel-and-body", scene_name, "integrated", own, &wires),
        ("gel-and-body-corrected", scene_name, "corrected", corrected, &wires),
        ("gel-armour-body", armour_scene_name, "integrated", behind_armour, &armour_wires),
    ] {
        gel(&built, (scene, mode), &out.join(systems::gel_file(&units)))?;
        system(out, name, &units, wires)?;
    }
    Ok(())
}

/// The partners, each with the start values of its scene.
fn partners(scene_name: &str, armour_scene_name: &str) -> Result<[Partner; 3], String> {
    let (scene, armour_scene) = (scene::read(scene_name)?, scene::read(armour_scene_name)?);
    let body = |file, starts| Partner { model: &body::MODEL, library: "rigid_body", file, starts };
    let (name, armour_name) = (named(scene_name), named(armour_scene_name));
    let behind = scene::body_starts(&armour_scene).map_err(&armour_name)?;
    let armour = scene::armour_starts(&armour_scene).map_err(armour_name)?;
    Ok([
        body(systems::BODY, scene::body_starts(&scene).map_err(name)?),
        body(systems::BODY_BEHIND_ARMOUR, behind),
        Partner { model: &plate::MODEL, library: "armour", file: systems::ARMOUR, starts: armour },
    ])
}

fn named(scene: &str) -> impl Fn(String) -> String {
    move |error| format!("scene {scene}: {error}")
}

/// Packs the gel with a scene and a coupling mode into a file.
fn gel(built: &Path, (scene, mode): (&str, &str), file: &Path) -> Result<(), String> {
    let mut gelfmu = Command::new(built.join(format!("gelfmu{EXE_SUFFIX}")));
    gelfmu.args(["--quiet", "pack", "--scene", scene, "--set", &format!("coupling.mode={mode}"), "--out"]);
    run(gelfmu.arg(file))
}

/// Where the programs and libraries to pack are. Started by cargo, in whatever profile, it builds them for release; started
/// by itself, it takes what lies beside it.
fn build() -> Result<PathBuf, String> {
    let own = std::env::current_exe().map_err(|error| format!("this program has no path: {error}"))?;
    let built = own.ancestors().nth(2).ok_or("this program is not in a folder of cargo")?.to_path_buf();
    if let Some(cargo) = std::env::var_os("CARGO") {
        let target = built.parent().ok_or("this program is not in a target folder of cargo")?;
        let mut cargo = Command::new(cargo);
        cargo.current_dir(env!("CARGO_MANIFEST_DIR")).args(["build", "--release", "--quiet", "--bins"]);
        run(cargo.args(["--example", "rigid_body", "--example", "armour", "--target-dir"]).arg(target))?;
        return Ok(target.join("release"));
    }
    Ok(built)
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} ended with {status}")) }
}

/// The FMU of a partner, for this host.
fn partner(partner: &Partner, built: &Path) -> Result<Vec<u8>, String> {
    let Partner { model, library, starts, .. } = partner;
    let file = built.join("examples").join(format!("{DLL_PREFIX}{library}{DLL_SUFFIX}"));
    let library = fs::read(&file)
        .map_err(|error| format!("{}: {error}; cargo build --release --example {library} makes it", file.display()))?;
    let text = starts::written(model, starts);
    if starts::read(model, &text).as_ref() != Ok(starts) {
        return Err(format!("{}: the start values are not those that were written: {text}", model.name));
    }
    let description = description::xml(model, starts).map_err(|error| error.to_string())?;
    let entries = Entries::from([
        ("modelDescription.xml".to_owned(), description.into_bytes()),
        (format!("resources/{}", starts::FILE), text.into_bytes()),
        (format!("binaries/{}/{}{DLL_SUFFIX}", platform()?, model.name), library),
    ]);
    zipped(&entries).map_err(|error| error.to_string())
}

/// FMI 2.0's name of this host.
fn platform() -> Result<&'static str, String> {
    match (OS, ARCH) {
        ("linux", "x86_64") => Ok("linux64"),
        ("linux", "aarch64") => Ok("aarch64-linux"),
        ("windows", "x86_64") => Ok("win64"),
        ("macos", _) => Ok("darwin64"),
        (os, arch) => Err(format!("FMI 2.0 has no name for {os} on {arch}")),
    }
}

/// Writes the SSP of a system of FMUs that lie in the same folder.
fn system(out: &Path, name: &str, units: &[structure::Unit], wires: &[structure::Wire]) -> Result<(), String> {
    let ssd = structure::ssd(name, units, wires).map_err(|error| error.to_string())?;
    let mut entries = Entries::from([("SystemStructure.ssd".to_owned(), ssd.into_bytes())]);
    for unit in units {
        let file = out.join(unit.file);
        let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        entries.insert(format!("resources/{}", unit.file), bytes);
    }
    write(&out.join(format!("{name}.ssp")), &zipped(&entries).map_err(|error| error.to_string())?)
}

fn write(file: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))?;
    println!("{} ({} kB)", file.display(), bytes.len() / 1000);
    Ok(())
}
