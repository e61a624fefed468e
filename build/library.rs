//! The library inside the FMU: this crate once more, on its own, with what only a whole-program build can do.

use serde_json::Value;
use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The library, built.
pub struct Built {
    /// The file.
    pub file: PathBuf,
    /// What cargo said of every crate that it built for it: JSON, one object in a line.
    pub messages: String,
}

/// Builds the library to be packed, with the feature `bundled`: a program without it packs the library that cargo puts beside it.
pub fn build(out: &Path) -> Result<Option<Built>, String> {
    if env::var_os("CARGO_FEATURE_BUNDLED").is_none() {
        return Ok(None);
    }
    let (host, target) = (variable("HOST")?, variable("TARGET")?);
    let folder = out.join("fmu");
    let mut command = nested_cargo(&folder)?;
    if host != target {
        command.args(["--target", &target]);
    }
    let output = command.stderr(Stdio::inherit()).output();
    let output = output.map_err(|e| format!("cannot run cargo for the library of the FMU: {e}"))?;
    if !output.status.success() {
        let status = output.status;
        return Err(format!(
            "cargo could not build the library of the FMU ({status}); its messages are above. With cargo install, use --locked"
        ));
    }
    let messages = String::from_utf8(output.stdout).map_err(|e| format!("the messages of cargo: {e}"))?;
    let file = messages.lines().find_map(cdylib).ok_or("cargo did not say where it put the library of the FMU")?;
    Ok(Some(Built { file, messages }))
}

/// The dynamic library of the message that says where it is.
fn cdylib(message: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(message).ok()?;
    let kinds = message["target"]["crate_types"].as_array()?;
    let own = message["reason"] == "compiler-artifact" && kinds.iter().any(|kind| kind == "cdylib");
    let files = own.then(|| message["filenames"].as_array())??.iter().filter_map(Value::as_str).map(PathBuf::from);
    files.into_iter().find(|file| file.extension().is_some_and(|e| e == "so" || e == "dll" || e == "dylib"))
}

/// Writes the Rust source that `gelfmu` includes: the library's bytes, where it goes, or that there is none.
pub fn embed(library: Option<&Path>, file: &Path) -> Result<(), String> {
    let bytes = library.map_or("None".to_string(), |path| format!("Some(include_bytes!({}))", literal(path)));
    let platform = platform()?;
    let source = format!(
        "/// The library of the FMU; absent without the feature `bundled`.\n\
         pub const LIBRARY: Option<&[u8]> = {bytes};\n\
         /// Its path inside the archive.\n\
         pub const LIBRARY_PATH: &str = {platform:?};\n"
    );
    fs::write(file, source).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

fn nested_cargo(folder: &Path) -> Result<Command, String> {
    let mut command = Command::new(env::var_os("CARGO").ok_or("CARGO is not set: run by cargo")?);
    command.args(["rustc", "--quiet", "--locked", "--offline", "--profile", "fmu", "--lib", "--crate-type", "cdylib"]);
    command.args(["--no-default-features", "--message-format", "json-render-diagnostics", "--target-dir"]).arg(folder);
    for (key, _) in env::vars_os().filter(|(key, _)| inherited(key)) {
        command.env_remove(key);
    }
    command.env("CARGO_ENCODED_RUSTFLAGS", flags(folder)?);
    Ok(command)
}

/// Whether a variable describes the outer build, so that the nested one must not see it.
fn inherited(key: &OsString) -> bool {
    let key = key.to_string_lossy();
    key.starts_with("CARGO_FEATURE_")
        || key.starts_with("CARGO_CFG_")
        || matches!(&*key, "RUSTFLAGS" | "CARGO_BUILD_TARGET" | "CARGO_TARGET_DIR" | "CARGO_BUILD_RUSTFLAGS")
}

/// The flags of the outer build, and no folder of this machine in the binary.
fn flags(folder: &Path) -> Result<String, String> {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home =
        home.or_else(|| env::home_dir().map(|h| h.join(".cargo"))).ok_or("neither CARGO_HOME nor HOME is set")?;
    let mut flags: Vec<String> = env::var("CARGO_ENCODED_RUSTFLAGS").into_iter().filter(|f| !f.is_empty()).collect();
    flags.push(format!("--remap-path-prefix={}=/cargo", home.display()));
    flags.push(format!("--remap-path-prefix={}=/ballistic-gel", variable("CARGO_MANIFEST_DIR")?));
    flags.push(format!("--remap-path-prefix={}=/build", folder.display()));
    Ok(flags.join("\u{1f}"))
}

/// The path as a string of Rust source.
pub fn literal(path: &Path) -> String {
    format!("{:?}", path.display().to_string())
}

fn platform() -> Result<String, String> {
    let (os, arch) = (variable("CARGO_CFG_TARGET_OS")?, variable("CARGO_CFG_TARGET_ARCH")?);
    let (folder, extension) = match (os.as_str(), arch.as_str()) {
        ("linux", "x86_64") => ("linux64".to_string(), "so"),
        ("windows", "x86_64") => ("win64".to_string(), "dll"),
        ("macos", "x86_64") => ("darwin64".to_string(), "dylib"),
        ("macos", _) => (format!("{arch}-darwin"), "dylib"),
        (_, _) => (format!("{arch}-{os}"), "so"),
    };
    Ok(format!("binaries/{folder}/BallisticGel.{extension}"))
}

fn variable(name: &str) -> Result<String, String> {
    env::var(name).map_err(|e| format!("{name}: {e}: run by cargo"))
}
