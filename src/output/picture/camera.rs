//! Where the pictures are taken from.

use crate::math::Vector3;
use crate::output::body;
use crate::output::bounds::Bounds;
use crate::scene::{Dimension, Scene};
use crate::simulation::Frame;

/// A parallel projection that shows a box.
#[derive(Debug, Clone)]
pub(in crate::output) struct Camera {
    right: Vector3,
    up: Vector3,
    towards_viewer: Vector3,
    subject: Bounds,
}

/// A camera for pictures of one size.
#[derive(Debug, Clone)]
pub(super) struct View<'a> {
    camera: &'a Camera,
    middle: [f64; 2],
    offset: [f64; 2],
    scale: f64,
}

impl Camera {
    /// Sees the gel of this frame and the projectile, if that is near: in two dimensions straight on, in three from the
    /// front, a little from the right and from above.
    pub(in crate::output) fn of(frame: &Frame, scene: &Scene) -> Self {
        let subject = subject(frame, scene);
        if scene.scene.dimension != Dimension::Spatial {
            return Self { right: Vector3::x(), up: Vector3::z(), towards_viewer: -Vector3::y(), subject };
        }
        let (azimuth, elevation) = (25f64.to_radians(), 28f64.to_radians());
        let towards_viewer =
            Vector3::new(azimuth.sin() * elevation.cos(), -azimuth.cos() * elevation.cos(), elevation.sin());
        let right = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
        Self { right, up: towards_viewer.cross(&right), towards_viewer, subject }
    }

    /// The view for a picture of `size` pixels.
    pub(super) fn sized(&self, size: [usize; 2]) -> View<'_> {
        const MARGIN: f64 = 0.04;
        let corners = self.subject.corners().map(|p| Vector3::new(self.right.dot(&p), self.up.dot(&p), 0.0));
        let shadow = Bounds::around(corners);
        let extent = shadow.upper - shadow.lower;
        let middle = size.map(|n| 0.5 * n as f64);
        let scale = (0..2).map(|i| 2.0 * middle[i] * (1.0 - 2.0 * MARGIN) / extent[i].max(f64::MIN_POSITIVE));
        let centre = shadow.centre();
        View { camera: self, middle, offset: [centre.x, centre.y], scale: scale.fold(f64::INFINITY, f64::min) }
    }
}

impl View<'_> {
    /// Place in the picture, pixels from its top left corner, and height towards the viewer, m.
    pub(super) fn project(&self, p: &Vector3) -> [f64; 3] {
        let x = self.middle[0] + self.scale * (self.camera.right.dot(p) - self.offset[0]);
        let y = self.middle[1] - self.scale * (self.camera.up.dot(p) - self.offset[1]);
        [x, y, self.camera.towards_viewer.dot(p)]
    }

    /// Brightness of a face, 0 to 1: light from over the viewer's left shoulder, and some from everywhere.
    pub(super) fn shade(&self, normal: &Vector3) -> f64 {
        let light = (self.camera.towards_viewer + 0.5 * self.camera.up - 0.4 * self.camera.right).normalize();
        let facing = normal * normal.dot(&self.camera.towards_viewer).signum();
        0.5 + 0.5 * facing.dot(&light).max(0.0)
    }
}

/// Share of its size that a flying gel has room to move and to spread in.
const ROOM: f64 = 0.12;

/// The gel, and as much of the bodies as is within three quarters of the gel's size.
fn subject(frame: &Frame, scene: &Scene) -> Bounds {
    let mirrored = scene.scene.dimension == Dimension::Axisymmetric;
    let mirror = |p: &Vector3| Vector3::new(if mirrored { -p.x } else { p.x }, p.y, p.z);
    let gel = Bounds::around(frame.points.iter().flat_map(|p| [*p, mirror(p)]));
    let mut subject = gel;
    for (i, place) in frame.bodies.iter().enumerate().filter(|(_, place)| place.active) {
        let body = body::extent(&scene.shape(i), place, &gel);
        subject = subject.with(&body.near(&gel, 0.75 * gel.radius()));
    }
    if scene.gel.velocity != [0.0; 3] {
        subject = subject.grown(ROOM * gel.radius());
    }
    // What lies before the cut is not drawn.
    subject.lower.y = subject.lower.y.max(frame.bodies[0].kinematics.position.y).min(subject.upper.y);
    subject
}
