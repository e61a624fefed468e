//! Figures of an expanding projectile for `summary.json`.

use crate::scene::Scene;
use crate::simulation::Observation;
use serde::{Deserialize, Serialize};

/// Figures of an expanding projectile, SI; `None` (null in JSON) for one that does not expand.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ExpansionFigures {
    /// Opening of the projectile at the end: 0 is unopened, 1 opened.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub expansion: Option<f64>,
    /// Diameter of the projectile across its axis at the end, m.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "m", "x-sampled" = "end")))]
    pub expanded_diameter: Option<f64>,
    /// Work of the surface of the projectile as it opens, relative to the kinetic energy that the projectile has lost: it is
    /// neither taken from its motion nor given to it.
    #[cfg_attr(feature = "cli", schemars(extend("x-unit" = "1", "x-sampled" = "end")))]
    pub expansion_work_fraction: Option<f64>,
}

impl ExpansionFigures {
    pub(super) fn of(scene: &Scene, observation: &Observation) -> Self {
        let projectile = observation.projectile();
        let expansion = projectile.expansion();
        let Some(expanded_diameter) = scene.diameter_at(0, expansion) else { return Self::default() };
        let ratio = observation.energy.expansion / projectile.energy_deposited;
        Self {
            expansion: Some(expansion),
            expanded_diameter: Some(expanded_diameter),
            expansion_work_fraction: (projectile.energy_deposited > 0.0).then_some(ratio),
        }
    }
}
