//! Terminal ballistics of a shot: deceleration of the projectile along its path through the gel, the cavity
//! behind it, the track of damaged gel that it leaves, an estimate of the cracks, and the share of each layer.

mod cavity;
mod course;
mod cracks;
mod damage_track;
mod gauge;
mod layers;
mod shot_line;
mod track;

pub(super) use cavity::{CavityFigures, CavityProfile};
pub use course::CavityCoursePoint;
pub(super) use cracks::CrackSlice;
pub(super) use damage_track::PermanentTrack;
pub use gauge::CavityGauge;
pub(super) use layers::LAYERS;
#[cfg(feature = "cli")]
pub(super) use layers::LayerPassage;
pub(super) use shot_line::ShotLine;
pub(super) use track::ProjectileTrack;

use super::files::OutputError;
use super::folder::ResultFolder;
use super::history::HistoryFile;
use crate::scene::Scene;

/// Penetration of a projectile to more than its own length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PenetrationRecord {
    /// Track of the projectile.
    pub(super) track: ProjectileTrack,
    /// Cavity figures.
    pub(super) cavity: CavityFigures,
    /// Permanent track at the end.
    pub(super) damage: PermanentTrack,
    /// Estimated cracks of each centimetre.
    cracks: Vec<CrackSlice>,
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
        damage: PermanentTrack,
        tear_diameter: f64,
    ) -> Result<Option<Self>, OutputError> {
        let track = ProjectileTrack::of(line, history)?;
        let is_deep = track.greatest_depth() > line.projectile_length;
        let behind = |profile: &CavityProfile| profile.behind_projectile(track.depth_until(profile.time));
        let profiles: Vec<CavityProfile> = profiles.iter().map(behind).collect();
        let cavity = CavityFigures::of(line, &profiles);
        let energies = track.energy_per_centimetre();
        let cracks = cracks::slices(tear_diameter, track.greatest_depth(), &energies, &profiles);
        Ok(is_deep.then_some(Self { track, cavity, damage, cracks, profiles }))
    }

    /// Writes `shot.csv`, `cavity.csv`, `track.csv` and `cracks.csv`, and `layers.csv` for a scene with layers.
    pub(super) fn write(&self, scene: &Scene, folder: &mut ResultFolder) -> Result<(), OutputError> {
        folder.write("shot.csv", self.track.csv().as_bytes())?;
        folder.write("cavity.csv", cavity::csv(&self.profiles).as_bytes())?;
        let (depth, energies) = (self.track.greatest_depth(), self.track.energy_per_centimetre());
        folder.write("track.csv", self.damage.csv(depth, &energies).as_bytes())?;
        if !scene.layer.is_empty() {
            folder.write(LAYERS, layers::csv(scene, &self.track).as_bytes())?;
        }
        folder.write("cracks.csv", cracks::csv(&self.cracks).as_bytes())
    }
}
