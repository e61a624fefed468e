//! Terminal ballistics of a shot: deceleration of the projectile along its path through the gel, and the cavity
//! behind it.

mod cavity;
mod opening;
mod track;

pub(super) use cavity::{CavityFigures, CavityProfile};
pub(super) use track::{ProjectileTrack, TrackPoint};

use super::body;
use super::bounds::AxisAlignedBox;
use super::files::OutputError;
use super::folder::ResultFolder;
use super::history::HistoryFile;
use crate::math::Vector3;
use crate::scene::Scene;
use crate::simulation::MeshFrame;

/// Depths per metre of a table: the interval of 1 mm is that of a fine measurement.
const DEPTHS_PER_METRE: f64 = 1e3;
/// Limit of the number of depths in a table, reached at two metres of gel; a longer path has a wider interval.
const MAX_DEPTHS: usize = 2000;
/// Greatest ratio of lateral to axial speed of a shot along −z.
const MAX_DRIFT: f64 = 0.1;

/// Shot line: the vertical line of flight of a projectile into the gel, downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ShotLine {
    /// Point on the line.
    origin: Vector3,
    /// Length of the projectile along the line, m.
    projectile_length: f64,
    /// Depth of the gel at rest, m.
    gel_depth: f64,
}

impl ShotLine {
    /// Returns the shot line of a bounded projectile with initial motion along −z, otherwise `None`.
    pub(super) fn of(scene: &Scene, start: &MeshFrame) -> Option<Self> {
        let scenery = AxisAlignedBox::around(start.points.iter().copied());
        let projectile = start.bodies[0];
        let solid = body::body_surface(&scene.shape(0), &projectile, &scenery);
        let velocity = projectile.kinematics.velocity;
        let is_downwards = velocity.z < 0.0 && velocity.xy().norm() <= MAX_DRIFT * -velocity.z;
        if !(is_downwards && solid.bounded && projectile.active) {
            return None;
        }
        let extent = AxisAlignedBox::around(solid.points);
        let projectile_length = extent.upper.z - extent.lower.z;
        Some(Self { origin: projectile.kinematics.position, projectile_length, gel_depth: -scenery.lower.z })
    }
}

/// Returns the number of depths per metre of a table of this length, m.
fn depths_per_metre(length: f64) -> f64 {
    DEPTHS_PER_METRE.min(MAX_DEPTHS as f64 / length.max(f64::MIN_POSITIVE))
}

/// Penetration of a projectile to more than its own length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PenetrationRecord {
    /// Track of the projectile.
    pub(super) track: ProjectileTrack,
    /// Cavity figures.
    pub(super) cavity: CavityFigures,
    /// Cavity profile behind the projectile at each frame.
    profiles: Vec<CavityProfile>,
}

impl PenetrationRecord {
    /// Evaluates the run so far; `None` if the penetration is below one projectile length.
    ///
    /// # Errors
    /// [`OutputError`] if the history cannot be read back.
    pub(super) fn of(
        line: &ShotLine,
        history: &HistoryFile,
        profiles: &[CavityProfile],
    ) -> Result<Option<Self>, OutputError> {
        let track = ProjectileTrack::of(line, history)?;
        let is_deep = track.greatest_depth() > line.projectile_length;
        let behind = |profile: &CavityProfile| profile.behind_projectile(track.depth_until(profile.time));
        let profiles: Vec<CavityProfile> = profiles.iter().map(behind).collect();
        Ok(is_deep.then(|| Self { cavity: CavityFigures::of(line, &profiles), track, profiles }))
    }

    /// Writes `shot.csv` and `cavity.csv`.
    pub(super) fn write(&self, folder: &mut ResultFolder) -> Result<(), OutputError> {
        folder.write("shot.csv", self.track.csv().as_bytes())?;
        folder.write("cavity.csv", cavity::csv(&self.profiles).as_bytes())
    }
}
