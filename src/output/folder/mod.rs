//! A folder of results: whose it is, which of its files are ours, and how a new run replaces an old one.
//!
//! A folder is ours if it has our manifest. A new or empty folder is claimed by making the manifest exclusively; its files
//! are written in place and listed before they are there. In a folder that is ours a new run makes its files in a hidden
//! folder inside, and moves them over the old ones, file by file, once it has results. Only listed files are ever removed or
//! replaced.

mod manifest;
mod refusal;
mod takeover;

pub use manifest::FolderState;
pub use refusal::FolderRefusal;

use super::files::{self, OutputError, naming};
use manifest::{FolderManifest, JournalError, MANIFEST};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Folder inside a folder of ours, in which a run that is to replace an earlier one begins.
const STAGING: &str = ".gelfmu-new";
/// Files that a release without manifests left in a folder.
const UNLISTED: [&str; 6] = ["summary.json", "history.csv", "series.pvd", "report.html", "trade.csv", "options.md"];

/// What a command wants a folder for.
#[derive(Debug, Clone, Copy)]
pub struct FolderClaim<'a> {
    /// The command, such as `run`: it writes only over its own results.
    pub command: &'a str,
    /// What happens to results that are there.
    pub policy: TakeoverPolicy,
    /// Names of files that it will write, as far as they are known, with `/` between folders.
    pub needs: &'a [String],
    /// Files that it reads, which it must not write over.
    pub inputs: &'a [PathBuf],
    /// An FMU claims it, to which the command that runs in the same process may have handed its own claim.
    pub is_of_fmu: bool,
}

/// What happens to results of the same command that are there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeoverPolicy {
    /// They stay, and the folder is refused.
    Refuse,
    /// They are replaced once there are new ones.
    Replace,
    /// They are gone on with.
    Continue,
}

/// A folder that is claimed for one run as long as this value lives.
///
/// Dropped before [`ResultFolder::begin`], it leaves everything as it was before.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    manifest: FolderManifest,
    /// Where files are made until they replace those of an earlier run.
    staging: Option<PathBuf>,
    /// Folders that were made for this one, the innermost first.
    made: Vec<PathBuf>,
    /// How the claim ends when it is dropped.
    stage: ClaimStage,
}

/// How far a claim is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ClaimStage {
    /// There are no results yet.
    Fresh,
    /// As `Fresh`, but another claim of this process takes care of the folder.
    Adopted,
    /// Results are in the folder.
    Begun,
}

impl ResultFolder {
    /// Claims a folder, which is made if it does not exist.
    ///
    /// # Errors
    /// [`OutputError`] when the folder is not ours to write into, or cannot be written; nothing has changed then.
    pub fn claim(path: &Path, wanted: &FolderClaim) -> Result<Self, OutputError> {
        let missing = path.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
        let made: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        let claimed = fs::create_dir_all(path).map_err(naming(path)).and_then(|()| Self::claim_there(path, wanted));
        match claimed {
            Ok(mut folder) => {
                folder.made = made;
                Ok(folder)
            }
            Err(error) => {
                remove_empty(&made);
                Err(error)
            }
        }
    }

