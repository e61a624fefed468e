//! One instance: what it was told, the model that it built from it, and its way through the life cycle.

use super::call::{CallError, number};
use super::inputs::{self, InputValues};
use super::lifecycle::{Call, Phase};
use super::logger::Log;
use super::memory::{RoomError, reserve_for_building};
use super::parameters::{Packed, Resolved, Settings};
use super::recording::Recording;
use super::report_cache::Seen;
use super::scalar::{Ports, Scalar, table_of};
use super::status::Status;
use crate::scene::{self, Scene};
use crate::simulation::{self, Inputs, RestoreError, Saved, Simulation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Values by value reference.
pub(super) type Values = BTreeMap<u32, f64>;

/// An instance of the FMU.
pub(super) struct Instance {
    /// Name that the importer gave it.
    pub name: String,
    /// Lines of the current call.
    pub log: Log,
    /// Where it is in its life.
    pub phase: Phase,
    /// The scene in `resources/`.
    pub packed: Packed,
    /// Parameters that are no scene keys.
    pub settings: Settings,
    /// Parameters that are scene keys, as far as they were set.
    pub overrides: Values,
    /// Inputs, as far as they were set.
    pub inputs: InputValues,
    /// What the simulation was given for the step under way, by body; kept for its memory.
    pub handed: Vec<Inputs>,
    /// Experiment and time.
    pub clock: Clock,
    /// Built from all this, once it is needed.
    pub model: Option<Model>,
    /// Files.
    pub recording: Recording,
}

/// The experiment and the time reached, s.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Where simulation time starts.
    pub start: f64,
    /// Where it must not go beyond.
    pub stop: Option<f64>,
    /// End of the last completed step.
    pub now: f64,
}

/// A scene, built.
pub(super) struct Model {
    /// Where the scene comes from.
    pub origin: String,
    /// Its text with overrides.
    pub text: String,
    /// The same, read.
    pub scene: Scene,
    /// The same as a table.
    pub table: toml::Table,
    /// What the inputs start with.
    pub starts: Values,
    /// The simulation.
    pub simulation: Simulation,
    /// What was looked at since its last step.
    pub seen: Seen,
}

impl Instance {
    /// A fresh instance.
    pub(super) fn new(name: String, packed: Packed, log: Log) -> Self {
        Self {
            name,
            log,
            phase: Phase::Instantiated,
            packed,
            settings: Settings::default(),
            overrides: Values::new(),
            inputs: InputValues::default(),
            handed: Vec::new(),
            clock: Clock::default(),
            model: None,
            recording: Recording::default(),
        }
    }

    /// Refuses a call that is out of order.
    pub(super) fn expect(&self, function: &'static str, call: Call) -> Result<(), CallError> {
        if self.phase == Phase::Fatal {
            return Err(CallError::Lost { function });
        }
        if !call.allowed_in(self.phase) {
            return Err(CallError::out_of_order(function, call, self.phase));
        }
        Ok(())
    }

    /// Takes the start time and, if there is one, the stop time, s.
    pub(super) fn set_up(&mut self, start: f64, stop: Option<f64>) -> Result<(), CallError> {
        if !start.is_finite() {
            return Err(CallError::value("startTime", start, "a finite time, s"));
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop <= start)
        {
            return Err(CallError::value("stopTime", stop, format!("a time after startTime = {} s", number(start))));
        }
        self.clock = Clock { start, stop, now: start };
        Ok(())
    }

    /// Enters initialization mode.
    pub(super) fn enter_initialization(&mut self) {
        self.phase = Phase::Initialization;
    }

    /// Builds the model if it was not yet looked at, and opens the output.
    pub(super) fn exit_initialization(&mut self) -> Result<(), CallError> {
        let doubts = scene::doubts(&self.model()?.scene);
        for doubt in doubts {
            self.log.warning(doubt);
        }
        self.open_recording()?;
        self.phase = Phase::StepComplete;
        Ok(())
    }

    /// Ends the run and completes the files.
    pub(super) fn terminate(&mut self) -> Status {
        self.phase = Phase::Terminated;
        let seen = |model: &Model| simulation::doubts(&model.scene, &model.simulation.observe());
        let doubts = self.model.as_ref().map_or(vec![], seen);
        for doubt in doubts {
            self.log.warning(doubt);
        }
        self.finish_recording()
    }

    /// Completes the files and forgets everything but the name, the packed scene and the choice of log lines.
    pub(super) fn reset(&mut self) -> Status {
        let finished = self.finish_recording();
        self.recording = Recording::default();
        self.phase = Phase::Instantiated;
        self.settings = Settings::default();
        self.overrides.clear();
        self.inputs = InputValues::default();
        self.clock = Clock::default();
        self.model = None;
        finished
    }

    /// The model, built now if there is none.
    pub(super) fn model(&mut self) -> Result<&mut Model, CallError> {
        if self.model.is_none() {
            let model = Model::build(self.resolved_scene()?, self.settings.threads)?;
            let cost = model.simulation.cost();
            self.log.event(format!("built scene {}: {} elements, {} nodes", model.origin, cost.elements, cost.nodes));
            self.model = Some(model);
        }
        Ok(self.model.as_mut().expect("the model was built above"))
    }
}

impl Model {
    /// Builds a scene.
    pub(super) fn build(resolved: Resolved, threads: usize) -> Result<Self, CallError> {
        let Resolved { origin, text, scene } = resolved;
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
        let starts = inputs::starts(Ports::of(&scene), &table);
        Ok(Self { origin, text, scene, table, starts, simulation, seen: Seen::default() })
    }

    /// The scene must have the body or the sensor that a scalar belongs to.
    pub(super) fn expect_body(&self, scalar: &Scalar) -> Result<(), CallError> {
        if scalar.variable.is_of_sensors() {
            let there = self.scene.sensor.len();
            return if scalar.body < there { Ok(()) } else { Err(CallError::NoSensor { name: scalar.name(), there }) };
        }
        let there = self.scene.fragment.len();
        if scalar.body <= there { Ok(()) } else { Err(CallError::NoBody { name: scalar.name(), there }) }
    }

    /// One communication step to `end`, s since the start; whether it succeeded.
    pub(super) fn advance(&mut self, inputs: &[Inputs], end: f64) -> bool {
        self.seen.forget();
        self.simulation.step(inputs, end).is_ok()
    }

    /// Why it cannot go on.
    pub(super) fn failure(&self) -> Option<String> {
        self.simulation.diagnosis()
    }

    /// Continues from a saved state.
    pub(super) fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.simulation.restore(saved)?;
        self.seen.forget();
        Ok(())
    }
}
