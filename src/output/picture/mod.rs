//! Pictures of the deformed mesh and the projectile.
//!
//! A [`Shot`] keeps what each pixel shows — gel or body, its shade, speed and step — and not its colour, so that all
//! pictures of a report can share the colour scale of the whole run.

mod camera;
mod colour;
mod cut;
mod raster;
mod stage;

pub(super) use camera::Camera;
pub(super) use colour::{AMBER, Map, SIGNED, SPEED, STEP, png};

use crate::scene::Scene;
use crate::simulation::Frame;
use raster::{Canvas, Pixel};
use stage::Substance;

/// Width and height of a picture in the report, pixels.
const SHOT: [usize; 2] = [480, 400];
/// Width and height of the picture in the archive, pixels.
const MODEL: [usize; 2] = [600, 450];

/// What the camera saw of one frame.
#[derive(Debug, Clone)]
pub(super) struct Shot {
    /// Time of the frame, s.
    pub(super) time: f64,
    pixels: Vec<Pixel>,
}

/// A field that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
    /// Speed of the nodes, m/s.
    Speed,
    /// Step of the elements, s.
    Step,
}

impl Shot {
    /// Looks at a frame.
    pub(super) fn take(frame: &Frame, scene: &Scene, camera: &Camera) -> Self {
        Self { time: frame.time, pixels: expose(frame, scene, camera, SHOT) }
    }

    /// The values of a field that can be seen on the gel.
    pub(super) fn values(&self, field: Field) -> impl Iterator<Item = f64> + '_ {
        self.pixels.iter().filter(|pixel| pixel.gel > 0).map(move |pixel| pixel.value(field))
    }

    /// The picture coloured by a field: `place` says where in the colour map a value lies, 0 to 1.
    pub(super) fn png(&self, field: Field, map: &Map, place: impl Fn(f64) -> f64) -> Vec<u8> {
        png(SHOT, self.pixels.iter().map(|pixel| pixel.painted(map.at(place(pixel.value(field))))))
    }
}

/// PNG of a frame, 600 × 450: the gel in amber, cut open in the middle, and the projectile.
#[must_use]
pub fn model_picture(frame: &Frame, scene: &Scene) -> Vec<u8> {
    let pixels = expose(frame, scene, &Camera::of(frame, scene), MODEL);
    png(MODEL, pixels.iter().map(|pixel| pixel.painted(AMBER)))
}

/// The bodies of a plane frame as polygons, x and z, m.
pub(super) fn sections(frame: &Frame, scene: &Scene) -> Vec<Vec<[f64; 2]>> {
    let bodies = stage::polygons(frame, scene).into_iter().filter(|polygon| polygon.substance == Substance::Body);
    bodies.map(|polygon| polygon.corners.iter().map(|corner| [corner.at.x, corner.at.z]).collect()).collect()
}

fn expose(frame: &Frame, scene: &Scene, camera: &Camera, size: [usize; 2]) -> Vec<Pixel> {
    let mut canvas = Canvas::new(size);
    for polygon in stage::polygons(frame, scene) {
        canvas.draw(&polygon, &camera.sized(size));
    }
    canvas.develop()
}
