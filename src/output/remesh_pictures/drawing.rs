//! A plane picture of triangles and lines.

use crate::output::picture::png;

/// A point of the picture's plane, m.
pub(super) type Point = [f64; 2];
pub(super) type Colour = [u8; 3];

/// Samples of a pixel along each side.
const FINE: usize = 3;
/// Width and height of a picture, pixels.
const SIZE: usize = 720;

/// The square of the plane that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub centre: Point,
    /// Half of its edge, m.
    pub half: f64,
}

/// A picture in the making, white where nothing is drawn.
pub(super) struct Drawing {
    window: Window,
    samples: Vec<Colour>,
}

/// A line: how wide, pixels, and how much of what is under it it hides, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pen {
    pub width: f64,
    pub strength: f64,
    pub colour: Colour,
}

impl Drawing {
    pub fn new(window: Window) -> Self {
        Self { window, samples: vec![[255; 3]; SIZE * SIZE * FINE * FINE] }
    }

    /// Samples per metre.
    fn scale(&self) -> f64 {
        (SIZE * FINE) as f64 / (2.0 * self.window.half)
    }

    /// Pixels that a length takes.
    pub fn pixels(&self, length: f64) -> f64 {
        length * self.scale() / FINE as f64
    }

    /// In samples from the top left corner.
    fn place(&self, [x, z]: Point) -> Point {
        let Window { centre, half } = self.window;
        [(x - centre[0] + half) * self.scale(), (centre[1] + half - z) * self.scale()]
    }

    /// Fills a triangle; `colour` is asked with the shares of its corners.
    pub fn fill(&mut self, corners: [Point; 3], colour: impl Fn([f64; 3]) -> Colour) {
        let [a, b, c] = corners.map(|corner| self.place(corner));
        let double = cross(a, b, c);
        if double == 0.0 {
            return;
        }
        self.visit([a, b, c].as_slice(), 0.0, |p, sample| {
            let shares = [cross(p, b, c), cross(a, p, c), cross(a, b, p)].map(|share| share / double);
            if shares.iter().all(|share| *share >= 0.0) {
                *sample = colour(shares);
            }
        });
    }

    /// Draws a line.
    pub fn line(&mut self, ends: [Point; 2], pen: &Pen) {
        let [a, b] = ends.map(|end| self.place(end));
        let reach = 0.5 * pen.width * FINE as f64;
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        self.visit([a, b].as_slice(), reach, |p, sample| {
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
    pub fn dot(&mut self, at: Point, pen: &Pen) {
        self.line([at, at], pen);
    }

    /// Shows the samples in the box around some points, grown by `reach`, by their middles.
    fn visit(&mut self, points: &[Point], reach: f64, mut paint: impl FnMut(Point, &mut Colour)) {
        let side = SIZE * FINE;
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

    /// The picture as a PNG file.
    pub fn png(&self) -> Vec<u8> {
        let mean = |x: usize, y: usize| {
            let sample = |i: usize| self.samples[(y * FINE + i / FINE) * SIZE * FINE + x * FINE + i % FINE];
            let sum = |k: usize| (0..FINE * FINE).map(|i| usize::from(sample(i)[k])).sum::<usize>();
            [0, 1, 2].map(|k| (sum(k) / (FINE * FINE)) as u8)
        };
        let pixels = (0..SIZE * SIZE).map(|i| mean(i % SIZE, i / SIZE));
        png([SIZE, SIZE], pixels.map(|[r, g, b]| [r, g, b, 255]))
    }
}

/// Twice the signed area of a triangle.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
