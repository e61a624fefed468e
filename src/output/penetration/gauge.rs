//! Gauge of the diameter of the cavity, for a run without a result folder.

use super::cavity::CavityProfile;
use super::course::CavityCoursePoint;
use super::shot_line::ShotLine;
use crate::output::bounds::AxisAlignedBox;
use crate::scene::{GelBox, Scene};
use crate::simulation::{BodyPose, MeshFrame, Simulation, StepInputs};

/// Gauge of the cavity behind a projectile: its greatest diameter over the depth.
#[derive(Debug, Clone)]
pub struct CavityGauge(ShotLine);

impl CavityGauge {
    /// Creates the gauge from a simulation at its start; `None` if the scene has no shot along −z, or a gel without a
    /// back face.
    #[must_use]
    pub fn new(scene: &Scene, start: &Simulation) -> Option<Self> {
        let StepInputs { kinematics, shape_motion, active, .. } = start.unchanged(0);
        let GelBox { lower, upper } = scene.gel.shape.bounding_box()?;
        let (projectile, gel) = (BodyPose { kinematics, shape_motion, active }, AxisAlignedBox { lower, upper });
        let line = ShotLine::along(scene, &projectile, &gel, &start.block_motion());
        line.map(Self)
    }

    /// Returns true if the depths at which a diameter counts are reached by `deepest`, the greatest depth so far of the
    /// foremost point, m.
    #[must_use]
    pub fn is_reached(&self, deepest: f64) -> bool {
        deepest > self.0.projectile_width
    }

    /// Returns the point of the greatest diameter over the depth, below one projectile diameter; `None` while the rear
    /// of the projectile is not that deep.
    ///
    /// `deepest` is the greatest depth so far of the foremost point, m; `frame` is called only when that is deeper than
    /// one projectile diameter.
    #[must_use]
    pub fn widest(&self, scene: &Scene, deepest: f64, frame: impl FnOnce() -> MeshFrame) -> Option<CavityCoursePoint> {
        let profile = || CavityProfile::of(&self.0, scene, &frame());
        self.is_reached(deepest)
            .then(|| profile().behind_projectile(deepest.min(self.0.gel_depth)).widest(&self.0))
            .flatten()
    }
}
