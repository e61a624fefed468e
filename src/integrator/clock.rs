//! Clock of a mesh: the place of the current tick in the life of the mesh, and the events to come.

use super::StepError;
use super::end_conditions::EndConditions;
use super::schedule::EventQueue;
use super::substep::MeshPhase;
use crate::state::Tick;

/// Clock of a mesh. Its origin, initial steps and end conditions are those of the mesh; phase and failure belong to a tick;
/// all else is derived from the state.
#[derive(Debug)]
pub(super) struct MeshClock {
    /// First tick of this mesh.
    pub origin: Tick,
    /// Place of the current tick in the life of the mesh.
    pub phase: MeshPhase,
    /// Last tick of each node; arbitrary for a node at rest.
    pub last_ticks: Vec<Tick>,
    /// Event queue, for the schedule of that name.
    pub queue: EventQueue,
    /// Least and greatest step of any group, ticks.
    pub step_range: (Tick, Tick),
    /// Shortest and longest stable step of an element on the new mesh, ticks.
    pub initial_steps: (f64, f64),
    /// Tick up to which nothing happens, while the gel is at rest.
    pub quiet_until: Option<Tick>,
    /// Conditions that end the mesh.
    pub ends: EndConditions,
    /// Failure at the last tick of the mesh; it ends the run unless another mesh is found.
    pub failure: Option<StepError>,
}

impl MeshClock {
    /// Creates the clock of a mesh that begins at a tick, from the shortest and longest stable step, ticks.
    pub fn new(origin: Tick, initial_steps: (f64, f64), n_nodes: usize) -> Self {
        Self {
            origin,
            phase: MeshPhase::First,
            last_ticks: vec![origin; n_nodes],
            queue: EventQueue::default(),
            step_range: (0, 0),
            initial_steps,
            quiet_until: None,
            ends: EndConditions::default(),
            failure: None,
        }
    }
}
