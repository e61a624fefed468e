//! The library of the FMU: the one inside this program, or the one that a development build leaves beside it.

use crate::failure::RunError;
use ballistic_gel::fmi2::SOURCE_STAMP;
use memchr::memmem;
use std::borrow::Cow;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::io::ErrorKind;
use std::path::PathBuf;

mod bundled {
    include!(concat!(env!("OUT_DIR"), "/bundled.rs"));
}

/// Path of the library inside the archive.
pub const LIBRARY_PATH: &str = bundled::LIBRARY_PATH;
/// Command that installs a program with the library of a release inside.
pub const INSTALLATION: &str = "cargo install --path . --locked --features bundled";

/// A dynamic library with the FMI 2.0 interface.
#[derive(Debug)]
pub struct PackedLibrary {
    /// Content of its file.
    pub bytes: Cow<'static, [u8]>,
    /// True for the library of a development build: the same bits, without whole-program optimization.
    pub is_development: bool,
}

impl PackedLibrary {
    /// Finds the library to pack.
    ///
    /// # Errors
    /// If none is inside this program and none of the same sources can be read beside it.
    pub fn find() -> Result<Self, RunError> {
        if let Some(bytes) = bundled::LIBRARY {
            return Ok(Self { bytes: Cow::Borrowed(bytes), is_development: false });
        }
        let files = beside_this_program().map_err(|error| missing(&format!("its own path is unknown: {error}")))?;
        let bytes = stamped(&files).map_err(|reason| missing(&reason))?;
        Ok(Self { bytes: Cow::Owned(bytes), is_development: true })
    }

    /// Name and version of the tool that makes the archive, for `generationTool`.
    pub fn tool(&self) -> &'static str {
        if self.is_development {
            concat!("gelfmu ", env!("CARGO_PKG_VERSION"), " (development)")
        } else {
            concat!("gelfmu ", env!("CARGO_PKG_VERSION"))
        }
    }
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
