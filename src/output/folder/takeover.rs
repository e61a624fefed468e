//! Takeover of a folder with results: checks, and moving of files.

use super::manifest::{FolderContents, LockOutcome, is_staging_handed_over};
use super::{
    ClaimStage, FolderClaim, FolderManifest, FolderRefusal, FolderState, MANIFEST, OutputError, ResultFolder, STAGING,
    TakeoverPolicy, exists, files, remove_empty, with_path,
};
use same_file::Handle;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

impl ResultFolder {
    /// Takes a result folder over, if the claim allows it.
    pub(super) fn take_over(mut self, outcome: LockOutcome, claim: &FolderClaim) -> Result<Self, OutputError> {
        // Nothing of the folder may be given up before the checks have passed.
        self.stage = ClaimStage::Adopted;
        if claim.is_of_fmu && self.is_for_this_fmu(outcome) && self.contents().command.as_deref() == Some(claim.command)
        {
            self.adopt()?;
            return Ok(self);
        }
        self.refuse_unfit(outcome, claim)?;
        self.refuse_foreign(claim.needs)?;
        self.refuse_inputs(claim)?;
        if self.contents().command.is_none() {
            self.manifest.write_head(claim.command).map_err(with_path(&self.path.join(MANIFEST)))?;
        }
        self.create_staging(claim.command)
    }

    /// Adopts the claim handed to the FMU of this process; afterwards no other instance can adopt it.
    fn adopt(&mut self) -> Result<(), OutputError> {
        self.staging = Some(self.path.join(STAGING)).filter(|staging| exists(staging));
        match &self.staging {
            None => self.manifest.mark(FolderState::Claimed).map_err(with_path(&self.path.join(MANIFEST))),
            Some(staging) => {
                self.staged_manifest(|manifest| manifest.mark(FolderState::Claimed)).map_err(with_path(staging))
            }
        }
    }

    /// Returns true if the command in this process holds the folder for its FMU.
    fn is_for_this_fmu(&self, outcome: LockOutcome) -> bool {
        let held = outcome == LockOutcome::Busy || cfg!(windows);
        held && (self.contents().is_handed_over() || is_staging_handed_over(&self.path))
    }

    fn contents(&self) -> &FolderContents {
        &self.manifest.contents
    }

    fn refused(&self, refusal: FolderRefusal) -> OutputError {
        OutputError::refused(&self.path, refusal)
    }

    fn refuse_unfit(&self, outcome: LockOutcome, claim: &FolderClaim) -> Result<(), OutputError> {
        if outcome == LockOutcome::Busy {
            return Err(self.refused(FolderRefusal::Busy));
        }
        let others = self.contents().command.clone().filter(|command| command != claim.command);
        if let Some(command) = others {
            return Err(self.refused(FolderRefusal::OtherCommand { command }));
        }
        // A start that was killed has left no results.
        let is_empty_claim = matches!(self.contents().state, None | Some(FolderState::Claimed)) && !cfg!(windows);
        if claim.policy == TakeoverPolicy::Refuse && !is_empty_claim {
            return Err(self.refused(FolderRefusal::Occupied));
        }
        Ok(())
    }

    /// Refuses unlisted files in the place of results, and links out of the folder.
    fn refuse_foreign(&self, needs: &[String]) -> Result<(), OutputError> {
        let all = || needs.iter().chain(&self.contents().files);
        let folders: BTreeSet<&Path> = all().flat_map(|name| Path::new(name).ancestors().skip(1)).collect();
        let strange_folder = folders
            .into_iter()
            .map(|folder| self.path.join(folder))
            .find(|folder| *folder != self.path && fs::symlink_metadata(folder).is_ok_and(|found| !found.is_dir()));
        let strange_file = || {
            all().map(|name| (self.owns(name), self.path.join(name))).find_map(|(ours, place)| {
                let found = fs::symlink_metadata(&place).ok()?;
                (!ours || found.is_dir()).then_some(place)
            })
        };
        match strange_folder.or_else(strange_file) {
            Some(file) => Err(self.refused(FolderRefusal::InTheWay { file })),
            None => Ok(()),
        }
    }

