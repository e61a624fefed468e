//! Report cache: each report is computed at the first read of one of its variables after a step.

use super::instance::BuiltModel;
use crate::simulation::{BalanceReport, ContactReport, CostReport, ExitReport, Observation, SensorReport};

/// Cache of the reports that need a loop over the mesh.
#[derive(Debug, Default)]
pub(super) struct ReportCache {
    books: Option<BalanceReport>,
    cost: Option<CostReport>,
    /// Contact reports by body, as far as computed.
    contacts: Vec<Option<ContactReport>>,
    sensors: Option<Vec<SensorReport>>,
}

impl ReportCache {
    /// Drops all cached reports; called after every step.
    pub(super) fn invalidate(&mut self) {
        (self.books, self.cost, self.sensors) = (None, None, None);
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

impl BuiltModel {
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
