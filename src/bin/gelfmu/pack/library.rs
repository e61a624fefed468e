//! The library of the FMU: the one inside this program, or the one that a development build leaves beside it.

use crate::failure::RunError;
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
    /// If none is inside this program, and none stands beside it or the first one there cannot be read.
    pub fn find() -> Result<Self, RunError> {
        if let Some(bytes) = bundled::LIBRARY {
            return Ok(Self { bytes: Cow::Borrowed(bytes), is_development: false });
        }
        let files = beside_this_program().map_err(|error| missing(&format!("its own path is unknown: {error}")))?;
        for path in &files {
            match std::fs::read(path) {
                Ok(bytes) => return Ok(Self { bytes: Cow::Owned(bytes), is_development: true }),
                Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {}
                Err(source) => return Err(RunError::File { verb: "read", path: path.clone(), source }),
            }
        }
        Err(missing(&format!("no {}", files[1].display())))
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

/// Paths of the library that cargo makes together with this program. `cargo test` leaves it in `deps/` alone, where the copy beside the
/// program, if there is one, is older.
fn beside_this_program() -> std::io::Result<[PathBuf; 2]> {
    let name = format!("{DLL_PREFIX}{}{DLL_SUFFIX}", env!("CARGO_PKG_NAME").replace('-', "_"));
    let program = std::env::current_exe()?;
    Ok([program.with_file_name("deps").join(&name), program.with_file_name(name)])
}

fn missing(reason: &str) -> RunError {
    let reason = format!(
        "the library of the FMU is neither inside this gelfmu nor beside it ({reason}): install one that holds it with {INSTALLATION}"
    );
    RunError::Component { call: "pack", reason }
}
