//! Exit of a projectile for `summary.json`.

use crate::simulation::BodyReport;
use serde::{Deserialize, Serialize};

/// Exit of the projectile at the back face of the gel, SI. The back face moves with the block; velocity and energies
/// are those in the inertial frame in which the gel was at rest at the start, as a chronograph measures them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ExitFigures {
    /// True if the rear end of the projectile has passed the undisturbed back face of the gel.
    pub perforated: bool,
    /// Velocity at the exit, m/s; of a perforation.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m/s", "x-sampled" = "tick")))]
    pub exit_velocity: Option<[f64; 3]>,
    /// Time of the exit, s; of a perforation.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "s", "x-sampled" = "tick")))]
    pub exit_time: Option<f64>,
    /// Kinetic energy at the exit, J; of a perforation.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "J", "x-sampled" = "tick")))]
    pub residual_energy: Option<f64>,
    /// Energy given to the gel, J, up to the exit if any.
    #[serde(deserialize_with = "super::numbers::number")]
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "J", "x-sampled" = "end")))]
    pub energy_deposited: f64,
}

impl ExitFigures {
    pub(super) fn of(projectile: &BodyReport) -> Self {
        let exit = projectile.exit.as_ref();
        Self {
            perforated: exit.is_some(),
            exit_velocity: exit.map(|exit| exit.velocity.into()),
            exit_time: exit.map(|exit| exit.time),
            residual_energy: exit.map(|exit| exit.residual_energy),
            energy_deposited: projectile.energy_deposited,
        }
    }
}