    fn claim_there(path: &Path, wanted: &FolderClaim) -> Result<Self, OutputError> {
        let refuse = |refusal| OutputError::refused(path, refusal);
        if !is_there(&path.join(MANIFEST)) {
            let strange = strange_entry(path).map_err(naming(path))?;
            // Another run may have claimed it meanwhile.
            if let Some(file) = strange.filter(|_| !is_there(&path.join(MANIFEST))) {
                let unlisted = UNLISTED.contains(&file.as_str());
                return Err(refuse(if unlisted {
                    FolderRefusal::Unlisted { file }
                } else {
                    FolderRefusal::Foreign { file }
                }));
            }
            match FolderManifest::create(path, wanted.command) {
                Ok(manifest) => return Ok(Self::with(path, manifest)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(naming(&path.join(MANIFEST))(error)),
            }
        }
        match FolderManifest::open(path) {
            Ok((manifest, outcome)) => Self::take_over(Self::with(path, manifest), outcome, wanted),
            Err(JournalError::Line(line)) => Err(refuse(FolderRefusal::Damaged { line })),
            Err(JournalError::Io(error)) => Err(naming(&path.join(MANIFEST))(error)),
        }
    }

    fn with(path: &Path, manifest: FolderManifest) -> Self {
        Self { path: path.to_path_buf(), manifest, staging: None, made: vec![], stage: ClaimStage::Fresh }
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Place of a file now: in the hidden folder until the run has begun, if it replaces an earlier one.
    #[must_use]
    pub fn place(&self, name: &str) -> PathBuf {
        self.staging.as_ref().unwrap_or(&self.path).join(name)
    }

    /// Returns true if a file is listed as ours.
    #[must_use]
    pub fn owns(&self, name: &str) -> bool {
        self.manifest.contents.files.contains(name)
    }

    /// Makes a place for a file of ours: it is listed, and its folder is there.
    ///
    /// # Errors
    /// [`OutputError`] when there is a file of the name that is not ours, or the folder cannot be written.
    pub fn prepare(&mut self, name: &str) -> Result<PathBuf, OutputError> {
        let place = self.place(name);
        if self.staging.is_none() && !self.owns(name) {
            if is_there(&place) {
                return Err(OutputError::refused(&self.path, FolderRefusal::InTheWay { file: place }));
            }
            self.manifest.enlist(name).map_err(naming(&self.path.join(MANIFEST)))?;
        }
        if let Some(folder) = place.parent() {
            fs::create_dir_all(folder).map_err(naming(folder))?;
        }
        Ok(place)
    }

    /// Writes a whole file: an old one is there until the new one is whole.
    ///
    /// # Errors
    /// As [`ResultFolder::prepare`].
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let place = self.prepare(name)?;
        files::write(&place, bytes)
    }

    /// Removes a file of ours; it stays listed, as the run may write it again.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be removed.
    pub fn remove(&mut self, name: &str) -> Result<(), OutputError> {
        if self.staging.is_some() || self.owns(name) { files::remove(&self.place(name)) } else { Ok(()) }
    }

    /// Removes all files of ours in a folder inside.
    ///
    /// # Errors
    /// [`OutputError`] when one cannot be removed.
    pub fn remove_all(&mut self, folder: &str) -> Result<(), OutputError> {
        let inside = format!("{folder}/");
        let names: Vec<String> =
            self.manifest.contents.files.iter().filter(|name| name.starts_with(&inside)).cloned().collect();
        for name in &names {
            files::remove(&self.path.join(name))?;
            self.manifest.strike_out(name).map_err(naming(&self.path.join(MANIFEST)))?;
        }
        Ok(())
    }

    /// Notes that the run has results: those of an earlier run are replaced by them, and the folder stays.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be moved, or one that is not ours is in its way.
    pub fn begin(&mut self) -> Result<(), OutputError> {
        if self.staging.is_some() {
            self.settle()?;
        }
        self.stage = ClaimStage::Begun;
        self.mark(FolderState::Running)
    }

    /// Notes how the run stands.
    ///
    /// # Errors
    /// [`OutputError`] when the manifest cannot be written.
    pub fn mark(&mut self, state: FolderState) -> Result<(), OutputError> {
        if self.manifest.contents.state == Some(state) {
            return Ok(());
        }
        self.manifest.mark(state).map_err(naming(&self.path.join(MANIFEST)))
    }

    /// Lets an FMU that runs in this process take the claim over. Until the FMU has results, this claim takes care of the
    /// folder: when it is dropped, everything is as it was before.
    ///
    /// # Errors
    /// [`OutputError`] when the manifest cannot be written.
    pub fn hand_over(&mut self) -> Result<(), OutputError> {
        match &self.staging {
            None => self.manifest.hand_over().map_err(naming(&self.path.join(MANIFEST))),
            Some(staging) => self.staged_manifest(FolderManifest::hand_over).map_err(naming(staging)),
        }
    }

    /// Writes into the manifest of the hidden folder.
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
            // There is nobody left to tell what cannot be written.
            ClaimStage::Begun if self.manifest.contents.state == Some(FolderState::Running) => {
                drop(self.mark(FolderState::Failed));
            }
            ClaimStage::Begun | ClaimStage::Adopted => {}
            ClaimStage::Fresh => self.abandon(),
        }
    }
}

/// The first entry of a folder that is not ours by its name.
fn strange_entry(folder: &Path) -> io::Result<Option<String>> {
    let mut names: Vec<String> = vec![];
    for entry in fs::read_dir(folder)? {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    let known = names.iter().find(|name| UNLISTED.contains(&name.as_str())).cloned();
    Ok(known.or_else(|| names.into_iter().next()))
}

/// Returns true if there is a file, a folder or a link of this path.
fn is_there(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Removes folders that were made and are empty again; others stay.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders {
        drop(fs::remove_dir(folder));
    }
}
