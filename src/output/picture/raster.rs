//! Polygons to pixels: a depth buffer at twice the resolution of the picture.

use super::Field;
use super::camera::View;
use super::cut::Corner;
use super::stage::{Polygon, Substance};
use crate::math::Vector3;

/// Samples of a pixel along each side.
const FINE: usize = 2;

/// What one sample shows.
#[derive(Debug, Clone, Copy)]
struct Sample {
    height: f32,
    shade: f32,
    speed: f32,
    substance: Option<Substance>,
}

const NOTHING: Sample = Sample { height: f32::NEG_INFINITY, shade: 0.0, speed: 0.0, substance: None };

impl Sample {
    /// Step of the element, s; none outside the gel.
    fn step(&self) -> Option<f32> {
        match self.substance {
            Some(Substance::Gel { step }) => Some(step as f32),
            Some(Substance::Body) | None => None,
        }
    }
}

/// What one pixel shows: 8 bytes, because the pictures of a whole run are kept.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pixel {
    /// How much of it is gel, 0 to 255.
    pub(super) gel: u8,
    body: u8,
    gel_shade: u8,
    body_shade: u8,
    speed: u16,
    step: u16,
}

impl Pixel {
    pub(super) fn value(self, field: Field) -> f64 {
        let half = match field {
            Field::Speed => self.speed,
            Field::Step => self.step,
        };
        f64::from(f32::from_bits(u32::from(half) << 16))
    }

    /// Red, green, blue and opacity with the gel in this colour.
    pub(super) fn painted(self, gel: [u8; 3]) -> [u8; 4] {
        const STEEL: [u8; 3] = [150, 156, 168];
        let opacity = u32::from(self.gel) + u32::from(self.body);
        let mix = |i: usize| {
            let gel = u32::from(gel[i]) * u32::from(self.gel_shade) * u32::from(self.gel);
            let body = u32::from(STEEL[i]) * u32::from(self.body_shade) * u32::from(self.body);
            ((gel + body) / (255 * opacity.max(1))) as u8
        };
        [mix(0), mix(1), mix(2), opacity.min(255) as u8]
    }
}

/// A picture in the making.
pub(super) struct Canvas {
    size: [usize; 2],
    samples: Vec<Sample>,
}

/// A triangle in sample coordinates.
struct Face {
    corners: [[f64; 3]; 3],
    speeds: [f64; 3],
    substance: Substance,
    shade: f64,
    /// Up to which weight of the corner across an edge of the mesh a place is on its line; less than any where none is drawn.
    lines: [f64; 3],
    /// How much a line darkens.
    darkness: f64,
}

impl Canvas {
    pub(super) fn new(size: [usize; 2]) -> Self {
        Self { size, samples: vec![NOTHING; size[0] * size[1] * FINE * FINE] }
    }

    /// Draws a polygon where nothing nearer to the viewer is.
    pub(super) fn draw(&mut self, polygon: &Polygon, view: &View) {
        let corners = &polygon.corners;
        let shade = view.shade(&normal(corners));
        for i in 1..corners.len() - 1 {
            let fan = [corners[0], corners[i], corners[i + 1]];
            let edges = match polygon.substance {
                Substance::Gel { .. } => [true, i + 2 == corners.len(), i == 1],
                Substance::Body => [false; 3],
            };
            let places = fan.map(|corner| view.project(&corner.at).map(|x| x * FINE as f64));
            let double = cross(places[0], places[1], places[2]);
            if double != 0.0 && double.is_finite() {
                let face = Face::new(places, fan.map(|corner| corner.speed), (polygon.substance, shade));
                self.fill(&face.with_lines(edges, double.abs()), double);
            }
        }
    }

