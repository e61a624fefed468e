//! `gelfmu.jsonl`: manifest and lock of a result folder. The manifest is a journal with one JSON object per line.

use crate::output::reading::expect_regular;
use same_file::Handle;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Component, Path};
use std::thread::sleep;
use std::time::Duration;

/// File name of the manifest.
pub(super) const MANIFEST: &str = "gelfmu.jsonl";
/// Name of the hidden staging folder for a run that replaces an earlier run.
pub(super) const STAGING: &str = ".gelfmu-new";
/// Limit of the length of a manifest, bytes: a run of 10 000 frames writes 1 MB, each replacing run a few lines.
const MAX_MANIFEST_BYTES: u64 = 1 << 26;
/// Number of attempts at the lock: another process holds it for a moment while checking the folder.
const LOCK_ATTEMPTS: usize = 25;
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// State of a result folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FolderState {
    /// Claimed by a process without results.
    Claimed,
    /// Files are being written, or the process was killed.
    Running,
    /// The run reached its end.
    Complete,
    /// The run was ended early and kept its results.
    Interrupted,
    /// The run failed, or its files could not be written any more.
    Failed,
}

/// Line of the journal.
#[derive(Debug, Default, Serialize, Deserialize)]
struct JournalLine {
    /// Command that made the folder; in the first line alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    results_of: Option<String>,
    /// Release that wrote the first line.
    #[serde(skip_serializing_if = "Option::is_none")]
    version: Option<String>,
    /// New state of the folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<FolderState>,
    /// Process whose FMU may adopt the claim.
    #[serde(skip_serializing_if = "Option::is_none")]
    process: Option<u32>,
    /// File listed from now on; path relative to the folder, with `/`.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    /// File no longer listed.
    #[serde(skip_serializing_if = "Option::is_none")]
    removed: Option<String>,
    /// Digest of the scene of the results from now on.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<String>,
}

/// Contents of a manifest.
#[derive(Debug, Clone, Default)]
pub(super) struct FolderContents {
    /// Command that made the folder; `None` before the first line.
    pub(super) command: Option<String>,
    /// Last state.
    pub(super) state: Option<FolderState>,
    /// Process that handed the claim over to its FMU.
    pub(super) process: Option<u32>,
    /// Listed files.
    pub(super) files: BTreeSet<String>,
    /// Release that wrote the first line.
    pub(super) version: Option<String>,
    /// Digest of the scene of the results.
    pub(super) scene: Option<String>,
}

/// Open manifest; holds the lock, if acquired, until it is dropped.
#[derive(Debug)]
pub(super) struct FolderManifest {
    file: File,
    pub(super) contents: FolderContents,
}

/// Error of opening or reading a manifest.
#[derive(Debug)]
pub(super) enum JournalError {
    /// The manifest cannot be read or written.
    Io(io::Error),
    /// Number of the line that is invalid in a manifest.
    Line(usize),
}

impl From<io::Error> for JournalError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Outcome of an attempt at the lock of a manifest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LockOutcome {
    /// The lock is acquired, or the system has no locks here.
    Held,
    /// Another run holds the lock.
    Busy,
}

impl FolderManifest {
    /// Creates the manifest of a folder without one, exclusively, and claims the folder for this process.
    ///
    /// # Errors
    /// `AlreadyExists` if another process was faster.
    pub(super) fn create(folder: &Path, command: &str) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(folder.join(MANIFEST))?;
        if lock_new(&file) == LockOutcome::Busy {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        let mut manifest = Self { file, contents: FolderContents::default() };
        manifest.write_head(command).inspect_err(|_| {
            // Only the first error is reported; the next run takes a manifest without a line over.
            drop(fs::remove_file(folder.join(MANIFEST)));
        })?;
        Ok(manifest)
    }

    /// Writes the first lines.
    pub(super) fn write_head(&mut self, command: &str) -> io::Result<()> {
        let (results_of, version) = (Some(command.to_owned()), Some(env!("CARGO_PKG_VERSION").to_owned()));
        self.append(&JournalLine { results_of, version, ..JournalLine::default() })?;
        self.contents.command = Some(command.to_owned());
        self.mark(FolderState::Claimed)
    }

    /// Opens the manifest of a folder, and locks it if free.
    ///
    /// A manifest without a first line belongs to a process about to write it, or killed before; the call waits a
    /// moment for the line.
    pub(super) fn open(folder: &Path) -> Result<(Self, LockOutcome), JournalError> {
        let place = folder.join(MANIFEST);
        expect_regular(&fs::metadata(&place)?)?;
        let file = OpenOptions::new().read(true).write(true).open(place)?;
        let mut manifest = Self { file, contents: FolderContents::default() };
        let mut outcome = try_lock(&manifest.file);
        for attempt in 1..=LOCK_ATTEMPTS {
            match manifest.read() {
                Ok(()) if manifest.contents.is_handed_over() || is_staging_handed_over(folder) => break,
                Ok(()) if manifest.contents.command.is_some() && outcome == LockOutcome::Held => break,
                Err(JournalError::Line(line)) => return Err(JournalError::Line(line)),
                Err(JournalError::Io(error)) if outcome == LockOutcome::Held => return Err(error.into()),
                // Some systems deny reading a locked file.
                Ok(()) | Err(JournalError::Io(_)) if attempt == LOCK_ATTEMPTS => break,
                Ok(()) | Err(JournalError::Io(_)) => drop(manifest.file.unlock()),
            }
            sleep(LOCK_PAUSE);
            outcome = try_lock(&manifest.file);
        }
        manifest.refuse_shared_manifest(folder)?;
        if outcome == LockOutcome::Held {
            manifest.drop_incomplete_line()?;
        }
        Ok((manifest, outcome))
    }

