//! The libraries of the FMU: those inside this program, or the one that a development build leaves beside it.

use crate::failure::{CommandError, RunError};
use ballistic_gel::fmi2::SOURCE_STAMP;
use memchr::memmem;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::io::{Cursor, ErrorKind, Read};
use std::path::PathBuf;
use zip::ZipArchive;

mod bundled {
    include!(concat!(env!("OUT_DIR"), "/bundled.rs"));
}

/// Path of the library of this platform inside the archive.
pub const LIBRARY_PATH: &str = bundled::LIBRARY_PATH;
/// Command that installs a program with the library of a release inside.
pub const INSTALLATION: &str = "cargo install --path . --locked --features bundled";
/// Platforms of a release, by their names in FMI.
pub const PLATFORMS: [&str; 4] = ["aarch64-linux", "darwin64", "linux64", "win64"];

/// Compressed libraries, by their paths in the FMU.
type LibraryArchive = ZipArchive<Cursor<&'static [u8]>>;

/// Dynamic libraries with the FMI 2.0 interface, to be packed.
#[derive(Debug)]
pub struct PackedLibraries {
    /// Path below `binaries/` and content of each.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Archive that holds them compressed; `None` in a development build: the same bits, without whole-program optimization.
    pub archive: Option<LibraryArchive>,
}

/// Name of the platform of a path in the FMU, `binaries/linux64/BallisticGel.so`.
fn platform_of(path: &str) -> &str {
    path.split('/').nth(1).unwrap_or_default()
}

/// Name of this platform in FMI.
pub fn own_platform() -> &'static str {
    platform_of(LIBRARY_PATH)
}

/// Platforms whose libraries this program can pack, ascending.
pub fn platforms() -> Vec<String> {
    let Some(archive) = archive() else { return vec![own_platform().to_owned()] };
    paths(&archive).iter().map(|path| platform_of(path).to_owned()).collect()
}

/// Version of this program, and the platforms whose libraries it can pack.
pub fn long_version() -> String {
    format!("{}\nlibraries of the FMU: {}", env!("CARGO_PKG_VERSION"), platforms().join(", "))
}

/// The compressed libraries inside this program.
fn archive() -> Option<LibraryArchive> {
    let archive = ZipArchive::new(Cursor::new(bundled::LIBRARIES?));
    Some(archive.expect("the build script has written this archive"))
}

/// Paths in the FMU of the libraries in an archive, ascending.
fn paths(archive: &LibraryArchive) -> Vec<String> {
    let mut paths: Vec<String> = archive.file_names().flatten().map(Cow::into_owned).collect();
    paths.sort_unstable();
    paths
}

/// Checks the platforms that were asked for.
///
/// # Errors
/// The first that this program has no library of.
pub fn check_platforms(asked: &[String]) -> Result<(), CommandError> {
    let inside = platforms();
    let Some(missing) = asked.iter().find(|platform| !inside.contains(platform)) else { return Ok(()) };
    let remedy = "build/platforms.sh makes the others, and cargo build --release --features bundled puts them inside";
    Err(CommandError::BadInput(format!(
        "--platforms: found {missing}, expected of {}, the libraries inside this gelfmu; {remedy}",
        inside.join(", ")
    )))
}

impl PackedLibraries {
    /// Finds the libraries of these platforms, which are checked.
    ///
    /// # Errors
    /// If none is inside this program and none of the same sources can be read beside it.
    pub fn find(platforms: &[String]) -> Result<Self, RunError> {
        let Some(mut archive) = archive() else {
            let files = beside_this_program().map_err(|error| missing(&format!("its own path is unknown: {error}")))?;
            let bytes = stamped(&files).map_err(|reason| missing(&reason))?;
            return Ok(Self { files: BTreeMap::from([(below_binaries(LIBRARY_PATH), bytes)]), archive: None });
        };
        let mut files = BTreeMap::new();
        for path in
            paths(&archive).into_iter().filter(|path| platforms.iter().any(|platform| platform == platform_of(path)))
        {
            let mut bytes = vec![];
            let read = archive.by_name(&path).and_then(|mut file| Ok(file.read_to_end(&mut bytes)?));
            read.map_err(|error| missing(&format!("{path} inside it: {error}")))?;
            files.insert(below_binaries(&path), bytes);
        }
        Ok(Self { files, archive: Some(archive) })
    }

    /// Platforms of these libraries, ascending.
    pub fn platforms(&self) -> Vec<String> {
        self.files.keys().map(|path| path.split('/').next().unwrap_or_default().to_owned()).collect()
    }

    /// Name and version of the tool that makes the archive, for `generationTool`.
    pub fn tool(&self) -> &'static str {
        if self.archive.is_some() {
            concat!("gelfmu ", env!("CARGO_PKG_VERSION"))
        } else {
            concat!("gelfmu ", env!("CARGO_PKG_VERSION"), " (development)")
        }
    }
}

/// Path below `binaries/` of a path in the FMU.
fn below_binaries(path: &str) -> String {
    path.strip_prefix("binaries/").unwrap_or(path).to_owned()
}

/// Paths of the library that cargo makes together with this program: `cargo test` leaves it in `deps/` alone.
fn beside_this_program() -> std::io::Result<[PathBuf; 2]> {
    let name = format!("{DLL_PREFIX}{}{DLL_SUFFIX}", env!("CARGO_PKG_NAME").replace('-', "_"));
    let program = std::env::current_exe()?;
    Ok([program.with_file_name("deps").join(&name), program.with_file_name(name)])
}

/// Reads the first of these files that was built from the sources of this program.
fn stamped(files: &[PathBuf]) -> Result<Vec<u8>, String> {
    let mut found = vec![];
    for file in files {
        match std::fs::read(file) {
            Ok(bytes) if memmem::find(&bytes, SOURCE_STAMP.as_bytes()).is_some() => return Ok(bytes),
            Ok(_) => found.push(format!("{} was built from other sources", file.display())),
            Err(error) if error.kind() == ErrorKind::NotFound => found.push(format!("no {}", file.display())),
            Err(error) => found.push(format!("{} cannot be read: {error}", file.display())),
        }
    }
    Err(found.join(", "))
}

fn missing(reason: &str) -> RunError {
    let reason = format!(
        "the library of the FMU is neither inside this gelfmu nor beside it ({reason}): build both with cargo build, or install a \
         gelfmu that holds its library with {INSTALLATION}"
    );
    RunError::Component { call: "pack", reason }
}

#[cfg(test)]
mod tests {
    use super::{SOURCE_STAMP, stamped};

    #[test]
    fn a_library_of_other_sources_is_refused_and_one_of_these_is_found_behind_it() {
        let folder = tempfile::tempdir().unwrap();
        let [none, stale, present] = ["none.so", "stale.so", "present.so"].map(|name| folder.path().join(name));
        let mut other = SOURCE_STAMP.to_owned();
        other.pop();
        std::fs::write(&stale, [b"\x7fELF\xff".as_slice(), other.as_bytes(), b"\xff"].concat()).unwrap();
        let bytes = [b"\x7fELF\xff".as_slice(), SOURCE_STAMP.as_bytes(), b"\xff"].concat();
        std::fs::write(&present, &bytes).unwrap();
        assert_eq!(stamped(&[none.clone(), stale.clone(), present]).unwrap(), bytes);
        let refused = stamped(&[none.clone(), stale.clone()]).unwrap_err();
        let expected = format!("no {}, {} was built from other sources", none.display(), stale.display());
        assert_eq!(refused, expected);
    }
}
