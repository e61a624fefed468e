//! Expanding bullets: the table of the expansion, and the mushroom as which a bullet is recovered.

use crate::geometry::ProfileOutline;
use serde::{Deserialize, Serialize};

/// Path along which a bullet opens where none is given: calibres, and length beyond them, m ("in the first 2 to 3
/// inches, or not at all").
const PATH_CALIBRES: f64 = 1.5;
const PATH_LENGTH: f64 = 0.01;

/// Expansion of a bullet in the gel. The stagnation pressure of the gel, half its density times the square of the speed,
/// opens the bullet; without thresholds the importer does (`projectile.prescribed_expansion`).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ExpansionSpec {
    /// Bullet as it has opened completely.
    pub opened: MushroomSpec,
    /// Speed in the gel above which the nose opens, m/s; opened in part up to `full_speed`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opening_speed: Option<f64>,
    /// Speed in the gel from which on the bullet opens completely, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_speed: Option<f64>,
    /// Stagnation pressure above which the nose opens, Pa; in place of `opening_speed`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opening_pressure: Option<f64>,
    /// Stagnation pressure from which on the bullet opens completely, Pa; in place of `full_speed`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub full_pressure: Option<f64>,
    /// Path in the gel along which the bullet opens completely, m; 1.5 calibres and 10 mm if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<f64>,
    /// Opening at the start: 0 is unopened, 1 opened, as of a bullet that has left another gel.
    #[serde(default, skip_serializing_if = "is_unopened")]
    pub opening: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_unopened(opening: &f64) -> bool {
    *opening == 0.0
}

/// Mushroom about the z axis of the body, its front towards -z: a head with a flat front and a round edge, and a shank
/// whose base is narrower. The surface between the rim of the head and the base is a cone. The centre of mass of the
/// homogeneous body is the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct MushroomSpec {
    /// Radius of the head, m.
    pub radius: f64,
    /// Overall length, m.
    pub length: f64,
    /// Length of the head up to its rim, m; at least `edge_radius`.
    pub head_length: f64,
    /// Radius of the round edge of the front, m: `radius` is a hemisphere, 0 a sharp disc.
    pub edge_radius: f64,
    /// Radius of the base of the shank, m; at most that of the head.
    pub shank_radius: f64,
    /// Radius of the rounding of all sharp rims, behind the head, at the base, and of a front without a round edge, m; 0 is
    /// sharp.
    #[serde(default)]
    pub rim_radius: f64,
}

impl MushroomSpec {
    /// Outline with rounded rims; `None` if there is no room for the rounding.
    pub(super) fn outline(&self) -> Option<ProfileOutline> {
        let Self { radius, length, head_length, edge_radius, shank_radius, rim_radius } = *self;
        let front = ProfileOutline::at_tip().line(radius - edge_radius, 0.0).arc(
            radius,
            edge_radius,
            edge_radius.max(f64::MIN_POSITIVE),
        );
        front.line(radius, head_length).line(shank_radius, length).line(0.0, length).rounded(rim_radius)
    }
}

impl ExpansionSpec {
    /// Sets the path where none is given, for a bullet of this radius, m.
    pub(super) fn set_path(&mut self, radius: f64) {
        self.path.get_or_insert(PATH_CALIBRES * 2.0 * radius + PATH_LENGTH);
    }

    /// Returns true if no threshold is given: the importer prescribes the opening.
    #[must_use]
    pub fn is_prescribed(&self) -> bool {
        let Self { opening_speed, full_speed, opening_pressure, full_pressure, .. } = self;
        [opening_speed, full_speed, opening_pressure, full_pressure].into_iter().all(Option::is_none)
    }

    /// Stagnation pressures at which a bullet begins to open in gel of this density, kg/m³, and opens completely, Pa; `None`
    /// if the importer prescribes the opening.
    #[must_use]
    pub fn thresholds(&self, density: f64) -> Option<[f64; 2]> {
        let stagnation = |speed: f64| 0.5 * density * speed * speed;
        let opening = self.opening_pressure.or(self.opening_speed.map(stagnation))?;
        Some([opening, self.full_pressure.or(self.full_speed.map(stagnation))?])
    }
}
