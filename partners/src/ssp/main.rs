//! Packs the gel, its partners, and the systems of them: `cargo run --release --manifest-path partners/Cargo.toml --
//! OUT_DIR`.

mod archive;
mod description;
mod gel;
mod partner;
mod scene;
mod structure;
mod systems;
mod wires;

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
use std::collections::BTreeSet;
use std::env::consts::EXE_SUFFIX;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use systems::SystemPlan;

const USAGE: &str = "usage: ssp [--gelfmu FILE] OUT_DIR [SCENE [ARMOUR_SCENE]]; FILE is the command of the gel \
                     (default: beside this program, or where cargo puts it). Scenes are built-in ones or files: for gel and body (default \
                     sphere-block), and with a dome as first fragment (default partners/armour-block.toml)";
const ARMOUR_SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/armour-block.toml");

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    match pack_systems(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// Packs the systems of the command line. Nothing is built or written before every scene goes with its partners.
fn pack_systems(mut arguments: Vec<String>) -> Result<(), String> {
    let folder = folder()?;
    let mut gelfmu = built_gelfmu(&folder);
    if let Some(option) = arguments.iter().position(|argument| argument == "--gelfmu") {
        gelfmu = arguments.drain(option..(option + 2).min(arguments.len())).nth(1).ok_or(USAGE)?.into();
    }
    let gel = GelCommand(gelfmu);
    if let Some(unknown) = arguments.iter().find(|argument| argument.starts_with('-')) {
        return Err(format!("{unknown}: no such option; {USAGE}"));
    }
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (out, plans) = match arguments.as_slice() {
        [out] => (out, systems::plans(&gel, "sphere-block", ARMOUR_SCENE)?),
        [out, scene] => (out, systems::plans(&gel, scene, ARMOUR_SCENE)?),
        [out, scene, armour_scene] => (out, systems::plans(&gel, scene, armour_scene)?),
        _ => return Err(USAGE.to_owned()),
    };
    let out = Path::new(out);
    partner::build(&folder)?;
    fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let mut written = BTreeSet::new();
    for partner in plans.iter().flat_map(|plan| &plan.partners) {
        if written.insert(&partner.file) {
            write(&out.join(&partner.file), &partner.fmu(&folder)?)?;
        }
    }
    plans.iter().try_for_each(|plan| write_system(&gel, plan, out))
}

/// Returns the command of the gel beside this program, or in the target folder of its package, in the same profile.
fn built_gelfmu(folder: &Path) -> PathBuf {
    let name = format!("gelfmu{EXE_SUFFIX}");
    let beside = folder.join(&name);
    if beside.exists() {
        return beside;
    }
    let profile = folder.file_name().unwrap_or_default();
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../target")).join(profile).join(name)
}

/// Returns the folder of this program, in which cargo puts the libraries of the partners, too.
fn folder() -> Result<PathBuf, String> {
    let own = std::env::current_exe().map_err(|error| format!("this program has no path: {error}"))?;
    Ok(own.parent().ok_or("this program is in no folder")?.to_path_buf())
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} ended with {status}")) }
}

/// Packs the gel of a system, and writes the SSP with all of its FMUs.
fn write_system(gel: &GelCommand, plan: &SystemPlan, out: &Path) -> Result<(), String> {
    let named = |error: std::io::Error| format!("{}: {error}", plan.name);
    let ports = gel.pack(&plan.gel, &out.join(plan.gel_file))?;
    let ssd = structure::ssd(plan.name, &plan.units, &plan.wires, &ports).map_err(named)?;
    let mut entries = Entries::from([("SystemStructure.ssd".to_owned(), ssd.into_bytes())]);
    for unit in &plan.units {
        let file = out.join(&unit.file);
        let bytes = fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        entries.insert(format!("resources/{}", unit.file), bytes);
    }
    write(&out.join(format!("{}.ssp", plan.name)), &zipped(&entries).map_err(|error| error.to_string())?)
}

fn write(file: &Path, bytes: &[u8]) -> Result<(), String> {
    fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))?;
    println!("{} ({} kB)", file.display(), bytes.len() / 1000);
    Ok(())
}
