//! Skeleton: to be filled.
use super::{CouplingMode, Frame, Inputs, Kinematics, Observation};
use crate::avi::StepError;
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Why a valid scene could not be built.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The mesh would have too many elements.
    #[error("the mesh would have {elements} elements, more than {limit}; raise mesh.size")]
    TooLarge {
        /// Elements asked for.
        elements: f64,
        /// Most that are built.
        limit: usize,
    },
}

/// A saved state that does not belong to this simulation.
#[derive(Debug, thiserror::Error)]
#[error("the state is of another scene or mesh: {found} nodes, expected {expected}")]
pub struct RestoreError {
    /// Nodes of the state.
    pub found: usize,
    /// Nodes of the simulation.
    pub expected: usize,
}

/// The whole dynamic state as a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Saved {}

/// A gel and a projectile in time.
pub struct Simulation {}

impl Simulation {
    /// Builds the mesh and the initial state. `threads` 0 is all cores; results do not depend on it.
    ///
    /// # Errors
    /// [`BuildError`] if the scene asks for what cannot be built.
    pub fn new(_scene: &Scene, _mode: CouplingMode, _threads: usize) -> Result<Self, BuildError> {
        todo!()
    }
    /// Time since the start, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        todo!()
    }
    /// The projectile now (drifted).
    #[must_use]
    pub fn kinematics(&self) -> Kinematics {
        todo!()
    }
    /// One communication step from now to `end`, s since the start.
    ///
    /// # Errors
    /// [`StepError`] when the mesh or the numbers fail; the state stays at the last consistent tick, and each later
    /// call returns the same error.
    pub fn step(&mut self, _inputs: &Inputs, _end: f64) -> Result<(), StepError> {
        todo!()
    }
    /// Everything there is to see.
    #[must_use]
    pub fn observe(&self) -> Observation {
        todo!()
    }
    /// The mesh now.
    #[must_use]
    pub fn frame(&self) -> Frame {
        todo!()
    }
    /// The state, to be restored later, also by another process that built the same scene.
    #[must_use]
    pub fn save(&self) -> Saved {
        todo!()
    }
    /// Continues from a saved state with identical bits.
    ///
    /// # Errors
    /// [`RestoreError`] if the state is of another scene.
    pub fn restore(&mut self, _saved: &Saved) -> Result<(), RestoreError> {
        todo!()
    }
    /// Hash of the stored state: equal digests are equal bits.
    #[must_use]
    pub fn digest(&self) -> u128 {
        todo!()
    }
}
