//! Files of a run: written whole, removed when a run starts afresh, and named when that fails.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}. Choose a folder that can be written, with space left on its disk")]
pub struct OutputError {
    /// The file or folder.
    pub path: PathBuf,
    /// Why.
    pub source: io::Error,
}

/// Extension of a file that is not yet whole.
const PART: &str = "part";

/// Names the file that an I/O error is about.
pub(super) fn naming(path: &Path) -> impl FnOnce(io::Error) -> OutputError + '_ {
    |source| OutputError { path: path.to_path_buf(), source }
}

/// Writes a whole file: the old one is there until the new one is whole, also for who kills the run in between.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let part = path.with_extension(PART);
    let written = fs::write(&part, bytes).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        // What cannot be written cannot always be removed, either; the first error says why.
        drop(fs::remove_file(&part));
        naming(path)(source)
    })
}

/// Makes the folder and holds it for one run, as long as the handle lives.
///
/// Where the system locks no folders, the run goes on without this protection.
///
/// # Errors
/// [`OutputError`] when the folder cannot be made, or another run holds it.
pub fn claim(folder: &Path) -> Result<Option<File>, OutputError> {
    fs::create_dir_all(folder).map_err(naming(folder))?;
    let Ok(handle) = File::open(folder) else { return Ok(None) };
    match handle.try_lock() {
        Ok(()) => Ok(Some(handle)),
        Err(TryLockError::WouldBlock) => {
            Err(naming(folder)(io::Error::new(io::ErrorKind::ResourceBusy, "another run is writing there")))
        }
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// Makes the folder and removes what an earlier run left in it; files of other names stay.
pub(super) fn clear(folder: &Path) -> Result<(), OutputError> {
    let frames = folder.join("frames");
    fs::create_dir_all(&frames).map_err(naming(&frames))?;
    for name in ["history.csv", "series.pvd", "summary.json", "report.html", "shot.csv", "cavity.csv"] {
        remove(&folder.join(name))?;
        remove(&folder.join(name).with_extension(PART))?;
    }
    for entry in fs::read_dir(&frames).map_err(naming(&frames))? {
        let path = entry.map_err(naming(&frames))?.path();
        if is_frame(&path) {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Removes a file that may be absent.
pub(super) fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(naming(path)(error)),
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

fn is_frame(path: &Path) -> bool {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    path.extension().is_some_and(|extension| extension == "vtu" || extension == PART)
        && (stem.starts_with("frame_") || stem.starts_with("projectile_"))
}
