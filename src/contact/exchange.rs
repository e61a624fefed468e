//! Exchange with the importer: impulse and work on a body in a communication step.

use crate::math::{Vector, Vector3};
use serde::{Deserialize, Serialize};

/// Impulses that a body received over one communication step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ImpulseExchange {
    /// Length of the step, s.
    pub duration: f64,
    /// J, impulse on the body, N·s.
    pub impulse: Vector3,
    /// A, angular impulse about the centre of mass, N·m·s.
    pub angular_impulse: Vector3,
    /// S = Σ Jₖ (t_end − tₖ), N·s².
    pub impulse_moment: Vector3,
    /// Σ Jₖ·∂x/∂q, the impulses that work on the coordinates q of the shape: height and base radius of a dome, N·s, or
    /// opening of an expanding body, N·m·s.
    pub shape_impulse: Vector<2>,
    /// ε = J·(V₀ + V₁)/2 + A·(Ω₀ + Ω₁)/2 − Σ Jₖ·V(xₖ, tₖ), power-bond residual, J. For a prescribed motion V₁ = V₀ +
    /// J/M and Ω₁ = Ω₀ + I⁻¹A: the effect of the impulse on the importer's body.
    pub energy_residual: f64,
}

impl ImpulseExchange {
    /// Returns true if an impulse acted.
    #[must_use]
    pub fn is_contact(&self) -> bool {
        self.impulse != Vector3::zeros()
    }

    /// Returns the mean force on the body, N; zero before the first step.
    #[must_use]
    pub fn mean_force(&self) -> Vector3 {
        self.mean(self.impulse)
    }

    /// Returns the mean torque about the centre of mass, N·m; zero before the first step.
    #[must_use]
    pub fn mean_torque(&self) -> Vector3 {
        self.mean(self.angular_impulse)
    }

    /// Returns the mean of an impulse over the step.
    fn mean(&self, impulse: Vector3) -> Vector3 {
        if self.duration > 0.0 { impulse / self.duration } else { Vector3::zeros() }
    }
}
