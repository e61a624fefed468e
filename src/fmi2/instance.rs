//! FMU instance: settings, inputs, built model and life cycle.

use super::call::{CallError, format_number};
use super::inputs::{self, InputValues};
use super::lifecycle::{CallGroup, LifecyclePhase};
use super::logger::CallLog;
use super::memory::{RoomError, reserve_for_building};
use super::parameters::{PackedScene, ResolvedScene, RunSettings};
use super::recording::ResultRecording;
use super::model::ReportCache;
use super::scalar::{ScalarVariable, VariablePorts, table_of};
use super::status::CallStatus;
use crate::scene::{self, Scene};
use crate::simulation::{self, RestoreError, SavedSimulation, Simulation, StepInputs};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Values by value reference.
pub(super) type ScalarValues = BTreeMap<u32, f64>;

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

/// Built model of a scene.
pub(super) struct BuiltModel {
    /// Origin of the scene.
    pub origin: String,
    /// Text of the scene with overrides.
    pub text: String,
    /// Parsed scene.
    pub scene: Scene,
    /// Scene as TOML table.
    pub table: toml::Table,
    /// Start values of the inputs.
    pub starts: ScalarValues,
    /// Simulation.
    pub simulation: Simulation,
    /// Reports cached since the last step.
    pub reports: ReportCache,
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
        let (former_keys, doubts) = (scene::former_keys(&model.text), scene::doubts(&model.scene));
        for warning in former_keys.into_iter().chain(doubts) {
            self.log.warning(warning);
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
            let model = BuiltModel::build(self.resolved_scene()?, self.settings.threads)?;
            let cost = model.simulation.cost();
            self.log.event(format!("built scene {}: {} elements, {} nodes", model.origin, cost.elements, cost.nodes));
            self.model = Some(model);
        }
        Ok(self.model.as_mut().expect("the model was built above"))
    }
}

impl BuiltModel {
    /// Builds the model of a scene.
    pub(super) fn build(resolved: ResolvedScene, threads: usize) -> Result<Self, CallError> {
        let ResolvedScene { origin, text, scene } = resolved;
        let _reserve = match reserve_for_building(&scene) {
            Ok(reserve) => reserve,
            Err(RoomError::Build(error)) => return Err(CallError::Build { origin, error }),
            Err(RoomError::Memory(short)) => return Err(short.into()),
        };
        let simulation = match Simulation::new(&scene, scene.coupling.mode, threads) {
            Ok(simulation) => simulation,
            Err(error) => return Err(CallError::Build { origin, error }),
        };
        let table = table_of(&scene);
        let starts = inputs::start_values(VariablePorts::of(&scene), &table);
        Ok(Self { origin, text, scene, table, starts, simulation, reports: ReportCache::default() })
    }

    /// Refuses a scalar of a missing body or sensor.
    pub(super) fn expect_body(&self, scalar: &ScalarVariable) -> Result<(), CallError> {
        if scalar.variable.is_of_sensors() {
            let there = self.scene.sensor.len();
            return if scalar.body < there { Ok(()) } else { Err(CallError::NoSensor { name: scalar.name(), there }) };
        }
        let there = self.scene.fragment.len();
        if scalar.body <= there { Ok(()) } else { Err(CallError::NoBody { name: scalar.name(), there }) }
    }

    /// Advances the simulation by one communication step to `end`, s since the start; returns true on success.
    pub(super) fn advance(&mut self, inputs: &[StepInputs], end: f64) -> bool {
        self.reports.invalidate();
        self.simulation.step(inputs, end).is_ok()
    }

    /// Returns the diagnosis of a failed simulation.
    pub(super) fn failure(&self) -> Option<String> {
        self.simulation.diagnosis()
    }

    /// Restores a saved state.
    pub(super) fn restore(&mut self, saved: &SavedSimulation) -> Result<(), RestoreError> {
        self.simulation.restore(saved)?;
        self.reports.invalidate();
        Ok(())
    }
}
