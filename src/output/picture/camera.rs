//! Camera of the pictures: a parallel projection.

use crate::math::Vector3;
use crate::output::body;
use crate::output::bounds::AxisAlignedBox;
use crate::scene::{Dimension, Scene};
use crate::simulation::MeshFrame;

/// Camera with orthographic projection, framed on the bounding box of its subject.
#[derive(Debug, Clone)]
pub(in crate::output) struct Camera {
    right: Vector3,
    up: Vector3,
    towards_viewer: Vector3,
    subject: AxisAlignedBox,
}

/// View of a camera in pictures of one size.
#[derive(Debug, Clone)]
pub(super) struct CameraView<'a> {
    camera: &'a Camera,
    middle: [f64; 2],
    offset: [f64; 2],
    scale: f64,
}

impl Camera {
    /// Returns the camera on the gel of a frame and on a projectile near by. A plane scene is seen straight on, a
    /// scene in space from the front, a little from the right and from above.
    pub(in crate::output) fn of(frame: &MeshFrame, scene: &Scene) -> Self {
        let subject = subject_box(frame, scene);
        if scene.scene.dimension != Dimension::Spatial {
            return Self { right: Vector3::x(), up: Vector3::z(), towards_viewer: -Vector3::y(), subject };
        }
        let (azimuth, elevation) = (25f64.to_radians(), 28f64.to_radians());
        let towards_viewer =
            Vector3::new(azimuth.sin() * elevation.cos(), -azimuth.cos() * elevation.cos(), elevation.sin());
        let right = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
        Self { right, up: towards_viewer.cross(&right), towards_viewer, subject }
    }

    /// Returns the view for a picture of `size` pixels.
    pub(super) fn sized(&self, size: [usize; 2]) -> CameraView<'_> {
        const MARGIN: f64 = 0.04;
        let corners = self.subject.corners().map(|p| Vector3::new(self.right.dot(&p), self.up.dot(&p), 0.0));
        let projected_box = AxisAlignedBox::around(corners);
        let extent = projected_box.upper - projected_box.lower;
        let middle = size.map(|n| 0.5 * n as f64);
        let scale = (0..2).map(|i| 2.0 * middle[i] * (1.0 - 2.0 * MARGIN) / extent[i].max(f64::MIN_POSITIVE));
        let centre = projected_box.centre();
        CameraView { camera: self, middle, offset: [centre.x, centre.y], scale: scale.fold(f64::INFINITY, f64::min) }
    }
}

impl CameraView<'_> {
    /// Projects a point to pixels from the top left corner, and to its height towards the viewer, m.
    pub(super) fn project(&self, p: &Vector3) -> [f64; 3] {
        let x = self.middle[0] + self.scale * (self.camera.right.dot(p) - self.offset[0]);
        let y = self.middle[1] - self.scale * (self.camera.up.dot(p) - self.offset[1]);
        [x, y, self.camera.towards_viewer.dot(p)]
    }

    /// Returns the brightness of a face, 0 to 1: directional light from over the left shoulder of the viewer, and
    /// ambient light.
    pub(super) fn shade(&self, normal: &Vector3) -> f64 {
        let light = (self.camera.towards_viewer + 0.5 * self.camera.up - 0.4 * self.camera.right).normalize();
        let facing = normal * normal.dot(&self.camera.towards_viewer).signum();
        0.5 + 0.5 * facing.dot(&light).max(0.0)
    }
}

/// Margin for the motion and the spread of a flying gel, relative to its size.
const FLIGHT_MARGIN: f64 = 0.12;

/// Returns the box of the gel and of the bodies, which are clipped to that of the gel grown by three quarters of its half diagonal.
fn subject_box(frame: &MeshFrame, scene: &Scene) -> AxisAlignedBox {
    let mirrored = scene.scene.dimension == Dimension::Axisymmetric;
    let mirror = |p: &Vector3| Vector3::new(if mirrored { -p.x } else { p.x }, p.y, p.z);
    let gel = AxisAlignedBox::around(frame.points.iter().flat_map(|p| [*p, mirror(p)]));
    let mut subject = gel;
    for (i, place) in frame.bodies.iter().enumerate().filter(|(_, place)| place.active) {
        let body = body::visible_box(&scene.shape(i), place, &gel);
        subject = subject.union(&body.clipped_to(&gel, 0.75 * gel.radius()));
    }
    if scene.gel.velocity != [0.0; 3] {
        subject = subject.grown(FLIGHT_MARGIN * gel.radius());
    }
    // The half in front of the cut through the first body is not drawn (`stage`).
    subject.lower.y = subject.lower.y.max(frame.bodies[0].kinematics.position.y).min(subject.upper.y);
    subject
}
