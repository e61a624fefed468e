//! Folder of the unpacked FMU: for its owner alone, and gone also after a run that was killed.

use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

/// Beginning of the names of these folders.
const PREFIX: &str = "gelfmu-fmu-";
/// File in such a folder whose lock says that its run is alive.
const LOCK: &str = "lock";
/// A folder without that file belongs to a run that is just making it, or was killed then.
const LONGEST_START: Duration = Duration::from_hours(1);
/// Attempts to make a folder, if another run takes the new one for a stale one.
const ATTEMPTS: usize = 10;

/// A temporary folder that no other user can read or write. It is removed when it is dropped, or by a later run.
#[derive(Debug)]
pub struct ScratchFolder {
    /// Says that the run is alive; let go before the folder is removed.
    _lock: File,
    folder: TempDir,
}

impl ScratchFolder {
    /// A new one in the folder for temporary files. Stale ones of the same user are removed.
    pub fn new() -> io::Result<Self> {
        Self::within(&std::env::temp_dir())
    }

    fn within(place: &Path) -> io::Result<Self> {
        for _ in 0..ATTEMPTS {
            let folder = private(place)?;
            let lock = File::create_new(folder.path().join(LOCK))?;
            if !matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
                remove_stale(place, &fs::metadata(folder.path())?);
                return Ok(Self { _lock: lock, folder });
            }
        }
        Err(io::Error::new(io::ErrorKind::ResourceBusy, "other runs remove each new folder"))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// A new folder that is its owner's alone, whatever the file mode mask is.
fn private(place: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    builder.tempdir_in(place)
}

/// Removes folders of runs that were killed. What cannot be looked at or removed is left as it is.
fn remove_stale(place: &Path, own: &Metadata) {
    let Ok(entries) = fs::read_dir(place) else { return };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if is_candidate(&path, own)
            && let Some(_stale) = StaleFolder::of(&path)
        {
            drop(fs::remove_dir_all(&path));
        }
    }
}

/// Returns true for a folder of our name and our user, and no link to one.
fn is_candidate(path: &Path, own: &Metadata) -> bool {
    let named = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX));
    named && fs::symlink_metadata(path).is_ok_and(|found| found.is_dir() && has_same_owner(&found, own))
}

#[cfg(unix)]
fn has_same_owner(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    one.uid() == other.uid()
}

#[cfg(not(unix))]
fn has_same_owner(_: &Metadata, _: &Metadata) -> bool {
    true
}

/// A folder whose run is not alive; no run can take it as long as this value lives.
struct StaleFolder {
    /// Absent where the run was killed before it made one.
    _lock: Option<File>,
}

impl StaleFolder {
    fn of(folder: &Path) -> Option<Self> {
        let path: PathBuf = folder.join(LOCK);
        match OpenOptions::new().read(true).write(true).open(&path) {
            Ok(lock) => lock.try_lock().is_ok().then_some(Self { _lock: Some(lock) }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let age = fs::metadata(folder).and_then(|found| found.modified()).ok()?.elapsed().ok()?;
                (age > LONGEST_START).then_some(Self { _lock: None })
            }
            Err(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn the_unpacked_fmu_is_for_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let place = tempfile::tempdir().unwrap();
        let scratch = ScratchFolder::within(place.path()).unwrap();
        let mode = fs::metadata(scratch.path()).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o700, "{mode:o}");
    }

    #[test]
    fn folders_of_killed_runs_are_removed_and_those_of_living_runs_and_others_stay() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        let alive = ScratchFolder::within(place.path()).unwrap();
        for name in ["gelfmu-fmu-killed", "gelfmu-fmu-beginning", "somebody-else"] {
            fs::create_dir_all(at(name).join("unpacked")).unwrap();
        }
        for name in ["gelfmu-fmu-killed", "somebody-else"] {
            fs::write(at(name).join(LOCK), "").unwrap();
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(at("somebody-else"), at("gelfmu-fmu-link")).unwrap();
        drop(ScratchFolder::within(place.path()).unwrap());
        assert!(!at("gelfmu-fmu-killed").exists());
        assert!(at("gelfmu-fmu-beginning").exists() && at("somebody-else/lock").exists() && alive.path().exists());
        let path = alive.path().to_path_buf();
        drop(alive);
        assert!(!path.exists());
    }
}
