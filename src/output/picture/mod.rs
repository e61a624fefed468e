//! Pictures of the deformed mesh and the projectile.
//!
//! A [`MeshPicture`] stores material, shade, speed and time step of each pixel instead of its colour. All pictures of
//! a report can therefore share the colour scale of the whole run.

mod camera;
mod colour;
mod cut;
mod raster;
mod stage;

pub(super) use camera::Camera;
pub(super) use colour::{AMBER, ColourMap, SPEED, STEP, png};
pub(super) use raster::PictureField;

use crate::scene::Scene;
use crate::simulation::MeshFrame;
use raster::{DepthBuffer, PicturePixel};

/// Width and height of a picture in the report, pixels.
const PICTURE_SIZE: [usize; 2] = [480, 400];
/// Width and height of the picture in the archive, pixels.
const MODEL_SIZE: [usize; 2] = [600, 450];

/// Picture of one frame, uncoloured.
#[derive(Debug, Clone)]
pub(super) struct MeshPicture {
    /// Time of the frame, s.
    pub(super) time: f64,
    size: [usize; 2],
    pixels: Vec<PicturePixel>,
}

impl MeshPicture {
    /// Renders a frame.
    pub(super) fn take(frame: &MeshFrame, scene: &Scene, camera: &Camera) -> Self {
        Self::take_sized(frame, scene, camera, PICTURE_SIZE)
    }

    /// Renders a frame in a picture of `size` pixels.
    pub(super) fn take_sized(frame: &MeshFrame, scene: &Scene, camera: &Camera, size: [usize; 2]) -> Self {
        Self { time: frame.time, size, pixels: render(frame, scene, camera, size) }
    }

    /// Returns the values of a field on the visible gel.
    pub(super) fn values(&self, field: PictureField) -> impl Iterator<Item = f64> + '_ {
        self.pixels.iter().filter(|pixel| pixel.gel > 0).map(move |pixel| pixel.value(field))
    }

    /// Returns the picture coloured by a field; `place` maps a value into the colour map, 0 to 1.
    pub(super) fn png(&self, field: PictureField, map: &ColourMap, place: impl Fn(f64) -> f64) -> Vec<u8> {
        png(self.size, self.pixels.iter().map(|pixel| pixel.colour(map.at(place(pixel.value(field))))))
    }

    /// Returns the picture like [`MeshPicture::png`], on a white background.
    pub(super) fn opaque(&self, field: PictureField, map: &ColourMap, place: impl Fn(f64) -> f64) -> OpaquePicture {
        let on_white = |[r, g, b, opacity]: [u8; 4]| {
            let mix = |c: u8| ((u32::from(c) * u32::from(opacity) + 255 * (255 - u32::from(opacity))) / 255) as u8;
            [mix(r), mix(g), mix(b), 255]
        };
        let pixels = self.pixels.iter().map(|pixel| on_white(pixel.colour(map.at(place(pixel.value(field))))));
        OpaquePicture { size: self.size, pixels: pixels.collect() }
    }
}

/// Picture on a white background, as of a film.
pub struct OpaquePicture {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Red, green, blue and full opacity of each pixel, row by row from the top.
    pub pixels: Vec<[u8; 4]>,
}

impl OpaquePicture {
    /// Returns the picture as a PNG file.
    #[must_use]
    pub fn png(&self) -> Vec<u8> {
        png(self.size, self.pixels.iter().copied())
    }
}

/// Returns a PNG of a frame, 600 × 450: the gel in amber, cut open in the middle, and the projectile.
#[must_use]
pub fn model_picture(frame: &MeshFrame, scene: &Scene) -> Vec<u8> {
    let pixels = render(frame, scene, &Camera::of(frame, scene), MODEL_SIZE);
    png(MODEL_SIZE, pixels.iter().map(|pixel| pixel.colour(AMBER)))
}

fn render(frame: &MeshFrame, scene: &Scene, camera: &Camera, size: [usize; 2]) -> Vec<PicturePixel> {
    let mut canvas = DepthBuffer::new(size);
    for polygon in stage::polygons(frame, scene) {
        canvas.draw(&polygon, &camera.sized(size));
    }
    canvas.resolve()
}
