//! The composition root: builds a simulation from a scene, advances it, and shows what it holds.
//!
//! This is the only place that erases the dimension. Nothing here reads a clock, a file or the environment.

mod build;
mod observe;
mod run;

use crate::algebra::Vector3;
use serde::{Deserialize, Serialize};

pub use observe::{ContactReport, CostReport, EnergyReport, Frame, FrameCells, Observation};
pub use run::{BuildError, RestoreError, Saved, Simulation};

/// Who integrates the motion of the projectile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CouplingMode {
    /// The kinematic inputs are the motion.
    Prescribed,
    /// The component integrates the projectile; kinematic inputs are never read.
    Integrated,
    /// As `Integrated`, but at each communication step the kinematic inputs replace the projectile's state.
    Corrected,
}

/// Position, velocity, orientation and angular velocity of a rigid body in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Kinematics {
    /// Centre of mass, m.
    pub position: Vector3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vector3,
    /// Hamilton quaternion (w, x, y, z) from the body to the world frame.
    pub orientation: [f64; 4],
    /// Angular velocity, world frame, rad/s.
    pub angular_velocity: Vector3,
}

/// Force and torque on the projectile from outside the gel, with their rates of change.
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

/// What the importer hands over at the start of a communication step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Motion at the start of the step (`prescribed`, `corrected`).
    pub kinematics: Kinematics,
    /// First derivative of the velocity input, m/s2 (`prescribed`).
    pub acceleration: Vector3,
    /// Everything else that acts on the projectile (`integrated`, `corrected`).
    pub wrench: Wrench,
}

/// What came back over one communication step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Exchange {
    /// Length of the step, s.
    pub duration: f64,
    /// J, impulse on the projectile, N·s.
    pub impulse: Vector3,
    /// A, angular impulse about the centre of mass, N·m·s.
    pub angular_impulse: Vector3,
    /// S = Σ Jₖ (t_end − tₖ), N·s².
    pub impulse_moment: Vector3,
    /// ε = J·(V₀ + V₁)/2 + A·(Ω₀ + Ω₁)/2 − Σ Jₖ·V(xₖ, tₖ), power-bond residual, J.
    pub energy_residual: f64,
}
