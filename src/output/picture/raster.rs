//! Rasteriser: polygons to pixels by a depth buffer (z-buffer) at twice the resolution of the picture.

use super::camera::CameraView;
use super::cut::PolygonCorner;
use super::stage::{PolygonMaterial, VisiblePolygon};
use crate::math::Vector3;

/// Samples per pixel along each side.
const SAMPLES: usize = 2;

/// Depth-buffer sample.
#[derive(Debug, Clone, Copy)]
struct DepthSample {
    height: f32,
    shade: f32,
    speed: f32,
    material: Option<PolygonMaterial>,
}

const BACKGROUND: DepthSample = DepthSample { height: f32::NEG_INFINITY, shade: 0.0, speed: 0.0, material: None };

impl DepthSample {
    /// Returns the time step of the element, s; `None` outside the gel.
    fn step(&self) -> Option<f32> {
        match self.material {
            Some(PolygonMaterial::Gel { step }) => Some(step as f32),
            Some(PolygonMaterial::Body) | None => None,
        }
    }
}

/// Field of a coloured picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::output) enum PictureField {
    /// Speed of the nodes, m/s.
    Speed,
    /// Time step of the elements, s.
    Step,
}

/// Pixel of a picture, packed into 8 bytes because the pictures of a whole run are kept.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PicturePixel {
    /// Coverage by gel, 0 to 255.
    pub(super) gel: u8,
    body: u8,
    gel_shade: u8,
    body_shade: u8,
    speed: u16,
    step: u16,
}

impl PicturePixel {
    pub(super) fn value(self, field: PictureField) -> f64 {
        let half = match field {
            PictureField::Speed => self.speed,
            PictureField::Step => self.step,
        };
        f64::from(f32::from_bits(u32::from(half) << 16))
    }

    /// Returns red, green, blue and opacity with the gel in this colour.
    pub(super) fn colour(self, gel: [u8; 3]) -> [u8; 4] {
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

/// Depth buffer of a picture.
pub(super) struct DepthBuffer {
    size: [usize; 2],
    samples: Vec<DepthSample>,
}

/// Triangle in sample coordinates.
struct RasterTriangle {
    corners: [[f64; 3]; 3],
    speeds: [f64; 3],
    material: PolygonMaterial,
    shade: f64,
    /// Barycentric coordinate of each corner up to which a sample lies on the mesh line opposite to the corner; −∞
    /// for an edge without a line.
    lines: [f64; 3],
    /// Darkening by a line, 0 to 1.
    darkness: f64,
}

impl DepthBuffer {
    pub(super) fn new(size: [usize; 2]) -> Self {
        Self { size, samples: vec![BACKGROUND; size[0] * size[1] * SAMPLES * SAMPLES] }
    }

    /// Draws a polygon by its fan of triangles, where it is nearest to the viewer.
    pub(super) fn draw(&mut self, polygon: &VisiblePolygon, view: &CameraView) {
        let corners = &polygon.corners;
        let shade = view.shade(&normal(corners));
        for i in 1..corners.len() - 1 {
            let fan = [corners[0], corners[i], corners[i + 1]];
            let edges = match polygon.material {
                PolygonMaterial::Gel { .. } => [true, i + 2 == corners.len(), i == 1],
                PolygonMaterial::Body => [false; 3],
            };
            let places = fan.map(|corner| view.project(&corner.at).map(|x| x * SAMPLES as f64));
            let double_area = doubled_area(places[0], places[1], places[2]);
            if double_area != 0.0 && double_area.is_finite() {
                let face = RasterTriangle::new(places, fan.map(|corner| corner.speed), polygon.material, shade);
                self.fill(&face.with_lines(edges, double_area.abs()), double_area);
            }
        }
    }

    /// Fills a face of this signed area, doubled.
    fn fill(&mut self, face: &RasterTriangle, double_area: f64) {
        let [width, height] = self.size.map(|n| n * SAMPLES);
        let [a, b, c] = face.corners;
        let span = |axis: usize, n: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]).floor().max(0.0) as usize;
            low..(a[axis].max(b[axis]).max(c[axis]).ceil().max(0.0) as usize).min(n)
        };
        let places = span(1, height).flat_map(|y| span(0, width).map(move |x| (x, y)));
        for (x, y) in places {
            let p = [x as f64 + 0.5, y as f64 + 0.5, 0.0];
            let weights =
                [doubled_area(p, b, c), doubled_area(a, p, c), doubled_area(a, b, p)].map(|w| w / double_area);
            if weights.iter().all(|w| *w >= 0.0) {
                let (height, sample) = (face.height(weights), &mut self.samples[y * width + x]);
                if height > sample.height {
                    *sample = face.sample(weights, height);
                }
            }
        }
    }

    /// Returns the picture; each pixel is the mean of its samples.
    pub(super) fn resolve(&self) -> Vec<PicturePixel> {
        let [width, height] = self.size;
        let at =
            |x: usize, y: usize, i: usize| (y * SAMPLES + i / SAMPLES) * width * SAMPLES + x * SAMPLES + i % SAMPLES;
        let group = |x: usize, y: usize| std::array::from_fn(|i| self.samples[at(x, y, i)]);
        (0..height).flat_map(|y| (0..width).map(move |x| mean(group(x, y)))).collect()
    }
}