    /// Refuses a manifest shared with another folder by a link, or replaced since it was opened.
    fn refuse_shared_manifest(&self, folder: &Path) -> io::Result<()> {
        let place = folder.join(MANIFEST);
        let refuse = |found: &str| Err(io::Error::other(format!("found {found}: copy the folder, or choose another")));
        if fs::symlink_metadata(&place)?.is_symlink() {
            return refuse("a link to the manifest of another folder");
        }
        #[cfg(unix)]
        if std::os::unix::fs::MetadataExt::nlink(&self.file.metadata()?) > 1 {
            return refuse("a manifest that another folder shares by a hard link");
        }
        if Handle::from_file(self.file.try_clone()?)? == Handle::from_path(&place)? {
            Ok(())
        } else {
            refuse("a manifest that another run has just replaced")
        }
    }

    /// Reads the journal again, because another handle of this process may have written.
    pub(super) fn read(&mut self) -> Result<(), JournalError> {
        let text = self.read_text()?;
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut contents = FolderContents::default();
        for (number, line) in (1..).zip(whole.lines()) {
            let line = serde_json::from_str(line).map_err(|_| JournalError::Line(number))?;
            contents.apply(line).ok_or(JournalError::Line(number))?;
        }
        self.contents = contents;
        Ok(())
    }

    fn read_text(&mut self) -> Result<String, JournalError> {
        let mut bytes = vec![];
        self.file.seek(SeekFrom::Start(0))?;
        (&self.file).take(MAX_MANIFEST_BYTES).read_to_end(&mut bytes)?;
        String::from_utf8(bytes).map_err(|_| JournalError::Line(1))
    }

    /// Removes an incomplete last line left by a killed process.
    fn drop_incomplete_line(&mut self) -> Result<(), JournalError> {
        let text = self.read_text()?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        if whole < text.len() {
            self.file.set_len(whole as u64)?;
        }
        Ok(())
    }

    /// Records the state of the folder.
    pub(super) fn mark(&mut self, state: FolderState) -> io::Result<()> {
        self.append(&JournalLine { state: Some(state), ..JournalLine::default() })?;
        (self.contents.state, self.contents.process) = (Some(state), None);
        Ok(())
    }

    /// Lists a file, before the file exists.
    pub(super) fn list_file(&mut self, name: &str) -> io::Result<()> {
        if self.contents.files.contains(name) {
            return Ok(());
        }
        self.append(&JournalLine { file: Some(name.to_owned()), ..JournalLine::default() })?;
        self.contents.files.insert(name.to_owned());
        Ok(())
    }

    /// Strikes a file from the list, after its removal.
    pub(super) fn unlist_file(&mut self, name: &str) -> io::Result<()> {
        self.append(&JournalLine { removed: Some(name.to_owned()), ..JournalLine::default() })?;
        self.contents.files.remove(name);
        Ok(())
    }

    /// Records the digest of the scene of the results.
    pub(super) fn record_scene(&mut self, digest: &str) -> io::Result<()> {
        if self.contents.scene.as_deref() == Some(digest) {
            return Ok(());
        }
        self.append(&JournalLine { scene: Some(digest.to_owned()), ..JournalLine::default() })?;
        self.contents.scene = Some(digest.to_owned());
        Ok(())
    }

    /// Appends a line, whole or not at all.
    fn append(&mut self, line: &JournalLine) -> io::Result<()> {
        let text = serde_json::to_string(line)? + "\n";
        let before = self.file.seek(SeekFrom::End(0))?;
        self.file.write_all(text.as_bytes()).inspect_err(|_| {
            // Only the first error is reported; readers skip an incomplete last line.
            drop(self.file.set_len(before));
        })
    }

    /// Allows the FMU in this process to adopt the claim.
    pub(super) fn hand_over(&mut self) -> io::Result<()> {
        let (state, process) = (Some(FolderState::Claimed), Some(std::process::id()));
        self.append(&JournalLine { state, process, ..JournalLine::default() })?;
        (self.contents.state, self.contents.process) = (state, process);
        // Some systems deny other handles the reading of a locked file. The FMU tells if it is still locked: Wine reports
        // an error of the second of two requests by which the lock is given back.
        if cfg!(windows) {
            drop(self.file.unlock());
        }
        Ok(())
    }
}

