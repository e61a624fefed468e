//! Plane picture of triangles and lines, drawn with supersampling.

use crate::output::picture::png;

/// Point in the plane of the picture, m.
pub(super) type PlanePoint = [f64; 2];
pub(super) type RgbColour = [u8; 3];

/// Samples per pixel along each side.
const SAMPLES: usize = 3;
/// Width and height of a picture, pixels.
const SIZE: usize = 720;

/// Square of the plane visible in a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PictureWindow {
    pub centre: PlanePoint,
    /// Half of the edge length, m.
    pub half: f64,
}

/// Canvas of a picture; the background is white.
pub(super) struct PictureCanvas {
    window: PictureWindow,
    samples: Vec<RgbColour>,
}

/// Pen: line width, pixels, and opacity, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LinePen {
    pub width: f64,
    pub strength: f64,
    pub colour: RgbColour,
}

impl PictureCanvas {
    pub fn new(window: PictureWindow) -> Self {
        Self { window, samples: vec![[255; 3]; SIZE * SIZE * SAMPLES * SAMPLES] }
    }

    /// Returns the number of samples per metre.
    fn scale(&self) -> f64 {
        (SIZE * SAMPLES) as f64 / (2.0 * self.window.half)
    }

    /// Converts a length, m, to pixels.
    pub fn pixels(&self, length: f64) -> f64 {
        length * self.scale() / SAMPLES as f64
    }

    /// Converts a point to samples from the top left corner.
    fn to_samples(&self, [x, z]: PlanePoint) -> PlanePoint {
        let PictureWindow { centre, half } = self.window;
        [(x - centre[0] + half) * self.scale(), (centre[1] + half - z) * self.scale()]
    }

    /// Fills a triangle; `colour` receives the barycentric coordinates.
    pub fn fill(&mut self, corners: [PlanePoint; 3], colour: impl Fn([f64; 3]) -> RgbColour) {
        let [a, b, c] = corners.map(|corner| self.to_samples(corner));
        let double_area = doubled_area(a, b, c);
        if double_area == 0.0 {
            return;
        }
        self.for_each_sample([a, b, c].as_slice(), 0.0, |p, sample| {
            let weights =
                [doubled_area(p, b, c), doubled_area(a, p, c), doubled_area(a, b, p)].map(|share| share / double_area);
            if weights.iter().all(|share| *share >= 0.0) {
                *sample = colour(weights);
            }
        });
    }

    /// Draws a line.
    pub fn line(&mut self, ends: [PlanePoint; 2], pen: &LinePen) {
        let [a, b] = ends.map(|end| self.to_samples(end));
        let reach = 0.5 * pen.width * SAMPLES as f64;
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        self.for_each_sample([a, b].as_slice(), reach, |p, sample| {
            let from = [p[0] - a[0], p[1] - a[1]];
            let share = ((from[0] * along[0] + from[1] * along[1]) / squared.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            if (from[0] - share * along[0]).hypot(from[1] - share * along[1]) <= reach {
                let mixed =
                    |i: usize| f64::from(sample[i]) * (1.0 - pen.strength) + f64::from(pen.colour[i]) * pen.strength;
                *sample = [0, 1, 2].map(|i| mixed(i).round() as u8);
            }
        });
    }

    /// Draws a round dot.
    pub fn dot(&mut self, at: PlanePoint, pen: &LinePen) {
        self.line([at, at], pen);
    }

    /// Calls `paint` with the centre of every sample in the bounding box of some points, grown by `reach`.
    fn for_each_sample(
        &mut self,
        points: &[PlanePoint],
        reach: f64,
        mut paint: impl FnMut(PlanePoint, &mut RgbColour),
    ) {
        let side = SIZE * SAMPLES;
        let span = |axis: usize| {
            let ends = points.iter().map(|p| p[axis]);
            let (low, high) = ends.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            (low - reach).floor().max(0.0) as usize..((high + reach).ceil().max(0.0) as usize).min(side)
        };
        for y in span(1) {
            for x in span(0) {
                paint([x as f64 + 0.5, y as f64 + 0.5], &mut self.samples[y * side + x]);
            }
        }
    }

    /// Returns the picture as a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let mean = |x: usize, y: usize| {
            let sample =
                |i: usize| self.samples[(y * SAMPLES + i / SAMPLES) * SIZE * SAMPLES + x * SAMPLES + i % SAMPLES];
            let sum = |k: usize| (0..SAMPLES * SAMPLES).map(|i| usize::from(sample(i)[k])).sum::<usize>();
            [0, 1, 2].map(|k| (sum(k) / (SAMPLES * SAMPLES)) as u8)
        };
        let pixels = (0..SIZE * SIZE).map(|i| mean(i % SIZE, i / SIZE));
        png([SIZE, SIZE], pixels.map(|[r, g, b]| [r, g, b, 255]))
    }
}

/// Returns twice the signed area of a triangle.
fn doubled_area(a: PlanePoint, b: PlanePoint, c: PlanePoint) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
