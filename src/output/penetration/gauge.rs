//! Gauge of the diameter of the cavity, for a run without a result folder.

use super::cavity::CavityProfile;
use super::course::CavityCoursePoint;
use super::shot_line::ShotLine;
use crate::scene::Scene;
use crate::simulation::MeshFrame;

/// Gauge of the cavity behind a projectile: greatest diameter over the depth, and over the frames of a run.
#[derive(Debug, Clone)]
pub struct CavityGauge {
    line: ShotLine,
    /// Greatest depth of the foremost point so far, m.
    deepest: f64,
    /// Greatest diameter so far, m.
    greatest: f64,
}

impl CavityGauge {
    /// Creates the gauge from the first frame of a run; `None` if the scene has no shot along −z.
    #[must_use]
    pub fn new(scene: &Scene, start: &MeshFrame) -> Option<Self> {
        ShotLine::of(scene, start).map(|line| Self { line, deepest: 0.0, greatest: 0.0 })
    }

    /// Measures the cavity; `depth` is that of the foremost point of the projectile, m.
    pub fn measure(&mut self, scene: &Scene, depth: f64, frame: impl FnOnce() -> MeshFrame) {
        self.deepest = self.deepest.max(depth);
        let widest = self.widest(scene, self.deepest, frame);
        self.greatest = widest.map_or(self.greatest, |widest| self.greatest.max(widest.diameter));
    }

    /// Returns the point of the greatest diameter over the depth, below one projectile diameter; `None` while the rear
    /// of the projectile is not that deep.
    ///
    /// `deepest` is the greatest depth so far of the foremost point, m; `frame` is called only when that is deeper than
    /// one projectile diameter.
    #[must_use]
    pub fn widest(&self, scene: &Scene, deepest: f64, frame: impl FnOnce() -> MeshFrame) -> Option<CavityCoursePoint> {
        let profile = || CavityProfile::of(&self.line, scene, &frame());
        let is_deep = deepest > self.line.projectile_width;
        is_deep.then(|| profile().behind_projectile(deepest.min(self.line.gel_depth)).widest(&self.line)).flatten()
    }

    /// Returns the greatest diameter so far, m.
    #[must_use]
    pub fn greatest_diameter(&self) -> f64 {
        self.greatest
    }
}