impl FolderContents {
    /// Applies a line of the journal; `None` for a line that is invalid in a manifest.
    fn apply(&mut self, line: JournalLine) -> Option<()> {
        if self.command.is_none() {
            (self.command, self.version) = (Some(line.results_of?), line.version);
        }
        if let Some(state) = line.state {
            (self.state, self.process) = (Some(state), line.process);
        }
        if let Some(file) = line.file {
            is_inside_folder(&file).then(|| self.files.insert(file))?;
        }
        if let Some(removed) = line.removed {
            self.files.remove(&removed);
        }
        self.scene = line.scene.or(self.scene.take());
        Some(())
    }

    /// Returns true if this process has claimed the folder for its FMU.
    pub(super) fn is_handed_over(&self) -> bool {
        self.state == Some(FolderState::Claimed) && self.process == Some(std::process::id())
    }
}

/// Returns true if this process has claimed the folder for its FMU, to replace an earlier run.
pub(super) fn is_staging_handed_over(folder: &Path) -> bool {
    read_contents(&folder.join(STAGING)).is_ok_and(|contents| contents.is_handed_over())
}

/// Reads the manifest of a folder without its lock.
pub(super) fn read_contents(folder: &Path) -> Result<FolderContents, JournalError> {
    let place = folder.join(MANIFEST);
    expect_regular(&fs::metadata(&place)?)?;
    let mut manifest = FolderManifest { file: File::open(place)?, contents: FolderContents::default() };
    manifest.read()?;
    Ok(manifest.contents)
}

/// Returns true if a name stays inside the folder.
fn is_inside_folder(name: &str) -> bool {
    !name.is_empty() && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}

/// Tries to lock a new file for a moment.
fn lock_new(file: &File) -> LockOutcome {
    let mut outcomes = (0..LOCK_ATTEMPTS).map(|attempt| {
        sleep(if attempt == 0 { Duration::ZERO } else { LOCK_PAUSE });
        try_lock(file)
    });
    outcomes.find(|outcome| *outcome == LockOutcome::Held).unwrap_or(LockOutcome::Busy)
}

/// Tries to lock a file once; on a system without locks a run continues unprotected.
fn try_lock(file: &File) -> LockOutcome {
    match file.try_lock() {
        Ok(()) | Err(TryLockError::Error(_)) => LockOutcome::Held,
        Err(TryLockError::WouldBlock) => LockOutcome::Busy,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(text: &str) -> Result<FolderContents, JournalError> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(MANIFEST), text).unwrap();
        FolderManifest::open(folder.path()).map(|(manifest, _)| manifest.contents)
    }

    #[test]
    fn a_journal_is_replayed_up_to_its_last_whole_line() {
        let text = "{\"results_of\":\"run\",\"version\":\"0\"}\n{\"state\":\"claimed\",\"process\":7}\n\
                    {\"file\":\"a\"}\n{\"file\":\"frames/b\"}\n{\"removed\":\"a\"}\n{\"state\":\"running\"}\n{\"file\":\"c";
        let contents = journal(text).unwrap();
        assert_eq!(contents.command.as_deref(), Some("run"));
        assert_eq!((contents.state, contents.process), (Some(FolderState::Running), None));
        assert_eq!(contents.files, BTreeSet::from(["frames/b".to_owned()]));
    }

    #[test]
    fn a_file_of_this_name_that_is_no_manifest_is_refused_with_its_line() {
        let head = "{\"results_of\":\"run\"}\n";
        for (text, line) in [
            ("{\"mine\":1}\n".to_owned(), 1),
            (format!("{head}hello\n"), 2),
            (format!("{head}{{\"file\":\"../a\"}}\n"), 2),
            (format!("{head}{{\"file\":\"/a\"}}\n"), 2),
            (format!("{head}{{\"file\":\"\"}}\n"), 2),
        ] {
            assert!(matches!(journal(&text), Err(JournalError::Line(found)) if found == line), "{text}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_manifest_without_end_is_refused_before_it_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/zero", folder.path().join(MANIFEST)).unwrap();
        let refused =
            |error| matches!(error, JournalError::Io(error) if error.to_string().contains("a device or a pipe"));
        assert!(FolderManifest::open(folder.path()).is_err_and(refused));
        assert!(read_contents(folder.path()).is_err_and(refused));
    }

    #[test]
    fn a_manifest_is_held_by_one_handle() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = FolderManifest::create(folder.path(), "run").unwrap();
        first.list_file("a").unwrap();
        let error = FolderManifest::create(folder.path(), "run").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::AlreadyExists);
        let (second, outcome) = FolderManifest::open(folder.path()).unwrap();
        assert_eq!(outcome, LockOutcome::Busy);
        assert!(second.contents.files.contains("a") && !second.contents.is_handed_over());
        first.hand_over().unwrap();
        assert!(FolderManifest::open(folder.path()).unwrap().0.contents.is_handed_over());
        drop((first, second));
        assert_eq!(FolderManifest::open(folder.path()).unwrap().1, LockOutcome::Held);
    }
}
