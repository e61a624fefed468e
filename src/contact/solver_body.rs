//! Body of the contact solver: velocity and angular velocity of a rigid body while impulses are sought.

use super::{BodyMotion, BodyState, RigidBody};
use crate::math::{Tensor3, Vector3};

/// Rigid body at one tick, as the sweeps of the contact solver see it: the inverse inertia is turned into the world
/// frame once, not at every visit of a contact point.
#[derive(Debug, Clone, Copy)]
pub(super) struct SolverBody<'a> {
    rigid: &'a RigidBody,
    /// Centre of mass, m.
    position: Vector3,
    /// V, m/s.
    velocity: Vector3,
    /// ω, rad/s.
    angular_velocity: Vector3,
    /// I⁻¹ in the world frame, 1/(kg·m²).
    inverse_inertia: Tensor3,
}

impl<'a> SolverBody<'a> {
    /// Creates the body in a state.
    pub fn new(rigid: &'a RigidBody, state: &BodyState) -> Self {
        Self {
            rigid,
            position: state.position,
            velocity: state.velocity,
            angular_velocity: rigid.angular_velocity(state),
            inverse_inertia: rigid.inverse_inertia_in_world(state),
        }
    }

    /// Returns the velocity V + ω × r at a world point, m/s.
    pub fn velocity_at(&self, point: &Vector3) -> Vector3 {
        self.velocity + self.angular_velocity.cross(&(point - self.position))
    }

    /// Applies an impulse at a world point in the free directions: V += J/M, ω += I⁻¹ (r × J); nothing unless the body
    /// is free.
    pub fn strike(&mut self, point: &Vector3, impulse: &Vector3) {
        if self.rigid.motion == BodyMotion::Free {
            let turning = self.rigid.freedom.rotation(&(point - self.position).cross(impulse));
            self.velocity += self.rigid.freedom.translation(impulse) / self.rigid.mass;
            self.angular_velocity += self.inverse_inertia * turning;
        }
    }
}
