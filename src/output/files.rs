//! Atomic writes of the files of a run, with errors that name the file.

use super::folder::FolderRefusal;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Error of writing results.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file or folder could not be written.
    #[error("cannot write {}: {source}. Choose a folder that can be written, with space left on its disk", path.display())]
    Write {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// The folder is not available for this run.
    #[error("cannot write into {}: {refusal}", folder.display())]
    Refused {
        /// Path of the folder.
        folder: PathBuf,
        /// Reason and remedy.
        refusal: FolderRefusal,
    },
}

impl OutputError {
    /// Returns the error of a folder that is not available for this run.
    pub(super) fn refused(folder: &Path, refusal: FolderRefusal) -> Self {
        Self::Refused { folder: folder.to_path_buf(), refusal }
    }
}

/// Returns a function that adds the path to an I/O error.
pub(super) fn with_path(path: &Path) -> impl FnOnce(io::Error) -> OutputError + '_ {
    |source| OutputError::Write { path: path.to_path_buf(), source }
}

/// Writes a temporary file and renames it over `path`: the old file stays intact until the new one is complete, even if the
/// run is killed.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let part = temporary_path(path);
    let written =
        create_temporary(&part).and_then(|mut file| file.write_all(bytes)).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        // The removal may fail for the same reason; the first error is reported.
        drop(fs::remove_file(&part));
        with_path(path)(source)
    })
}

/// Returns the path of the hidden temporary file beside a file: a name that is reserved for gelfmu, whose runs hold the lock of
/// their folder.
fn temporary_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.gelfmu-part"))
}

/// Creates the temporary file in place of a leftover of a killed run; a link is not followed.
fn create_temporary(part: &Path) -> io::Result<File> {
    remove_existing(part)?;
    File::create_new(part)
}

/// Removes a file if present.
pub(super) fn remove(path: &Path) -> Result<(), OutputError> {
    remove_existing(path).map_err(with_path(path))
}

fn remove_existing(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Formats a number of a table with the fewest digits that give the same value when read; a value that is not finite gives an
/// empty cell.
pub(super) fn format_cell(value: f64) -> String {
    if value.is_finite() { format!("{value:e}") } else { String::new() }
}

/// Parses the number of a cell; an empty cell gives NaN.
pub(super) fn parse_cell(cell: &str) -> Result<f64, std::num::ParseFloatError> {
    if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() }
}
