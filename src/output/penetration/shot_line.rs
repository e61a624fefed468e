//! Shot line of a projectile, and the depths of the tables along it.

use crate::math::Vector3;
use crate::output::body;
use crate::output::bounds::AxisAlignedBox;
use crate::scene::{Dimension, Scene};
use crate::simulation::{BlockMotion, BodyPose, MeshFrame, ShapeMotion, is_shot};

/// Depths per metre of a table: the interval of 1 mm is that of a fine measurement.
const DEPTHS_PER_METRE: f64 = 1e3;
/// Slices of one centimetre per metre.
pub(super) const CENTIMETRES: f64 = 100.0;
/// Limit of the number of depths in a table, reached at two metres of gel; a longer path has a wider interval.
pub(super) const MAX_DEPTHS: usize = 2000;

/// Shot line: the vertical line of flight of a projectile into the gel, downwards; it moves with the block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::output) struct ShotLine {
    /// Point on the line at the start.
    pub(super) origin: Vector3,
    /// Length of the projectile along the line, m.
    pub(super) projectile_length: f64,
    /// Width of the projectile across the line, m: the diameter of a body of revolution that flies straight.
    pub(super) projectile_width: f64,
    /// Depth of the gel at rest, m.
    pub(super) gel_depth: f64,
}

impl ShotLine {
    /// Returns the shot line of a bounded projectile with initial motion along −z, otherwise `None`.
    pub(in crate::output) fn of(scene: &Scene, start: &MeshFrame) -> Option<Self> {
        let gel = AxisAlignedBox::around(start.points.iter().copied());
        Self::along(scene, &start.bodies[0], &gel, &start.block)
    }

    /// Returns the shot line of a projectile at its start, given the box of the gel at rest and the motion of the
    /// block.
    pub(super) fn along(
        scene: &Scene,
        projectile: &BodyPose,
        gel: &AxisAlignedBox,
        block: &BlockMotion,
    ) -> Option<Self> {
        let solid = body::body_surface(&scene.shape(0), projectile, gel);
        let velocity = projectile.kinematics.velocity - block.velocity;
        if !(is_shot(&velocity) && solid.bounded && projectile.active) {
            return None;
        }
        let extent = AxisAlignedBox::around(solid.points);
        let size = extent.upper - extent.lower;
        let width = if scene.scene.dimension == Dimension::Spatial { size.x.max(size.y) } else { size.x };
        Some(Self {
            origin: projectile.kinematics.position,
            projectile_length: size.z,
            projectile_width: width,
            gel_depth: -gel.lower.z,
        })
    }

    /// Returns the diameter up to which the projectile parts the gel without cracks, m: its width across the line, of an
    /// expanding projectile that of its form at the end.
    pub(in crate::output) fn tear_diameter(&self, scene: &Scene, end: &BodyPose) -> f64 {
        let opening = ShapeMotion::opening_of(end.shape_motion.as_ref());
        scene.diameter_at(0, opening).unwrap_or(self.projectile_width)
    }

    /// Returns the depth of the projectile's rear in the block, m: of its uppermost point. Infinite for a projectile
    /// that fills no part of the cavity, because it is inactive or above the gel.
    pub(super) fn rear_depth(scene: &Scene, frame: &MeshFrame) -> f64 {
        let projectile = frame.bodies[0];
        let scenery = AxisAlignedBox::around(frame.points.iter().copied());
        let extent = AxisAlignedBox::around(body::body_surface(&scene.shape(0), &projectile, &scenery).points);
        let entry = frame.block.displacement.z;
        if projectile.active && extent.lower.z < entry { entry - extent.upper.z } else { f64::INFINITY }
    }
}

/// Returns the number of depths per metre of a table of this length, m.
pub(super) fn depths_per_metre(length: f64) -> f64 {
    DEPTHS_PER_METRE.min(MAX_DEPTHS as f64 / length.max(f64::MIN_POSITIVE))
}
