//! Temporary folder of the unpacked FMU, private to its owner; leftovers of killed runs are removed later.

use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

/// Prefix of the folder names.
const PREFIX: &str = "gelfmu-fmu-";
/// Lock file in such a folder; its lock is held while the run is alive.
const LOCK: &str = "lock";
/// Age at which a folder without a lock file is stale: a living run would have made the file.
const STALE_AGE: Duration = Duration::from_hours(1);
/// Most attempts to make a folder: until it is locked, another run may take it for a stale one.
const MOST_ATTEMPTS: usize = 10;

/// Temporary folder without access for other users; removed on drop, or by a later run.
#[derive(Debug)]
pub struct ScratchFolder {
    /// Lock that marks the run as alive; released before the folder is removed.
    _lock: File,
    folder: TempDir,
}

impl ScratchFolder {
    /// Creates a folder in the system's temporary folder, and removes stale ones of the same user.
    pub fn new() -> io::Result<Self> {
        Self::within(&std::env::temp_dir())
    }

    fn within(place: &Path) -> io::Result<Self> {
        for _ in 0..MOST_ATTEMPTS {
            let folder = create_private_folder(place)?;
            let lock = File::create_new(folder.path().join(LOCK))?;
            if matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
                continue;
            }
            match fs::metadata(folder.path()) {
                // Another run has removed the folder before it was locked.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                own => {
                    remove_stale(place, &own?);
                    return Ok(Self { _lock: lock, folder });
                }
            }
        }
        Err(io::Error::new(io::ErrorKind::ResourceBusy, "other runs remove each new folder"))
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Creates a folder with access for its owner only, whatever the file mode mask is.
fn create_private_folder(place: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    builder.tempdir_in(place)
}

/// Removes folders of killed runs; unreadable ones are left as they are.
fn remove_stale(place: &Path, own: &Metadata) {
    let Ok(entries) = fs::read_dir(place) else { return };
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        if is_own_folder(&path, own)
            && let Some(_stale) = StaleFolder::lock(&path)
        {
            drop(fs::remove_dir_all(&path));
        }
    }
}

/// Returns true if a path is a folder with our prefix and owner, and not a link.
fn is_own_folder(path: &Path, own: &Metadata) -> bool {
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

/// Folder that was found stale; its lock file, if it has one, is locked against other runs while this value lives.
struct StaleFolder {
    /// Lock of the folder; absent if the run was killed before making one.
    _lock: Option<File>,
}

impl StaleFolder {
    fn lock(folder: &Path) -> Option<Self> {
        let path: PathBuf = folder.join(LOCK);
        match OpenOptions::new().read(true).write(true).open(&path) {
            Ok(lock) => lock.try_lock().is_ok().then_some(Self { _lock: Some(lock) }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let age = fs::metadata(folder).and_then(|found| found.modified()).ok()?.elapsed().ok()?;
                (age > STALE_AGE).then_some(Self { _lock: None })
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
