//! What was looked at since the last step: each report is made when a variable of it is first read.

use super::instance::Model;
use crate::simulation::{Books, ContactReport, CostReport, ExitReport, Observation, SensorReport};

/// The reports that go over the mesh.
#[derive(Debug, Default)]
pub(super) struct Seen {
    books: Option<Books>,
    cost: Option<CostReport>,
    /// By body, as far as they were looked at.
    contacts: Vec<Option<ContactReport>>,
    sensors: Option<Vec<SensorReport>>,
}

impl Seen {
    /// What it was is over.
    pub(super) fn forget(&mut self) {
        (self.books, self.cost, self.sensors) = (None, None, None);
        self.contacts.clear();
    }

    /// Takes over what an observation of this instant has.
    fn note(&mut self, observation: &Observation) {
        self.books = Some(observation.books());
        self.cost = Some(observation.cost);
        self.sensors = Some(observation.sensors.clone());
        self.contacts.clear();
        self.contacts.extend(observation.bodies.iter().map(|body| Some(body.contact.clone())));
    }
}

impl Model {
    /// The books now.
    pub(super) fn books(&mut self) -> &Books {
        self.seen.books.get_or_insert_with(|| self.simulation.books())
    }

    /// The cost so far.
    pub(super) fn cost(&mut self) -> &CostReport {
        self.seen.cost.get_or_insert_with(|| self.simulation.cost())
    }

    /// The contact of a body that there is.
    pub(super) fn contact(&mut self, body: usize) -> &ContactReport {
        self.seen.contacts.resize(self.simulation.n_bodies(), None);
        self.seen.contacts[body].get_or_insert_with(|| self.simulation.contact(body))
    }

    /// The exit of a body that there is; all 0 of one that has not left the gel.
    pub(super) fn exit(&self, body: usize) -> ExitReport {
        self.simulation.exit(body).unwrap_or_default()
    }

    /// What a sensor that there is measures.
    pub(super) fn sensor(&mut self, sensor: usize) -> &SensorReport {
        &self.seen.sensors.get_or_insert_with(|| self.simulation.sensors())[sensor]
    }

    /// Everything there is to see now.
    pub(super) fn observe(&mut self) -> Observation {
        let observation = self.simulation.observe();
        self.seen.note(&observation);
        observation
    }
}
