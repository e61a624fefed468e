//! Stamp of the sources of the library: a hash that differs whenever one of their files does.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::io;
use std::path::{Path, PathBuf};

/// Files and folders that determine the library. Modules of the command, `src/bin`, do not.
const SOURCES: [&str; 9] =
    ["build.rs", "build", "modelDescription", "projectiles", "reduced", "scenes", "src", "Cargo.toml", "Cargo.lock"];
const COMMAND: &str = "src/bin";

/// Has cargo run the build script again after a change of the sources, and compile their hash into the library and the command; returns it.
pub fn export() -> io::Result<String> {
    let mut hasher = DefaultHasher::new();
    let folder = fs::read_dir("src")?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    let watched = SOURCES.into_iter().filter(|source| *source != "src").map(PathBuf::from).chain(folder);
    for path in watched.filter(|path| path != Path::new(COMMAND)) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    SOURCES.into_iter().try_for_each(|source| hash(Path::new(source), &mut hasher))?;
    let stamp = format!("{:016x}", hasher.finish());
    println!("cargo::rustc-env=BALLISTIC_GEL_SOURCES={stamp}");
    Ok(stamp)
}

/// Hashes names and contents of a file, or of the files in a folder in the order of their names.
fn hash(path: &Path, hasher: &mut DefaultHasher) -> io::Result<()> {
    if path == Path::new(COMMAND) {
        return Ok(());
    }
    hasher.write(path.as_os_str().as_encoded_bytes());
    if path.is_dir() {
        let mut entries = fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
        entries.sort();
        return entries.iter().try_for_each(|entry| hash(entry, hasher));
    }
    let bytes = fs::read(path)?;
    hasher.write_usize(bytes.len());
    hasher.write(&bytes);
    Ok(())
}
