//! Motion of a body as importers give and read it.

use crate::contact::{BodyState, RigidBody, ShapeMotion, Wrench};
use crate::math::Vector3;
use serde::{Deserialize, Serialize};

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
    pub(super) fn of(body: &RigidBody, state: &BodyState) -> Self {
        let q = state.orientation.quaternion();
        Self {
            position: state.position,
            velocity: state.velocity,
            orientation: [q.w, q.i, q.j, q.k],
            angular_velocity: body.angular_velocity(state),
        }
    }

    /// Yaw angle, rad: between the body's axis from rear to tip (−z of its frame) and its velocity relative to a block
    /// of this velocity, m/s. 0 is nose first, π rear first; also 0 for a body that rests in the block.
    #[must_use]
    pub fn yaw_from(&self, block_velocity: &Vector3) -> f64 {
        let [w, x, y, z] = self.orientation;
        let axis = -Vector3::new(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
        let velocity = self.velocity - block_velocity;
        if velocity == Vector3::zeros() {
            return 0.0;
        }
        libm::atan2(axis.cross(&velocity).norm(), axis.dot(&velocity))
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
    /// Shape of a dome or an expanding body with its rates, in every mode; `None` of a body whose shape the importer does
    /// not prescribe.
    pub shape_motion: Option<ShapeMotion>,
    /// True if the body takes part.
    pub active: bool,
}
