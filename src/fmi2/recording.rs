//! The files of an instance, in `output_directory/<instance name>/`.

use super::abi::MemoryReserve;
use super::call::CallError;
use super::instance::{Instance, Model};
use super::memory::{MemoryPhase, MemoryShortage, reserve_memory};
use super::status::Status;
use crate::output::{self, FolderClaim, Interface, RUN, Recorder, ResultFolder, TakeoverPolicy};
use std::path::{Path, PathBuf};

/// The writer of the files, if there are any.
#[derive(Default)]
pub(super) struct Recording {
    recorder: Option<Recorder>,
    /// Something was recorded since the files were last completed.
    open: bool,
    /// Files could not be written: there are to be no more until the next reset.
    given_up: bool,
}

impl Instance {
    /// Starts the files afresh, if there are to be any, with the state now.
    pub(super) fn open_recording(&mut self) -> Result<(), CallError> {
        self.recording = Recording::default();
        if self.settings.output_directory.is_empty() {
            return Ok(());
        }
        let folder = folder(&self.settings.output_directory, &self.name);
        self.recording.recorder = Some(self.recorder(&folder)?);
        self.recording.open = true;
        self.log.event(format!("writing to {}", folder.display()));
        Ok(())
    }

    fn recorder(&mut self, folder: &Path) -> Result<Recorder, CallError> {
        let (threads, inputs) = (self.settings.threads, self.files_read()?);
        let _reserve = reserve_for_writing(self.model()?)?;
        let model = self.model()?;
        let needs = output::result_names(&model.scene);
        let policy = TakeoverPolicy::Replace;
        let claim = FolderClaim { command: RUN, policy, needs: &needs, inputs: &inputs, is_of_fmu: true };
        let folder = ResultFolder::claim(folder, &claim)?;
        let mut recorder = Recorder::within(folder, &model.scene, Interface::Fmi2, threads)?;
        let observation = model.observe();
        recorder.record_observation(&observation, || model.simulation.frame())?;
        Ok(recorder)
    }

    /// Records the state now. Files that cannot be written any more are given up with a warning.
    pub(super) fn record(&mut self) -> Status {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &mut self.model) else { return Status::Ok };
        self.recording.open = true;
        let _reserve = match reserve_for_writing(model) {
            Ok(reserve) => reserve,
            // A shortage may pass, and with it the gap in the tables.
            Err(shortage) => {
                self.log.warning(format!("{shortage}. This step is missing in the tables"));
                return Status::Warning;
            }
        };
        let observation = model.observe();
        let outcome = recorder.record_observation(&observation, || model.simulation.frame());
        self.give_up_on(outcome.map_err(CallError::from))
    }

    /// Goes on with the files after a state of the same model was restored: forgets what was recorded after the present
    /// time, or starts afresh if nothing was recorded so far.
    pub(super) fn rewind_recording(&mut self) -> Status {
        let outcome = match (&mut self.recording.recorder, &self.model) {
            (Some(recorder), Some(model)) => {
                self.recording.open = true;
                recorder.rewind(model.simulation.time()).map_err(CallError::from)
            }
            _ if self.recording.given_up => Ok(()),
            _ => self.open_recording(),
        };
        self.give_up_on(outcome)
    }

    /// Completes the files, unless nothing was recorded since they were last completed.
    pub(super) fn finish_recording(&mut self) -> Status {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &self.model) else { return Status::Ok };
        if !std::mem::take(&mut self.recording.open) {
            return Status::Ok;
        }
        let outcome = reserve_for_writing(model)
            .map_err(CallError::from)
            .and_then(|_reserve| Ok(recorder.finish(&model.simulation, model.failure().as_deref())?));
        self.give_up_on(outcome)
    }

    /// Lets the folder go; the next files start afresh.
    pub(super) fn close_recording(&mut self) {
        self.recording.recorder = None;
    }

    /// What trouble with files comes to once a run is going on: the call was done, with a warning.
    fn give_up_on(&mut self, outcome: Result<(), CallError>) -> Status {
        let Err(error) = outcome else { return Status::Ok };
        self.recording = Recording { given_up: true, ..Recording::default() };
        self.log.warning(format!("{error}. Nothing more is written by this instance until it is reset"));
        Status::Warning
    }
}

/// Reserves what a frame, or the report at the end, takes.
fn reserve_for_writing(model: &Model) -> Result<MemoryReserve, MemoryShortage> {
    reserve_memory(MemoryPhase::Writing, model.simulation.memory_of_writing())
}

/// Name of an instance's own folder inside `output_directory`: its name, with what could leave the directory, or is in no
/// file name on some system, replaced by `_`.
#[must_use]
pub fn folder_name(instance: &str) -> String {
    let safe = instance.replace(|c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c), "_");
    if safe.chars().all(|c| c == '.') { "_".repeat(safe.len()) } else { safe }
}

fn folder(directory: &str, instance: &str) -> PathBuf {
    Path::new(directory).join(folder_name(instance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instance_name_cannot_leave_the_directory() {
        assert_eq!(folder("/out", "gel+1 ä"), Path::new("/out/gel+1 ä"));
        assert_eq!(folder("/out", "../../etc"), Path::new("/out/.._.._etc"));
        assert_eq!(folder("/out", ".."), Path::new("/out/__"));
        assert_eq!(folder("/out", "/etc"), Path::new("/out/_etc"));
    }
}
