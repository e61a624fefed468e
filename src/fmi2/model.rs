//! Built model of a scene: the simulation, and a report cache. Each report is computed at the first read of one of its
//! variables after a step.

use super::call::CallError;
use super::memory::{MemoryPhase, RoomError, reserve_for_building, reserve_large};
use super::parameters::ResolvedScene;
use super::scalar::{ScalarValues, ScalarVariable, input_start_values, table_of};
use crate::output::{CavityCoursePoint, CavityGauge};
use crate::scene::Scene;
use crate::simulation::{
    BalanceReport, ContactReport, CostReport, ExitReport, Observation, RestoreError, SavedSimulation, SensorReport,
    Simulation, StepInputs,
};

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
    /// Gauge of the cavity along the shot line of the scene; `None` for a scene without a shot along −z.
    gauge: Option<CavityGauge>,
    /// Reports cached since the last step.
    pub reports: ReportCache,
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
        let starts = input_start_values(scene.n_bodies(), &table);
        let gauge = CavityGauge::new(&scene, &simulation);
        Ok(Self { origin, text, scene, table, starts, simulation, gauge, reports: ReportCache::default() })
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

    /// Returns the current balances.
    pub(super) fn books(&mut self) -> &BalanceReport {
        self.reports.books.get_or_insert_with(|| self.simulation.books())
    }

    /// Returns the cost so far.
    pub(super) fn cost(&mut self) -> &CostReport {
        self.reports.cost.get_or_insert_with(|| self.simulation.cost())
    }

    /// Returns the contact report of an existing body.
    pub(super) fn contact(&mut self, body: usize) -> &ContactReport {
        self.reports.contacts.resize(self.simulation.n_bodies(), None);
        self.reports.contacts[body].get_or_insert_with(|| self.simulation.contact(body))
    }

    /// Returns the exit report of an existing body; all 0 before the exit.
    pub(super) fn exit(&self, body: usize) -> ExitReport {
        self.simulation.exit(body).unwrap_or_default()
    }

    /// Returns the widest point of the cavity behind the projectile; all 0 without a cavity.
    ///
    /// # Errors
    /// [`CallError`] if the memory is too small for a frame.
    pub(super) fn cavity(&mut self) -> Result<CavityCoursePoint, CallError> {
        if let Some(widest) = self.reports.cavity {
            return Ok(widest);
        }
        let deepest = self.contact(0).peak_depth.0;
        let Self { scene, simulation, gauge, reports, .. } = self;
        let Some(gauge) = gauge.as_ref().filter(|gauge| gauge.is_reached(deepest)) else {
            return Ok(CavityCoursePoint::default());
        };
        let _reserve = reserve_large(MemoryPhase::Writing, simulation.memory_of_writing())?;
        let widest = gauge.widest(scene, deepest, || simulation.frame()).filter(|widest| widest.diameter > 0.0);
        Ok(*reports.cavity.insert(widest.unwrap_or_default()))
    }

    /// Returns the report of an existing sensor.
    pub(super) fn sensor(&mut self, sensor: usize) -> &SensorReport {
        &self.reports.sensors.get_or_insert_with(|| self.simulation.sensors())[sensor]
    }

    /// Returns a full observation and caches its reports.
    pub(super) fn observe(&mut self) -> Observation {
        let observation = self.simulation.observe();
        self.reports.store(&observation);
        observation
    }
}

/// Cache of the reports that need a loop over the mesh.
#[derive(Debug, Default)]
pub(super) struct ReportCache {
    books: Option<BalanceReport>,
    cost: Option<CostReport>,
    /// Contact reports by body, as far as computed.
    contacts: Vec<Option<ContactReport>>,
    cavity: Option<CavityCoursePoint>,
    sensors: Option<Vec<SensorReport>>,
}

impl ReportCache {
    /// Drops all cached reports; called after every step.
    pub(super) fn invalidate(&mut self) {
        (self.books, self.cost, self.cavity, self.sensors) = (None, None, None, None);
        self.contacts.clear();
    }

    /// Stores the reports of an observation of this instant.
    fn store(&mut self, observation: &Observation) {
        self.books = Some(observation.books());
        self.cost = Some(observation.cost);
        self.sensors = Some(observation.sensors.clone());
        self.contacts.clear();
        self.contacts.extend(observation.bodies.iter().map(|body| Some(body.contact.clone())));
    }
}
