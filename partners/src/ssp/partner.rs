//! A partner of the gel and the FMU that is packed of it.

use crate::archive::{Entries, zipped};
use crate::run;
use crate::table::Model;
use crate::{description, starts};
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A partner to be packed.
#[derive(Debug)]
pub struct Partner {
    /// Table and functions.
    pub model: &'static Model,
    /// Name of its library.
    pub library: &'static str,
    /// Name of its FMU.
    pub file: String,
    /// Start values of all components.
    pub starts: Vec<f64>,
}

impl Partner {
    /// Returns the FMU of the partner for this host, with the library in a folder.
    pub fn fmu(&self, folder: &Path) -> Result<Vec<u8>, String> {
        let Self { model, library, starts, .. } = self;
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
}

/// Builds the libraries of the partners, in the profile of this program, if cargo started it.
pub fn build(folder: &Path) -> Result<(), String> {
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

/// Returns FMI 2.0's name of this host.
fn platform() -> Result<&'static str, String> {
    match (OS, ARCH) {
        ("linux", "x86_64") => Ok("linux64"),
        ("linux", "aarch64") => Ok("aarch64-linux"),
        ("windows", "x86_64") => Ok("win64"),
        ("macos", _) => Ok("darwin64"),
        (os, arch) => Err(format!("FMI 2.0 has no name for {os} on {arch}")),
    }
}
