//! FMU instance: settings, inputs, built model and life cycle.

use super::call::{CallError, format_number};
use super::inputs::InputValues;
use super::lifecycle::{CallGroup, LifecyclePhase};
use super::logger::CallLog;
use super::model::BuiltModel;
use super::parameters::{PackedScene, RunSettings};
use super::recording::{ResultRecording, instance_folder};
use super::scalar::ScalarValues;
use super::status::CallStatus;
use crate::scene;
use crate::simulation::{self, StepInputs};
use serde::{Deserialize, Serialize};

/// Instance of the FMU.
pub(super) struct FmuInstance {
    /// Name given by the importer.
    pub name: String,
    /// Log lines of the current call.
    pub log: CallLog,
    /// Phase of the life cycle.
    pub phase: LifecyclePhase,
    /// Scene in `resources/`.
    pub packed: PackedScene,
    /// Parameters without a scene key.
    pub settings: RunSettings,
    /// Set parameters with a scene key.
    pub overrides: ScalarValues,
    /// Set inputs.
    pub inputs: InputValues,
    /// Inputs of the simulation for the current step, by body; kept for its allocation.
    pub handed: Vec<StepInputs>,
    /// Experiment and time.
    pub clock: ExperimentClock,
    /// Model built from scene and parameters on demand.
    pub model: Option<BuiltModel>,
    /// Result files.
    pub recording: ResultRecording,
}

/// Experiment and current time, s.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct ExperimentClock {
    /// Start time.
    pub start: f64,
    /// Stop time, if any.
    pub stop: Option<f64>,
    /// End of the last completed step.
    pub now: f64,
}

impl FmuInstance {
    /// Returns a new instance.
    pub(super) fn new(name: String, packed: PackedScene, log: CallLog) -> Self {
        Self {
            name,
            log,
            phase: LifecyclePhase::Instantiated,
            packed,
            settings: RunSettings::default(),
            overrides: ScalarValues::new(),
            inputs: InputValues::default(),
            handed: Vec::new(),
            clock: ExperimentClock::default(),
            model: None,
            recording: ResultRecording::default(),
        }
    }

    /// Refuses a call out of order.
    pub(super) fn expect_allowed(&self, function: &'static str, call: CallGroup) -> Result<(), CallError> {
        if self.phase == LifecyclePhase::Fatal {
            return Err(CallError::Lost { function });
        }
        if !call.is_allowed_in(self.phase) {
            return Err(CallError::out_of_order(function, call, self.phase));
        }
        Ok(())
    }

    /// Sets the start time and, if given, the stop time, s.
    pub(super) fn set_up_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), CallError> {
        if !start.is_finite() {
            return Err(CallError::value("startTime", start, "a finite time, s"));
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop <= start)
        {
            return Err(CallError::value(
                "stopTime",
                stop,
                format!("a time after startTime = {} s", format_number(start)),
            ));
        }
        self.clock = ExperimentClock { start, stop, now: start };
        Ok(())
    }

    /// Enters initialization mode.
    pub(super) fn enter_initialization(&mut self) {
        self.phase = LifecyclePhase::Initialization;
    }

    /// Builds the model if missing, and opens the result files.
    pub(super) fn exit_initialization(&mut self) -> Result<(), CallError> {
        let model = self.model()?;
        let doubts = scene::doubts(&model.scene);
        let class = scene::shot_class(&model.scene, 0);
        for doubt in doubts {
            self.log.warning(doubt);
        }
        if let Some(class) = class {
            self.log.event(format!("model error of the gel, root mean square over shots of this class: {class}"));
        }
        self.open_recording()?;
        self.phase = LifecyclePhase::StepComplete;
        Ok(())
    }

    /// Ends the run and completes the files.
    pub(super) fn terminate(&mut self) -> CallStatus {
        self.phase = LifecyclePhase::Terminated;
        let doubts_of = |model: &BuiltModel| simulation::doubts(&model.scene, &model.simulation.observe());
        let doubts = self.model.as_ref().map_or(vec![], doubts_of);
        for doubt in doubts {
            self.log.warning(doubt);
        }
        self.finish_recording()
    }

    /// Completes the files and resets everything except name, packed scene and log selection.
    pub(super) fn reset(&mut self) -> CallStatus {
        let finished = self.finish_recording();
        self.recording = ResultRecording::default();
        self.phase = LifecyclePhase::Instantiated;
        self.settings = RunSettings::default();
        self.overrides.clear();
        self.inputs = InputValues::default();
        self.clock = ExperimentClock::default();
        self.model = None;
        finished
    }

    /// Returns the model, and builds a missing model.
    pub(super) fn model(&mut self) -> Result<&mut BuiltModel, CallError> {
        if self.model.is_none() {
            let scene = self.packed.resolve(&self.settings.scene, &self.overrides, &mut self.log)?;
            let model = BuiltModel::build(scene, self.settings.threads)?;
            let cost = model.simulation.cost();
            self.log.event(format!("built scene {}: {} elements, {} nodes", model.origin, cost.elements, cost.nodes));
            self.model = Some(model);
        }
        Ok(self.model.as_mut().expect("the model was built above"))
    }

    /// Starts the result files afresh, if requested, with the current state.
    fn open_recording(&mut self) -> Result<(), CallError> {
        self.recording = ResultRecording::default();
        if self.settings.output_directory.is_empty() {
            return Ok(());
        }
        self.model()?;
        let model = self.model.as_mut().expect("the model was built above");
        let folder = instance_folder(&self.settings.output_directory, &self.name);
        let inputs = self.packed.files_read(&model.origin, &model.scene);
        self.recording.open(&folder, &inputs, model, self.settings.threads)?;
        self.log.event(format!("writing to {}", folder.display()));
        Ok(())
    }

    /// Records the current state.
    pub(super) fn record(&mut self) -> CallStatus {
        self.model.as_mut().map_or(CallStatus::Ok, |model| self.recording.record(model, &mut self.log))
    }

    /// Continues the files after a state of the same model was restored. Later records are dropped; without records
    /// the files start afresh.
    pub(super) fn rewind_recording(&mut self) -> CallStatus {
        let outcome = match &self.model {
            Some(model) if self.recording.has_recorder() => self.recording.rewind(model.simulation.time()),
            _ if self.recording.has_failed() => Ok(()),
            _ => self.open_recording(),
        };
        self.recording.warn_and_stop(outcome, &mut self.log)
    }

    /// Completes the files, unless they are complete already.
    pub(super) fn finish_recording(&mut self) -> CallStatus {
        self.model.as_ref().map_or(CallStatus::Ok, |model| self.recording.finish(model, &mut self.log))
    }
}
