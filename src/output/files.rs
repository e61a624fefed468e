//! Files of a run: written whole, and named when that fails.

use super::folder::FolderRefusal;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Results that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file or folder could not be written.
    #[error("cannot write {}: {source}. Choose a folder that can be written, with space left on its disk", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The folder is not for this run.
    #[error("cannot write into {}: {refusal}", folder.display())]
    Refused {
        /// The folder.
        folder: PathBuf,
        /// Why not, and what helps.
        refusal: FolderRefusal,
    },
}

impl OutputError {
    /// A folder that is not for this run.
    pub(super) fn refused(folder: &Path, refusal: FolderRefusal) -> Self {
        Self::Refused { folder: folder.to_path_buf(), refusal }
    }
}

/// Names the file that an I/O error is about.
pub(super) fn naming(path: &Path) -> impl FnOnce(io::Error) -> OutputError + '_ {
    |source| OutputError::Write { path: path.to_path_buf(), source }
}

/// Writes a whole file: the old one is there until the new one is whole, also for who kills the run in between.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let part = part(path);
    let written = begin(&part).and_then(|mut file| file.write_all(bytes)).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        // What cannot be written cannot always be removed, either; the first error says why.
        drop(fs::remove_file(&part));
        naming(path)(source)
    })
}

/// The hidden file beside a file, in which it is written: a name that nobody else gives a file.
fn part(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.gelfmu-part"))
}

/// A new file, instead of one that a killed run has left; a link is not followed.
fn begin(part: &Path) -> io::Result<File> {
    remove_existing(part)?;
    File::create_new(part)
}

/// Removes a file that may be absent.
pub(super) fn remove(path: &Path) -> Result<(), OutputError> {
    remove_existing(path).map_err(naming(path))
}

fn remove_existing(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// A number of a table with every digit; a cell without a value is empty, as in one of what is not known.
pub(super) fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:e}") } else { String::new() }
}

/// The number of a cell; not a number where it is empty.
pub(super) fn number(cell: &str) -> Result<f64, std::num::ParseFloatError> {
    if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() }
}
