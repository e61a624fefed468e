//! The libraries of the FMU inside the command: this crate once more, on its own, without what only the command needs,
//! and those that `build/platforms.sh` has made of the same sources for other platforms.

use serde_json::Value;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Folder of the libraries for other platforms, each in a folder with the name of its platform in FMI; the variable
/// [`PLATFORMS_VARIABLE`] names another one.
const PLATFORMS: &str = "target/platforms/binaries";
const PLATFORMS_VARIABLE: &str = "BALLISTIC_GEL_PLATFORMS";

/// The libraries of a release.
pub struct Release {
    /// The files by their paths in the FMU.
    pub libraries: BTreeMap<String, PathBuf>,
    /// Messages of cargo about the crates of this platform's library: JSON, one object per line.
    pub messages: String,
}

/// Returns the libraries to be packed, with the feature `bundled`: a program without it packs the library that cargo puts beside it.
/// The library of this platform is built unless `build/platforms.sh` has made one, which runs on older systems, too.
pub fn collect(out: &Path, stamp: &str) -> Result<Option<Release>, String> {
    if env::var_os("CARGO_FEATURE_BUNDLED").is_none() {
        return Ok(None);
    }
    let mut libraries = made(stamp)?;
    let messages = match libraries.entry(own_path()?) {
        Entry::Occupied(_) => cargo(out, &["check"])?,
        Entry::Vacant(own) => {
            let start = Instant::now();
            let messages = cargo(out, &["rustc", "--crate-type", "cdylib"])?;
            let seconds = start.elapsed().as_secs();
            println!("cargo::warning=the library of the FMU took {seconds} s; the command follows");
            let file = messages.lines().find_map(cdylib);
            own.insert(file.ok_or("cargo did not say where it put the library of the FMU")?);
            messages
        }
    };
    Ok(Some(Release { libraries, messages }))
}

/// Runs a command of cargo for the library of the FMU, and returns its messages.
fn cargo(out: &Path, action: &[&str]) -> Result<String, String> {
    let (host, target) = (variable("HOST")?, variable("TARGET")?);
    let mut command = nested_cargo(action, &out.join("fmu"))?;
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
    String::from_utf8(output.stdout).map_err(|e| format!("the messages of cargo: {e}"))
}

/// The dynamic library of the message that says where it is.
fn cdylib(message: &str) -> Option<PathBuf> {
    let message: Value = serde_json::from_str(message).ok()?;
    let kinds = message["target"]["crate_types"].as_array()?;
    let own = message["reason"] == "compiler-artifact" && kinds.iter().any(|kind| kind == "cdylib");
    let files = own.then(|| message["filenames"].as_array())??.iter().filter_map(Value::as_str).map(PathBuf::from);
    files.into_iter().find(|file| file.extension().is_some_and(|e| e == "so" || e == "dll" || e == "dylib"))
}

/// Returns the libraries that `build/platforms.sh` has made and that hold the stamp of the sources, by their paths in the FMU.
fn made(stamp: &str) -> Result<BTreeMap<String, PathBuf>, String> {
    println!("cargo::rerun-if-env-changed={PLATFORMS_VARIABLE}");
    let platforms = env::var(PLATFORMS_VARIABLE).unwrap_or_else(|_| PLATFORMS.to_owned());
    fs::create_dir_all(&platforms).map_err(|e| format!("cannot make {platforms}: {e}"))?;
    println!("cargo::rerun-if-changed={platforms}");
    let mut libraries = BTreeMap::new();
    let unreadable = |e: std::io::Error| format!("cannot read {platforms}: {e}");
    for folder in fs::read_dir(&platforms).map_err(unreadable)? {
        for file in fs::read_dir(folder.map_err(unreadable)?.path()).map_err(unreadable)? {
            let file = file.map_err(unreadable)?.path();
            let bytes = fs::read(&file).map_err(unreadable)?;
            if bytes.windows(stamp.len()).any(|text| text == stamp.as_bytes()) {
                let path = file.strip_prefix(&platforms).unwrap_or(&file).to_string_lossy().replace('\\', "/");
                libraries.insert(format!("binaries/{path}"), file);
            } else {
                println!("cargo::warning={} is of other sources and left out: run build/platforms.sh", file.display());
            }
        }
    }
    Ok(libraries)
}

/// Writes the Rust source that `gelfmu` includes: the archive of the libraries by their paths in the FMU, none in a development
/// build, and the path of that of this platform.
pub fn embed(libraries: &BTreeMap<String, PathBuf>, out: &Path) -> Result<(), String> {
    let archive = out.join("libraries.zip");
    let bytes = if libraries.is_empty() {
        "None".to_string()
    } else {
        let zipped = zipped(libraries).map_err(|e| format!("cannot compress the libraries: {e}"))?;
        fs::write(&archive, zipped).map_err(|e| format!("cannot write {}: {e}", archive.display()))?;
        format!("Some(include_bytes!({}))", literal(&archive))
    };
    let own = own_path()?;
    let source = format!(
        "/// ZIP archive of the libraries of the FMU by their paths in it; absent without the feature `bundled`.\n\
         pub const LIBRARIES: Option<&[u8]> = {bytes};\n\
         /// Path of the library of this platform in the FMU.\n\
         pub const LIBRARY_PATH: &str = {own:?};\n"
    );
    let file = out.join("bundled.rs");
    fs::write(&file, source).map_err(|e| format!("cannot write {}: {e}", file.display()))
}

/// Compresses the libraries as they are in the FMU, without times and owners.
fn zipped(libraries: &BTreeMap<String, PathBuf>) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, file) in libraries {
        zip.start_file(path.as_str(), options)?;
        zip.write_all(&fs::read(file)?)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn nested_cargo(action: &[&str], folder: &Path) -> Result<Command, String> {
    let mut command = Command::new(env::var_os("CARGO").ok_or("CARGO is not set: run by cargo")?);
    command.args(action).args(["--quiet", "--locked", "--offline", "--profile", "fmu", "--lib"]);
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

/// Path of the library of this platform in the FMU.
fn own_path() -> Result<String, String> {
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
