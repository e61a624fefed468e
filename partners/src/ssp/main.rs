//! Packs the gel, its partners, and the systems of them: `cargo run --release --manifest-path partners/Cargo.toml -- OUT_DIR`.

mod archive;
mod description;
mod gel;
mod scene;
mod structure;
mod systems;

#[path = "../body.rs"]
mod body;
#[path = "../plate.rs"]
mod plate;
#[path = "../starts.rs"]
mod starts;
#[path = "../table.rs"]
mod table;

use archive::{Entries, zipped};
use gel::GelCommand;
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, EXE_SUFFIX, OS};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use table::Model;

const USAGE: &str = "usage: ssp [--gelfmu FILE] OUT_DIR [SCENE [ARMOUR_SCENE]]; FILE is the command of the gel (default: beside this \
                     program). Scenes are built-in ones or files: for gel and body (default sphere-block), and with a dome as first \
                     fragment (default partners/armour-block.toml)";
const ARMOUR_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/armour-block.toml");

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
    match pack_systems(std::env::args().skip(1).collect()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

fn pack_systems(mut arguments: Vec<String>) -> Result<(), String> {
    let folder = folder()?;
    let mut gelfmu = folder.join(format!("gelfmu{EXE_SUFFIX}"));
    if let Some(option) = arguments.iter().position(|argument| argument == "--gelfmu") {
        gelfmu = arguments.drain(option..(option + 2).min(arguments.len())).nth(1).ok_or(USAGE)?.into();
    }
    let gel = GelCommand(gelfmu);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        [out] => pack(&gel, &folder, Path::new(out), ["sphere-block", ARMOUR_SCENE]),
        [out, scene] => pack(&gel, &folder, Path::new(out), [scene, ARMOUR_SCENE]),
        [out, scene, armour_scene] => pack(&gel, &folder, Path::new(out), [scene, armour_scene]),
        _ => Err(USAGE.to_owned()),
    }
}

/// Writes everything for a scene, and for a scene with an armour, from the libraries in a folder. Nothing is built and written before
/// both scenes are known to go with the partners.
fn pack(gel: &GelCommand, folder: &Path, out: &Path, scenes: [&str; 2]) -> Result<(), String> {
    let partners = partners(gel, scenes)?;
    build(folder)?;
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    for each in &partners {
        write(&out.join(each.file), &partner(each, folder)?)?;
    }
    let (wires, armour_wires) = (systems::gel_and_body_wires(), systems::gel_armour_and_body_wires());
    let own = systems::gel_and_body("BallisticGel.fmu", systems::BODY);
    let corrected = systems::gel_and_body("BallisticGelCorrected.fmu", systems::BODY);
    let behind_armour = systems::gel_armour_and_body("BallisticGelBehindArmour.fmu");
    let [scene, armour_scene] = scenes;
    for (name, scene, mode, units, wires) in [
        ("gel-and-body", scene, "integrated", own, &wires),
        ("gel-and-body-corrected", scene, "corrected", corrected, &wires),
        ("gel-armour-body", armour_scene, "integrated", behind_armour, &armour_wires),
    ] {
        gel.pack(scene, mode, &out.join(systems::gel_file(&units)))?;
        system(out, name, &units, wires)?;
    }
    Ok(())
}

/// The partners, each with the start values of its scene.
fn partners(gel: &GelCommand, [scene, armour_scene]: [&str; 2]) -> Result<[Partner; 3], String> {
    let (bodies, armour_bodies) = (gel.bodies(scene)?, gel.bodies(armour_scene)?);
    let body = |file, starts| Partner { model: &body::MODEL, library: "rigid_body", file, starts };
    let (name, armour_name) = (named(scene), named(armour_scene));
    let behind = scene::body_starts(&armour_bodies).map_err(&armour_name)?;
    let armour = scene::armour_starts(&armour_bodies).map_err(armour_name)?;
    Ok([
        body(systems::BODY, scene::body_starts(&bodies).map_err(name)?),
        body(systems::BODY_BEHIND_ARMOUR, behind),
        Partner { model: &plate::MODEL, library: "armour", file: systems::ARMOUR, starts: armour },
    ])
}

fn named(scene: &str) -> impl Fn(String) -> String {
    move |error| format!("scene {scene}: {error}")
}

/// The folder of this program, in which cargo puts the command of the gel, too.
fn folder() -> Result<PathBuf, String> {
    let own = std::env::current_exe().map_err(|error| format!("this program has no path: {error}"))?;
    Ok(own.parent().ok_or("this program is in no folder")?.to_path_buf())
}

/// Builds the libraries of the partners, in the profile of this program, if cargo started it.
fn build(folder: &Path) -> Result<(), String> {
    let (Some(cargo), Some(target)) = (std::env::var_os("CARGO"), folder.parent()) else { return Ok(()) };
    let mut cargo = Command::new(cargo);
    cargo.args([
        "build",
        "--quiet",
        "--examples",
        "--manifest-path",
        concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"),
    ]);
    if !cfg!(debug_assertions) {
        cargo.arg("--release");
    }
    run(cargo.arg("--target-dir").arg(target))
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} ended with {status}")) }
}

/// The FMU of a partner, for this host.
fn partner(partner: &Partner, folder: &Path) -> Result<Vec<u8>, String> {
    let Partner { model, library, starts, .. } = partner;
    let file = folder.join("examples").join(format!("{DLL_PREFIX}{library}{DLL_SUFFIX}"));
    let library = fs::read(&file).map_err(|error| {
        format!(
            "{}: {error}; cargo build --release --manifest-path partners/Cargo.toml --examples makes it",
            file.display()
        )
    })?;
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
