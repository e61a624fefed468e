//! Result files of an instance, in `output_directory/<instance name>/`.

use super::abi::MemoryReserve;
use super::call::CallError;
use super::instance::{BuiltModel, FmuInstance};
use super::memory::{MemoryPhase, MemoryShortage, reserve_memory};
use super::status::CallStatus;
use crate::output::{self, DriverInterface, FolderClaim, RUN, ResultFolder, RunRecorder, TakeoverPolicy};
use std::path::{Path, PathBuf};

/// Recorder of the result files, if any.
#[derive(Default)]
pub(super) struct ResultRecording {
    recorder: Option<RunRecorder>,
    /// True if a record was written since the files were last completed.
    is_open: bool,
    /// True after a failed write: no more files until the next reset.
    has_failed: bool,
}

impl FmuInstance {
    /// Starts the files afresh, if requested, with the current state.
    pub(super) fn open_recording(&mut self) -> Result<(), CallError> {
        self.recording = ResultRecording::default();
        if self.settings.output_directory.is_empty() {
            return Ok(());
        }
        let folder = folder(&self.settings.output_directory, &self.name);
        self.recording.recorder = Some(self.create_recorder(&folder)?);
        self.recording.is_open = true;
        self.log.event(format!("writing to {}", folder.display()));
        Ok(())
    }

    fn create_recorder(&mut self, folder: &Path) -> Result<RunRecorder, CallError> {
        let (threads, inputs) = (self.settings.threads, self.files_read()?);
        let _reserve = reserve_for_writing(self.model()?)?;
        let model = self.model()?;
        let needs = output::result_names(&model.scene);
        let policy = TakeoverPolicy::Replace;
        let claim = FolderClaim { command: RUN, policy, needs: &needs, inputs: &inputs, is_of_fmu: true };
        let folder = ResultFolder::claim(folder, &claim)?;
        let mut recorder = RunRecorder::within(folder, &model.scene, DriverInterface::Fmi2, threads)?;
        let observation = model.observe();
        recorder.record_observation(&observation, || model.simulation.frame())?;
        Ok(recorder)
    }

    /// Records the current state. Files that cannot be written any more are given up with a warning.
    pub(super) fn record(&mut self) -> CallStatus {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &mut self.model) else {
            return CallStatus::Ok;
        };
        self.recording.is_open = true;
        let _reserve = match reserve_for_writing(model) {
            Ok(reserve) => reserve,
            // A shortage may pass, and the gap in the tables ends with it.
            Err(shortage) => {
                self.log.warning(format!("{shortage}. The tables lack this step"));
                return CallStatus::Warning;
            }
        };
        let observation = model.observe();
        let outcome = recorder.record_observation(&observation, || model.simulation.frame());
        self.warn_and_stop(outcome.map_err(CallError::from))
    }

    /// Continues the files after a state of the same model was restored. Later records are dropped; without records
    /// the files start afresh.
    pub(super) fn rewind_recording(&mut self) -> CallStatus {
        let outcome = match (&mut self.recording.recorder, &self.model) {
            (Some(recorder), Some(model)) => {
                self.recording.is_open = true;
                recorder.rewind(model.simulation.time()).map_err(CallError::from)
            }
            _ if self.recording.has_failed => Ok(()),
            _ => self.open_recording(),
        };
        self.warn_and_stop(outcome)
    }

    /// Completes the files, unless they are complete already.
    pub(super) fn finish_recording(&mut self) -> CallStatus {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &self.model) else { return CallStatus::Ok };
        if !std::mem::take(&mut self.recording.is_open) {
            return CallStatus::Ok;
        }
        let outcome = reserve_for_writing(model)
            .map_err(CallError::from)
            .and_then(|_reserve| Ok(recorder.finish(&model.simulation, model.failure().as_deref())?));
        self.warn_and_stop(outcome)
    }

    /// Releases the folder; the next files start afresh.
    pub(super) fn close_recording(&mut self) {
        self.recording.recorder = None;
    }

    /// Turns an error of writing files into a warning and stops the recording.
    fn warn_and_stop(&mut self, outcome: Result<(), CallError>) -> CallStatus {
        let Err(error) = outcome else { return CallStatus::Ok };
        self.recording = ResultRecording { has_failed: true, ..ResultRecording::default() };
        self.log.warning(format!("{error}. Nothing more is written by this instance until it is reset"));
        CallStatus::Warning
    }
}

/// Reserves the memory of a frame, or of the final report.
fn reserve_for_writing(model: &BuiltModel) -> Result<MemoryReserve, MemoryShortage> {
    reserve_memory(MemoryPhase::Writing, model.simulation.memory_of_writing())
}

/// Returns the folder name of an instance inside `output_directory`: the name of the instance with `_` in place of
/// path separators and of characters that some system forbids.
#[must_use]
pub fn instance_folder_name(instance: &str) -> String {
    let safe = instance.replace(|c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c), "_");
    if safe.chars().all(|c| c == '.') { "_".repeat(safe.len()) } else { safe }
}

fn folder(directory: &str, instance: &str) -> PathBuf {
    Path::new(directory).join(instance_folder_name(instance))
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
