//! The files of an instance, in `output_directory/<instance name>/`.

use super::call::CallError;
use super::instance::Instance;
use super::status::Status;
use crate::output::{Interface, OutputError, Recorder};
use std::path::{Path, PathBuf};

/// The writer of the files, if there are any.
#[derive(Default)]
pub(super) struct Recording {
    recorder: Option<Recorder>,
    /// Something was recorded since the files were last completed.
    open: bool,
}

impl Instance {
    /// Starts the files afresh, if there are to be any, with the state now.
    pub(super) fn open_recording(&mut self) -> Result<(), CallError> {
        if self.settings.output_directory.is_empty() {
            return Ok(());
        }
        let folder = folder(&self.settings.output_directory, &self.name);
        let threads = self.settings.threads;
        let model = self.model()?;
        let mut recorder = Recorder::create(&folder, &model.scene, Interface::Fmi2, threads)?;
        let (observation, simulation) = model.look();
        recorder.record_observation(observation, || simulation.frame())?;
        self.log.event(format!("writing to {}", folder.display()));
        self.recording = Recording { recorder: Some(recorder), open: true };
        Ok(())
    }

    /// Records the state now. Files that cannot be written any more are given up with a warning.
    pub(super) fn record(&mut self) -> Status {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &mut self.model) else { return Status::Ok };
        self.recording.open = true;
        let (observation, simulation) = model.look();
        let outcome = recorder.record_observation(observation, || simulation.frame());
        self.give_up_on(outcome)
    }

    /// Forgets what was recorded after the present time; starts afresh if nothing was recorded so far.
    pub(super) fn rewind_recording(&mut self) -> Result<(), CallError> {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &self.model) else {
            return self.open_recording();
        };
        self.recording.open = true;
        recorder.rewind(model.simulation.time())?;
        Ok(())
    }

    /// Completes the files, unless nothing was recorded since they were last completed.
    pub(super) fn finish_recording(&mut self) -> Result<(), CallError> {
        let (Some(recorder), Some(model)) = (&mut self.recording.recorder, &self.model) else { return Ok(()) };
        if std::mem::take(&mut self.recording.open) {
            recorder.finish(&model.simulation, model.failure().as_deref())?;
        }
        Ok(())
    }

    fn give_up_on(&mut self, outcome: Result<(), OutputError>) -> Status {
        match outcome {
            Ok(()) => Status::Ok,
            Err(error) => {
                self.recording = Recording::default();
                self.log.warning(format!("output_directory: {error}. Nothing more is written by this instance"));
                Status::Warning
            }
        }
    }
}

/// The instance's own folder: its name, with what could leave the directory replaced by `_`.
fn folder(directory: &str, name: &str) -> PathBuf {
    let safe = name.replace(|c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c), "_");
    let safe = if safe.chars().all(|c| c == '.') { "_".repeat(safe.len()) } else { safe };
    Path::new(directory).join(safe)
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