    /// Fills a face of this signed area, doubled.
    fn fill(&mut self, face: &Face, double: f64) {
        let [width, height] = self.size.map(|n| n * FINE);
        let [a, b, c] = face.corners;
        let span = |axis: usize, n: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]).floor().max(0.0) as usize;
            low..(a[axis].max(b[axis]).max(c[axis]).ceil().max(0.0) as usize).min(n)
        };
        let places = span(1, height).flat_map(|y| span(0, width).map(move |x| (x, y)));
        for (x, y) in places {
            let p = [x as f64 + 0.5, y as f64 + 0.5, 0.0];
            let weights = [cross(p, b, c), cross(a, p, c), cross(a, b, p)].map(|w| w / double);
            if weights.iter().all(|w| *w >= 0.0) {
                let (height, place) = (face.height(weights), &mut self.samples[y * width + x]);
                if height > place.height {
                    *place = face.sample(weights, height);
                }
            }
        }
    }

    /// The picture: each pixel is the mean of its samples.
    pub(super) fn develop(&self) -> Vec<Pixel> {
        let [width, height] = self.size;
        let at = |x: usize, y: usize, i: usize| (y * FINE + i / FINE) * width * FINE + x * FINE + i % FINE;
        let group = |x: usize, y: usize| std::array::from_fn(|i| self.samples[at(x, y, i)]);
        (0..height).flat_map(|y| (0..width).map(move |x| mean(group(x, y)))).collect()
    }
}

impl Face {
    fn new(corners: [[f64; 3]; 3], speeds: [f64; 3], (substance, shade): (Substance, f64)) -> Self {
        Self { corners, speeds, substance, shade, lines: [f64::NEG_INFINITY; 3], darkness: 0.0 }
    }

    /// With lines along those of the edges opposite to the corners that are edges of the mesh, on a face of this area, doubled: they fade
    /// out where elements are a few pixels wide.
    fn with_lines(self, edges: [bool; 3], double: f64) -> Self {
        let line = |i: usize| {
            let [p, q] = [self.corners[(i + 1) % 3], self.corners[(i + 2) % 3]];
            0.5 * FINE as f64 * (p[0] - q[0]).hypot(p[1] - q[1]) / double
        };
        let lines = [0, 1, 2].map(|i| if edges[i] { line(i) } else { f64::NEG_INFINITY });
        Self { lines, darkness: 0.4 * ((double.sqrt() / FINE as f64 - 4.0) / 10.0).clamp(0.0, 1.0), ..self }
    }

    fn height(&self, weights: [f64; 3]) -> f32 {
        blend(weights, self.corners.map(|corner| corner[2]))
    }

    fn sample(&self, weights: [f64; 3], height: f32) -> Sample {
        let is_on_line = (0..3).any(|i| weights[i] < self.lines[i]);
        let shade = if is_on_line { self.shade * (1.0 - self.darkness) } else { self.shade };
        Sample { height, shade: shade as f32, speed: blend(weights, self.speeds), substance: Some(self.substance) }
    }
}

/// Σ w x.
fn blend(weights: [f64; 3], values: [f64; 3]) -> f32 {
    (0..3).map(|i| weights[i] * values[i]).sum::<f64>() as f32
}

/// Twice the signed area of a triangle in the picture.
fn cross(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn normal(corners: &[Corner]) -> Vector3 {
    let [a, b, c] = [0, 1, 2].map(|i| corners[i].at);
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
}

fn mean(samples: [Sample; FINE * FINE]) -> Pixel {
    let gel: Vec<&Sample> = samples.iter().filter(|sample| sample.step().is_some()).collect();
    let body: Vec<&Sample> = samples.iter().filter(|sample| sample.substance == Some(Substance::Body)).collect();
    let average = |of: &[&Sample], value: fn(&Sample) -> f32| {
        of.iter().map(|sample| value(sample)).sum::<f32>() / of.len().max(1) as f32
    };
    let byte = |part: f32| (255.0 * part).round().clamp(0.0, 255.0) as u8;
    // The upper half of an f32 keeps 8 significant bits: finer than the colours.
    let half = |value: f32| (value.to_bits() >> 16) as u16;
    Pixel {
        gel: byte(gel.len() as f32 / samples.len() as f32),
        body: byte(body.len() as f32 / samples.len() as f32),
        gel_shade: byte(average(&gel, |sample| sample.shade)),
        body_shade: byte(average(&body, |sample| sample.shade)),
        speed: half(average(&gel, |sample| sample.speed)),
        step: half(average(&gel, |sample| sample.step().unwrap_or(0.0))),
    }
}