impl RasterTriangle {
    fn new(corners: [[f64; 3]; 3], speeds: [f64; 3], material: PolygonMaterial, shade: f64) -> Self {
        Self { corners, speeds, material, shade, lines: [f64::NEG_INFINITY; 3], darkness: 0.0 }
    }

    /// Adds mesh lines along the selected edges, each opposite to its corner, on a face of this area, doubled. The
    /// lines fade out on elements of a few pixels.
    fn with_lines(self, edges: [bool; 3], double_area: f64) -> Self {
        let line = |i: usize| {
            let [p, q] = [self.corners[(i + 1) % 3], self.corners[(i + 2) % 3]];
            0.5 * SAMPLES as f64 * (p[0] - q[0]).hypot(p[1] - q[1]) / double_area
        };
        let lines = [0, 1, 2].map(|i| if edges[i] { line(i) } else { f64::NEG_INFINITY });
        Self { lines, darkness: 0.4 * ((double_area.sqrt() / SAMPLES as f64 - 4.0) / 10.0).clamp(0.0, 1.0), ..self }
    }

    fn height(&self, weights: [f64; 3]) -> f32 {
        blend(weights, self.corners.map(|corner| corner[2]))
    }

    fn sample(&self, weights: [f64; 3], height: f32) -> DepthSample {
        let is_on_line = (0..3).any(|i| weights[i] < self.lines[i]);
        let shade = if is_on_line { self.shade * (1.0 - self.darkness) } else { self.shade };
        DepthSample { height, shade: shade as f32, speed: blend(weights, self.speeds), material: Some(self.material) }
    }
}

/// Returns the weighted sum Σ w x.
fn blend(weights: [f64; 3], values: [f64; 3]) -> f32 {
    (0..3).map(|i| weights[i] * values[i]).sum::<f64>() as f32
}

/// Returns twice the signed area of a triangle in the picture.
fn doubled_area(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn normal(corners: &[PolygonCorner]) -> Vector3 {
    let [a, b, c] = [0, 1, 2].map(|i| corners[i].at);
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::zeros)
}

fn mean(samples: [DepthSample; SAMPLES * SAMPLES]) -> PicturePixel {
    let gel: Vec<&DepthSample> = samples.iter().filter(|sample| sample.step().is_some()).collect();
    let body: Vec<&DepthSample> =
        samples.iter().filter(|sample| sample.material == Some(PolygonMaterial::Body)).collect();
    let average = |of: &[&DepthSample], value: fn(&DepthSample) -> f32| {
        of.iter().map(|sample| value(sample)).sum::<f32>() / of.len().max(1) as f32
    };
    let byte = |part: f32| (255.0 * part).round().clamp(0.0, 255.0) as u8;
    // The upper half of an f32 keeps 8 significant bits, finer than the colours.
    let half = |value: f32| (value.to_bits() >> 16) as u16;
    PicturePixel {
        gel: byte(gel.len() as f32 / samples.len() as f32),
        body: byte(body.len() as f32 / samples.len() as f32),
        gel_shade: byte(average(&gel, |sample| sample.shade)),
        body_shade: byte(average(&body, |sample| sample.shade)),
        speed: half(average(&gel, |sample| sample.speed)),
        step: half(average(&gel, |sample| sample.step().unwrap_or(0.0))),
    }
}
