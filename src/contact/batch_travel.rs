//! Travel of batches of nodes, by their greatest speeds.

use crate::mesh::NodeId;

/// Nodes of a batch.
pub(crate) const TRAVEL_BATCH: usize = 32;

/// Travel of batches of consecutive nodes.
#[derive(Debug, Default)]
pub(crate) struct BatchTravel {
    /// Bound of the speeds of the nodes of each batch, m/s.
    pub speeds: Vec<f64>,
    /// Travel of the nodes of each batch so far, m.
    travel: Vec<f64>,
    /// Time of the last update, s.
    time: f64,
}

impl BatchTravel {
    /// Creates the travel of batches with these speeds, m/s, from a time on, s.
    pub fn new(time: f64, speeds: Vec<f64>) -> Self {
        Self { travel: vec![0.0; speeds.len()], speeds, time }
    }

    /// Returns the batch of a node.
    pub fn batch_of(node: NodeId) -> usize {
        node.index() / TRAVEL_BATCH
    }

    /// Advances the travel to a time, s, before the speeds change.
    pub fn go_on(&mut self, time: f64) {
        let passed = (time - self.time).max(0.0);
        self.time = time;
        for (travel, speed) in self.travel.iter_mut().zip(&self.speeds) {
            *travel += speed * passed;
        }
    }

    /// Raises the bound of the batch of a node to the speed of the node, m/s.
    pub fn note_speed(&mut self, node: usize, speed: f64) {
        let bound = &mut self.speeds[node / TRAVEL_BATCH];
        *bound = bound.max(speed);
    }

    /// Returns the travel of the nodes of each batch so far, m.
    pub fn travel(&self) -> &[f64] {
        &self.travel
    }
}