    /// Refuses to overwrite input files, under any of their names.
    fn refuse_inputs(&self, claim: &FolderClaim) -> Result<(), OutputError> {
        let inputs: Vec<Handle> = claim.inputs.iter().filter_map(|input| file_identity(input)).collect();
        if inputs.is_empty() {
            return Ok(());
        }
        let staging = self.path.join(STAGING);
        let staged = file_names_in(&staging, "").unwrap_or_default();
        let own = self.contents().files.iter().chain(claim.needs).map(|name| self.path.join(name));
        let targets = own.chain(staged.iter().map(|name| staging.join(name)));
        let hit = |target: &PathBuf| file_identity(target).is_some_and(|target| inputs.contains(&target));
        match targets.into_iter().find(hit) {
            Some(file) => Err(self.refused(FolderRefusal::Input { file })),
            None => Ok(()),
        }
    }

    /// Creates the staging folder of a new run, afresh after a killed run.
    fn create_staging(mut self, command: &str) -> Result<Self, OutputError> {
        let staging = self.path.join(STAGING);
        if exists(&staging) {
            fs::remove_dir_all(&staging).map_err(with_path(&staging))?;
        }
        fs::create_dir(&staging).map_err(with_path(&staging))?;
        self.staging = Some(staging.clone());
        self.stage = ClaimStage::Fresh;
        FolderManifest::create(&staging, command).map_err(with_path(&staging))?;
        Ok(self)
    }

    /// Moves the staged files over the files of the earlier run, and removes its remaining files.
    pub(super) fn replace_old_files(&mut self) -> Result<(), OutputError> {
        let Some(staging) = self.staging.clone() else { return Ok(()) };
        let mut names = file_names_in(&staging, "").map_err(with_path(&staging))?;
        names.remove(MANIFEST);
        let needs: Vec<String> = names.iter().cloned().collect();
        self.refuse_foreign(&needs)?;
        self.mark(FolderState::Running)?;
        self.stage = ClaimStage::Begun;
        self.staging = None;
        for name in &names {
            let place = self.prepare(name)?;
            fs::rename(staging.join(name), &place).map_err(with_path(&place))?;
        }
        let stale: Vec<String> = self.contents().files.difference(&names).cloned().collect();
        for name in &stale {
            files::remove(&self.path.join(name))?;
            self.manifest.unlist_file(name).map_err(with_path(&self.path.join(MANIFEST)))?;
        }
        self.remove_empty_folders(&stale);
        fs::remove_dir_all(&staging).map_err(with_path(&staging))
    }

    /// Removes the subfolders that are empty without these files.
    fn remove_empty_folders(&self, names: &[String]) {
        let folders: BTreeSet<&Path> = names.iter().flat_map(|name| Path::new(name).ancestors().skip(1)).collect();
        let inside = folders.into_iter().rev().filter(|folder| !folder.as_os_str().is_empty());
        remove_empty(&inside.map(|folder| self.path.join(folder)).collect::<Vec<_>>());
    }

    /// Withdraws a claim without results. A file that cannot be removed stays, because nobody can be told.
    pub(super) fn withdraw(&mut self) {
        if let Some(staging) = &self.staging {
            // The staging folder is gone if the FMU of this process has begun with the claim.
            drop(fs::remove_dir_all(staging));
            return;
        }
        if self.manifest.read().is_err() || self.contents().state != Some(FolderState::Claimed) {
            return;
        }
        let names: Vec<String> = self.contents().files.iter().cloned().collect();
        for name in &names {
            drop(fs::remove_file(self.path.join(name)));
        }
        self.remove_empty_folders(&names);
        drop(fs::remove_file(self.path.join(MANIFEST)));
        remove_empty(&self.created_parents);
    }
}

/// Returns the identity of a file, independent of its name.
fn file_identity(path: &Path) -> Option<Handle> {
    path.is_file().then(|| Handle::from_path(path).ok()).flatten()
}

/// Returns the names of all files in a folder, with `/` between folders.
fn file_names_in(folder: &Path, prefix: &str) -> std::io::Result<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            names.append(&mut file_names_in(&entry.path(), &format!("{name}/"))?);
        } else {
            names.insert(name);
        }
    }
    Ok(names)
}
