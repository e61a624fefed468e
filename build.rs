//! Makes the table of variables from `modelDescription/variables.toml` and, for the command, the libraries to be packed and their licences.

#[path = "build/library.rs"]
mod library;
#[path = "build/licenses.rs"]
mod licenses;
#[path = "build/stamp.rs"]
mod stamp;
#[path = "build/variables.rs"]
mod variables;

use std::env;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    for path in licenses::license_files(Path::new(".")).unwrap_or_default() {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    match prepare() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            println!("cargo::error={}", message.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn prepare() -> Result<(), String> {
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("OUT_DIR is not set: run by cargo")?);
    let stamp = stamp::export().map_err(|e| format!("cannot read the sources: {e}"))?;
    pin_library();
    variables::generate("modelDescription/variables.toml", &out.join("variables.rs"))?;
    if env::var_os("CARGO_FEATURE_CLI").is_some() {
        let release = library::collect(&out, &stamp)?;
        let messages = release.as_ref().map(|release| release.messages.as_str());
        licenses::collect(messages, &out)?;
        library::embed(&release.map(|release| release.libraries).unwrap_or_default(), &out)?;
    }
    Ok(())
}

/// Keeps the library mapped until the process ends: a worker may still run its last instructions after it was joined.
fn pin_library() {
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}
