//! The gel's FMU for a system: packed by `gelfmu`, its one Enumeration described as the Integer that it is in C.
//!
//! FMI 2.0 sets an Enumeration by `fmi2SetInteger`, but the SSP readers of libcosim and Ecos know no Enumerations and could
//! not choose `coupling.mode`.

use crate::archive::{Entries, unzipped, zipped};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

const DESCRIPTION: &str = "modelDescription.xml";
const ENUMERATION: &str = "<Enumeration declaredType=\"CouplingMode\"";

/// Packs the scene, by name or path, with the command that was built.
pub fn pack(gelfmu: &Path, scene: &str, file: &Path) -> Result<(), String> {
    let mut command = Command::new(gelfmu);
    command.args(["--quiet", "pack", "--scene", scene, "--out"].map(OsStr::new)).arg(file);
    super::run(&mut command)?;
    let say = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let mut entries = unzipped(&fs::read(file).map_err(|error| say(&error))?).map_err(|error| say(&error))?;
    describe_mode(&mut entries).map_err(|error| say(&error))?;
    super::write(file, &zipped(&entries).map_err(|error| say(&error))?)
}

fn describe_mode(entries: &mut Entries) -> Result<(), String> {
    let xml = entries.get_mut(DESCRIPTION).ok_or_else(|| format!("there is no {DESCRIPTION}"))?;
    let text = std::str::from_utf8(xml).map_err(|error| format!("{DESCRIPTION}: {error}"))?;
    match text.matches(ENUMERATION).count() {
        1 => *xml = text.replace(ENUMERATION, "<Integer").into_bytes(),
        n => return Err(format!("{DESCRIPTION}: found {n} variables of type CouplingMode, expected 1")),
    }
    Ok(())
}
