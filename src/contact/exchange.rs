use crate::algebra::Vector3;
use serde::{Deserialize, Serialize};

/// What the projectile received over one communication step.
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
