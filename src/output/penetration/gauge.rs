//! Gauge of the greatest diameter of the cavity, for a run without a result folder.

use super::cavity::CavityProfile;
use super::shot_line::ShotLine;
use crate::scene::Scene;
use crate::simulation::MeshFrame;

/// Gauge of the cavity behind a projectile: greatest diameter over depth and time, from the frames of a run.
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

    /// Measures the cavity of a frame; `depth` is that of the foremost point of the projectile, m.
    pub fn measure(&mut self, scene: &Scene, frame: &MeshFrame, depth: f64) {
        self.deepest = self.deepest.max(depth.min(self.line.gel_depth));
        let behind = CavityProfile::of(&self.line, scene, frame).behind_projectile(self.deepest);
        self.greatest = behind.widest(&self.line).map_or(self.greatest, |widest| self.greatest.max(widest.diameter));
    }

    /// Returns the greatest diameter so far, m.
    #[must_use]
    pub fn greatest_diameter(&self) -> f64 {
        self.greatest
    }
}
