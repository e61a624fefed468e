//! Result files of an instance, in `output_directory/<instance name>/`.

use super::abi::MemoryReserve;
use super::call::CallError;
use super::logger::CallLog;
use super::memory::{MemoryPhase, MemoryShortage, reserve_memory};
use super::model::BuiltModel;
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

impl ResultRecording {
    /// Returns true if files are being written.
    pub(super) fn has_recorder(&self) -> bool {
        self.recorder.is_some()
    }

    /// Returns true after a failed write.
    pub(super) fn has_failed(&self) -> bool {
        self.has_failed
    }

    /// Starts the files in a folder, with the current state and the names of the input files.
    pub(super) fn open(
        &mut self,
        folder: &Path,
        inputs: &[PathBuf],
        model: &mut BuiltModel,
        threads: usize,
    ) -> Result<(), CallError> {
        let _reserve = reserve_for_writing(model)?;
        let mut needs = output::result_names(&model.scene);
        needs.push(output::SCENE.to_owned());
        let policy = TakeoverPolicy::Replace;
        let claim = FolderClaim { command: RUN, policy, needs: &needs, inputs, is_of_fmu: true };
        let folder = ResultFolder::claim(folder, &claim)?;
        let mut recorder = RunRecorder::within(folder, &model.scene, DriverInterface::Fmi2, threads)?;
        let observation = model.observe();
        recorder.record_observation(&observation, || model.simulation.frame())?;
        (self.recorder, self.is_open) = (Some(recorder), true);
        Ok(())
    }

    /// Records the current state. Files that cannot be written any more are given up with a warning.
    pub(super) fn record(&mut self, model: &mut BuiltModel, log: &mut CallLog) -> CallStatus {
        let Some(recorder) = &mut self.recorder else { return CallStatus::Ok };
        self.is_open = true;
        let _reserve = match reserve_for_writing(model) {
            Ok(reserve) => reserve,
            // A shortage may pass, and the gap in the tables ends with it.
            Err(shortage) => {
                log.warning(format!("{shortage}. The tables lack this step"));
                return CallStatus::Warning;
            }
        };
        let observation = model.observe();
        let outcome = recorder.record_observation(&observation, || model.simulation.frame());
        self.warn_and_stop(outcome.map_err(CallError::from), log)
    }

    /// Drops the records after a time, s, and continues the files.
    pub(super) fn rewind(&mut self, time: f64) -> Result<(), CallError> {
        let Some(recorder) = &mut self.recorder else { return Ok(()) };
        self.is_open = true;
        Ok(recorder.rewind(time)?)
    }

    /// Completes the files, unless they are complete already.
    pub(super) fn finish(&mut self, model: &BuiltModel, log: &mut CallLog) -> CallStatus {
        let Some(recorder) = &mut self.recorder else { return CallStatus::Ok };
        if !std::mem::take(&mut self.is_open) {
            return CallStatus::Ok;
        }
        let outcome = reserve_for_writing(model)
            .map_err(CallError::from)
            .and_then(|_reserve| Ok(recorder.finish(&model.simulation, model.failure().as_deref()).map(drop)?));
        self.warn_and_stop(outcome, log)
    }

    /// Releases the folder; the next files start afresh.
    pub(super) fn close(&mut self) {
        self.recorder = None;
    }

    /// Turns an error of writing files into a warning and stops the recording.
    pub(super) fn warn_and_stop(&mut self, outcome: Result<(), CallError>, log: &mut CallLog) -> CallStatus {
        let Err(error) = outcome else { return CallStatus::Ok };
        *self = Self { has_failed: true, ..Self::default() };
        log.warning(format!("{error}. Nothing more is written by this instance until it is reset"));
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

/// Returns the folder of the result files of an instance.
pub(super) fn instance_folder(directory: &str, instance: &str) -> PathBuf {
    Path::new(directory).join(instance_folder_name(instance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instance_name_cannot_leave_the_directory() {
        assert_eq!(instance_folder("/out", "gel+1 ä"), Path::new("/out/gel+1 ä"));
        assert_eq!(instance_folder("/out", "../../etc"), Path::new("/out/.._.._etc"));
        assert_eq!(instance_folder("/out", ".."), Path::new("/out/__"));
        assert_eq!(instance_folder("/out", "/etc"), Path::new("/out/_etc"));
    }
}
