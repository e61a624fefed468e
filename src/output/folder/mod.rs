//! Result folder: ownership, listed files, and the replacement of an old run by a new run.
//!
//! A folder belongs to gelfmu if it has a manifest. A new or empty folder is claimed by creating the manifest
//! exclusively; every file is listed before it is written in place. A new run in an existing result folder writes
//! into a hidden staging folder inside, and moves its files over the old files with the first results. Only listed
//! files are ever removed or replaced.

mod manifest;
mod refusal;
mod takeover;

pub use manifest::FolderState;
pub use refusal::FolderRefusal;

use super::files::{self, OutputError, with_path};
use manifest::{FolderManifest, JournalError, LockOutcome, MANIFEST, STAGING};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Files left by a release without manifests.
const LEGACY_FILES: [&str; 6] = ["summary.json", "history.csv", "series.pvd", "report.html", "trade.csv", "options.md"];

/// Claim of a command on a folder.
#[derive(Debug, Clone, Copy)]
pub struct FolderClaim<'a> {
    /// Name of the command, such as `run`; a command writes only over its own results.
    pub command: &'a str,
    /// Policy for existing results.
    pub policy: TakeoverPolicy,
    /// Names of the files to write, as far as known, with `/` between folders.
    pub needs: &'a [String],
    /// Input files, which must not be overwritten.
    pub inputs: &'a [PathBuf],
    /// True for a claim of an FMU, which may adopt the claim of a command in the same process.
    pub is_of_fmu: bool,
}

/// Policy for existing results of the same command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeoverPolicy {
    /// Keep the results and refuse the folder.
    Refuse,
    /// Replace the results with the first new results.
    Replace,
}

/// Folder claimed for one run until the value is dropped.
///
/// A drop before [`ResultFolder::begin`] restores the previous contents.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    manifest: FolderManifest,
    /// Staging folder of the files until they replace those of an earlier run.
    staging: Option<PathBuf>,
    /// Parent folders created for this folder, the innermost first.
    created_parents: Vec<PathBuf>,
    /// Stage of the claim, which decides the action on drop.
    stage: ClaimStage,
}

/// Stage of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ClaimStage {
    /// No results yet.
    Fresh,
    /// No results yet, and another claim of this process cleans the folder up.
    Adopted,
    /// Results are in the folder.
    Begun,
}

impl ResultFolder {
    /// Claims a folder; a missing folder is created.
    ///
    /// # Errors
    /// [`OutputError`] if the folder belongs to another owner or cannot be written; the disk is unchanged then.
    pub fn claim(path: &Path, claim: &FolderClaim) -> Result<Self, OutputError> {
        let missing = path.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        let created_parents: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        let claimed =
            fs::create_dir_all(path).map_err(with_path(path)).and_then(|()| Self::claim_existing(path, claim));
        match claimed {
            Ok(mut folder) => {
                folder.created_parents = created_parents;
                Ok(folder)
            }
            Err(error) => {
                remove_empty(&created_parents);
                Err(error)
            }
        }
    }

