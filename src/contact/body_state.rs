//! State of a rigid body at its last event, with the wrench that acts from then on.

use super::ShapeMotion;
use crate::math::Vector3;
use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

/// External wrench: force and torque on a body from outside the gel, with their rates.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3,
    /// Torque about the centre of mass, N·m.
    pub torque: Vector3,
    /// Rate of the force, N/s.
    pub force_rate: Vector3,
    /// Rate of the torque, N·m/s.
    pub torque_rate: Vector3,
}

impl Wrench {
    /// Returns true if the wrench is constant between events.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.force_rate == Vector3::zeros() && self.torque_rate == Vector3::zeros()
    }
}

/// State of a body at its last event: an impulse, or a change of the wrench.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BodyState {
    /// Time of the event, s.
    pub time: f64,
    /// Centre of mass, m.
    pub position: Vector3,
    /// Velocity, m/s.
    pub velocity: Vector3,
    /// Rotation from the body frame to the world frame.
    pub orientation: UnitQuaternion<f64>,
    /// Angular momentum about the centre of mass, world frame, N·m·s.
    pub angular_momentum: Vector3,
    /// Wrench from the event on.
    pub wrench: Wrench,
    /// Shape of a dome or an expanding body; `None` for any other body.
    pub shape_motion: Option<ShapeMotion>,
    /// True if the body takes part; an inactive body stays at its place, touches nothing and is not in the ledger.
    pub active: bool,
}

impl BodyState {
    /// Creates the state of an active body at time 0, upright, without rotation and without a wrench.
    #[must_use]
    pub fn at_start(position: Vector3, velocity: Vector3) -> Self {
        Self {
            time: 0.0,
            position,
            velocity,
            orientation: UnitQuaternion::identity(),
            angular_momentum: Vector3::zeros(),
            wrench: Wrench::default(),
            shape_motion: None,
            active: true,
        }
    }

    /// Returns true if all numbers are finite and a changing shape, if any, is one of the body.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let Wrench { force, torque, force_rate, torque_rate } = &self.wrench;
        let vectors = [&self.position, &self.velocity, &self.angular_momentum, force, torque, force_rate, torque_rate];
        let turned = self.orientation.coords.iter().chain([&self.time]);
        vectors.into_iter().flat_map(|vector| vector.iter()).chain(turned).all(|x| x.is_finite())
            && self.shape_motion.is_none_or(|shape| shape.check().is_ok())
    }
}
