//! What is to be seen of a shot: how the projectile slows down on its way through the gel, and the cavity that it leaves.

mod cavity;
mod opening;
mod track;

pub(super) use cavity::{Cavity, Profile};
pub(super) use track::{Along, Track};

use super::body;
use super::bounds::Bounds;
use super::files::OutputError;
use super::folder::ResultFolder;
use super::history::History;
use crate::math::Vector3;
use crate::scene::Scene;
use crate::simulation::Frame;

/// Depths of a table in a metre: their distance is that of a fine measurement.
const PER_METRE: f64 = 1e3;
/// Most depths of a table: those of two metres of gel. In a longer way they are further apart.
const MOST_DEPTHS: usize = 2000;
/// A projectile that drifts sideways by more than this part of its way does not run along −z.
const STRAIGHT: f64 = 0.1;

/// The line along which a projectile runs into the gel, downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// A point of it.
    at: Vector3,
    /// How far the projectile reaches along it, m.
    size: f64,
    /// How deep the gel is at rest, m.
    gel: f64,
}

impl Line {
    /// That of a bounded projectile that moves along −z at the start; of another there is none.
    pub(super) fn of(scene: &Scene, start: &Frame) -> Option<Self> {
        let scenery = Bounds::around(start.points.iter().copied());
        let projectile = start.bodies[0];
        let solid = body::solid(&scene.shape(0), &projectile, &scenery);
        let velocity = projectile.kinematics.velocity;
        let runs = velocity.z < 0.0 && velocity.xy().norm() <= STRAIGHT * -velocity.z;
        if !(runs && solid.bounded && projectile.active) {
            return None;
        }
        let extent = Bounds::around(solid.points);
        let size = extent.upper.z - extent.lower.z;
        Some(Self { at: projectile.kinematics.position, size, gel: -scenery.lower.z })
    }
}

/// Depths in a metre of a table that goes so deep, m.
fn per_metre(length: f64) -> f64 {
    PER_METRE.min(MOST_DEPTHS as f64 / length.max(f64::MIN_POSITIVE))
}

/// A shot: a projectile that has gone deeper than it is long.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Penetration {
    /// The way of the projectile.
    pub(super) track: Track,
    /// The cavity.
    pub(super) cavity: Cavity,
    /// The cavity behind the projectile at each frame.
    profiles: Vec<Profile>,
}

impl Penetration {
    /// That of the run so far; none if the projectile has not gone deeper than it is long.
    ///
    /// # Errors
    /// [`OutputError`] when the history cannot be read back.
    pub(super) fn of(line: &Line, history: &History, profiles: &[Profile]) -> Result<Option<Self>, OutputError> {
        let track = Track::of(line, history)?;
        let deep = track.depth() > line.size;
        let behind = |profile: &Profile| profile.behind(track.depth_until(profile.time));
        let profiles: Vec<Profile> = profiles.iter().map(behind).collect();
        Ok(deep.then(|| Self { cavity: Cavity::of(line, &profiles), track, profiles }))
    }

    /// Writes `shot.csv` and `cavity.csv`.
    pub(super) fn write(&self, folder: &mut ResultFolder) -> Result<(), OutputError> {
        folder.write("shot.csv", self.track.csv().as_bytes())?;
        folder.write("cavity.csv", cavity::csv(&self.profiles).as_bytes())
    }
}
