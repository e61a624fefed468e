//! Simulation: builds a gel and its bodies from a scene, steps them in time, and reports on them.
//!
//! This module alone erases the dimension. Nothing here reads a file or the environment; the clock is read only to
//! time a remeshing.

mod build;
mod candidate;
mod doubts;
mod driver;
mod erosion;
mod erosion_on_failure;
mod exit;
mod gel_definition;
mod history;
mod loads;
mod memory;
mod model;
mod observe;
mod patch_volume_share;
mod preview;
mod report_queries;
mod rest_volumes;
#[cfg(test)]
mod round_trip_tests;
mod run;
mod saved;
mod sensors;
mod source_mesh;
mod state_averaging;

use crate::math::Vector3;
use serde::{Deserialize, Serialize};

pub use crate::contact::{DomeMotion, ImpulseExchange, Wrench};
pub use crate::scene::CouplingMode;
pub use build::BuildError;
pub use candidate::RemeshRefusal;
pub use doubts::doubts;
pub use memory::{MemoryEstimate, memory_estimate};
pub use observe::{
    BalanceReport, BodyPose, BodyReport, ContactReport, CostReport, EnergyReport, ExitReport, FrameCells, MeshFrame,
    Observation, SensorReport,
};
pub use preview::{FailedRemesh, PreviewMesh, RemeshPreview, RemeshRecord};
pub use run::{RestoreError, Simulation};
pub use saved::{SavedSimulation, SavedState};

/// Position, velocity, orientation and angular velocity of a rigid body in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyKinematics {
    /// Centre of mass, m.
    pub position: Vector3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vector3,
    /// Hamilton quaternion (w, x, y, z) from the body to the world frame.
    pub orientation: [f64; 4],
    /// Angular velocity, world frame, rad/s.
    pub angular_velocity: Vector3,
}

impl BodyKinematics {
    /// Yaw angle, rad: between the body's axis from rear to tip (−z of its frame) and its velocity. 0 is nose first,
    /// π rear first; also 0 for a body at rest.
    #[must_use]
    pub fn yaw(&self) -> f64 {
        let [w, x, y, z] = self.orientation;
        let axis = -Vector3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
        if self.velocity == Vector3::zeros() {
            return 0.0;
        }
        libm::atan2(axis.cross(&self.velocity).norm(), axis.dot(&self.velocity))
    }
}

/// Inputs of a body from the importer at the start of a communication step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepInputs {
    /// Motion at the start of the step (`prescribed`, `corrected`).
    pub kinematics: BodyKinematics,
    /// First derivative of the velocity input, m/s2 (`prescribed`).
    pub acceleration: Vector3,
    /// Force and torque on the body apart from contact (`integrated`, `corrected`).
    pub wrench: Wrench,
    /// Height and base radius of a dome with their rates, in every mode.
    pub bulge: Option<DomeMotion>,
    /// True if the body takes part.
    pub active: bool,
}