    fn claim_existing(path: &Path, claim: &FolderClaim) -> Result<Self, OutputError> {
        let refuse = |refusal| OutputError::refused(path, refusal);
        if !exists(&path.join(MANIFEST)) {
            let strange = foreign_entry(path).map_err(with_path(path))?;
            // Another run may have claimed the folder meanwhile.
            if let Some(file) = strange.filter(|_| !exists(&path.join(MANIFEST))) {
                let unlisted = LEGACY_FILES.contains(&file.as_str());
                return Err(refuse(if unlisted {
                    FolderRefusal::Unlisted { file }
                } else {
                    FolderRefusal::Foreign { file }
                }));
            }
            match FolderManifest::create(path, claim.command) {
                Ok(manifest) => return Ok(Self::from_manifest(path, manifest)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(with_path(&path.join(MANIFEST))(error)),
            }
        }
        let (folder, outcome) = Self::open(path)?;
        folder.take_over(outcome, claim)
    }

    /// Opens a folder with a manifest, and locks it if it is free.
    fn open(path: &Path) -> Result<(Self, LockOutcome), OutputError> {
        match FolderManifest::open(path) {
            Ok((manifest, outcome)) => Ok((Self::from_manifest(path, manifest), outcome)),
            Err(JournalError::Line(line)) => Err(OutputError::refused(path, FolderRefusal::Damaged { line })),
            Err(JournalError::Io(error)) => Err(with_path(&path.join(MANIFEST))(error)),
        }
    }

    /// Opens a folder with results of a command, to add a file to them; the state of the folder stays.
    ///
    /// # Errors
    /// [`OutputError`] if the folder holds no results of the command, or another run writes into it.
    pub fn reopen(path: &Path, command: &str) -> Result<Self, OutputError> {
        let no_results = || OutputError::refused(path, FolderRefusal::NoResults { command: command.to_owned() });
        if !exists(&path.join(MANIFEST)) {
            return Err(no_results());
        }
        let (mut folder, outcome) = Self::open(path)?;
        // Nothing of the folder is given up by this claim.
        folder.stage = ClaimStage::Adopted;
        if outcome == LockOutcome::Busy {
            return Err(OutputError::refused(path, FolderRefusal::Busy));
        }
        if folder.manifest.contents.command.as_deref() != Some(command) {
            return Err(no_results());
        }
        Ok(folder)
    }

    fn from_manifest(path: &Path, manifest: FolderManifest) -> Self {
        Self { path: path.to_path_buf(), manifest, staging: None, created_parents: vec![], stage: ClaimStage::Fresh }
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the current path of a file: in the staging folder before the run has begun to replace an earlier run.
    #[must_use]
    pub fn place(&self, name: &str) -> PathBuf {
        self.staging.as_ref().unwrap_or(&self.path).join(name)
    }

    /// Returns true if a file is listed in the manifest.
    #[must_use]
    pub fn owns(&self, name: &str) -> bool {
        self.manifest.contents.files.contains(name)
    }

    /// Prepares the path of a file: lists the file and creates its folder.
    ///
    /// # Errors
    /// [`OutputError`] if an unlisted file has the name, or the folder cannot be written.
    pub fn prepare(&mut self, name: &str) -> Result<PathBuf, OutputError> {
        let place = self.place(name);
        if self.staging.is_none() && !self.owns(name) {
            if exists(&place) {
                return Err(OutputError::refused(&self.path, FolderRefusal::InTheWay { file: place }));
            }
            self.manifest.list_file(name).map_err(with_path(&self.path.join(MANIFEST)))?;
        }
        if let Some(folder) = place.parent() {
            fs::create_dir_all(folder).map_err(with_path(folder))?;
        }
        Ok(place)
    }

    /// Writes a whole file; an old file stays until the new file is complete.
    ///
    /// # Errors
    /// See [`ResultFolder::prepare`].
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let place = self.prepare(name)?;
        files::write(&place, bytes)
    }

    /// Removes a listed file; the file stays listed, because the run may write it again.
    ///
    /// # Errors
    /// [`OutputError`] if the file cannot be removed.
    pub fn remove(&mut self, name: &str) -> Result<(), OutputError> {
        if self.staging.is_some() || self.owns(name) { files::remove(&self.place(name)) } else { Ok(()) }
    }

    /// Begins the results of the run: the results of an earlier run are replaced, and the folder stays.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be moved, or an unlisted file is in the way.
    pub fn begin(&mut self) -> Result<(), OutputError> {
        if self.staging.is_some() {
            self.replace_old_files()?;
        }
        self.stage = ClaimStage::Begun;
        self.mark(FolderState::Running)
    }

    /// Records the state of the run.
    ///
    /// # Errors
    /// [`OutputError`] if the manifest cannot be written.
    pub fn mark(&mut self, state: FolderState) -> Result<(), OutputError> {
        if self.manifest.contents.state == Some(state) {
            return Ok(());
        }
        self.manifest.mark(state).map_err(with_path(&self.path.join(MANIFEST)))
    }

    /// Records the digest of the scene of the results, which have begun.
    pub(super) fn record_scene(&mut self, digest: &str) -> Result<(), OutputError> {
        self.manifest.record_scene(digest).map_err(with_path(&self.path.join(MANIFEST)))
    }

    /// Lets the FMU in this process adopt the claim. Before the first results of the FMU, dropping this claim
    /// restores the previous contents.
    ///
    /// # Errors
    /// [`OutputError`] if the manifest cannot be written.
    pub fn hand_over(&mut self) -> Result<(), OutputError> {
        match &self.staging {
            None => self.manifest.hand_over().map_err(with_path(&self.path.join(MANIFEST))),
            Some(staging) => self.staged_manifest(FolderManifest::hand_over).map_err(with_path(staging)),
        }
    }

    /// Applies `write` to the manifest of the staging folder.
    fn staged_manifest(&self, write: impl FnOnce(&mut FolderManifest) -> io::Result<()>) -> io::Result<()> {
        match self.staging.as_ref().map(|staging| FolderManifest::open(staging)) {
            Some(Ok((mut manifest, _))) => write(&mut manifest),
            Some(Err(JournalError::Io(error))) => Err(error),
            Some(Err(JournalError::Line(_))) | None => Err(io::ErrorKind::InvalidData.into()),
        }
    }
}

impl Drop for ResultFolder {
    fn drop(&mut self) {
        match self.stage {
            // A drop cannot report a failed write.
            ClaimStage::Begun if self.manifest.contents.state == Some(FolderState::Running) => {
                drop(self.mark(FolderState::Failed));
            }
            ClaimStage::Begun | ClaimStage::Adopted => {}
            ClaimStage::Fresh => self.withdraw(),
        }
    }
}

/// Reads the digest of the scene of the results in a folder; `None` if it has no manifest, or one of another release,
/// whose scenes had other keys, or without a digest.
#[cfg(feature = "cli")]
pub(super) fn read_scene_digest(folder: &Path) -> io::Result<Option<String>> {
    match manifest::read_contents(folder) {
        Ok(contents) => Ok(contents.scene.filter(|_| contents.version.as_deref() == Some(env!("CARGO_PKG_VERSION")))),
        Err(JournalError::Io(error)) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(JournalError::Io(error)) => Err(error),
        Err(JournalError::Line(line)) => {
            let found = format!("found line {line} that is none of a manifest, expected the manifest of a run");
            Err(io::Error::new(io::ErrorKind::InvalidData, found))
        }
    }
}

/// Returns an entry of a folder without manifest: a file of an earlier release first, else the first by name.
fn foreign_entry(folder: &Path) -> io::Result<Option<String>> {
    let mut names: Vec<String> = vec![];
    for entry in fs::read_dir(folder)? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    let known = names.iter().find(|name| LEGACY_FILES.contains(&name.as_str())).cloned();
    Ok(known.or_else(|| names.into_iter().next()))
}

/// Returns true if a file, a folder or a link has this path.
fn exists(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Removes empty folders; other folders stay.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        drop(fs::remove_dir(folder));
    }
}
