//! What is near what: boxes packed along a Morton curve into a tree of boxes.

use crate::algebra::Vector;

/// Boxes under one box above them.
const FAN: usize = 8;

/// An upright rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    /// The corner of least coordinates, m.
    pub low: Vector<2>,
    /// The corner of greatest coordinates, m.
    pub high: Vector<2>,
}

impl Bounds {
    /// Contains no point: the start of a union.
    const NONE: Self = Self { low: Vector::<2>::new(f64::MAX, f64::MAX), high: Vector::<2>::new(-f64::MAX, -f64::MAX) };

    /// The smallest rectangle around these points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector<2>>) -> Self {
        points.into_iter().fold(Self::NONE, |all, p| Self { low: all.low.inf(p), high: all.high.sup(p) })
    }

    /// The square about a point, `reach` to every side.
    pub fn about(point: &Vector<2>, reach: f64) -> Self {
        let reach = Vector::<2>::repeat(reach);
        Self { low: point - reach, high: point + reach }
    }

    fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low[0] <= other.high[0]
            && other.low[0] <= self.high[0]
            && self.low[1] <= other.high[1]
            && other.low[1] <= self.high[1]
    }
}

/// Rectangles by place.
#[derive(Debug, Clone)]
pub(super) struct Near {
    /// Which rectangle stands where along the curve.
    order: Vec<u32>,
    /// The rectangles along the curve, then those above them, level by level up to one.
    levels: Vec<Vec<Bounds>>,
}

impl Near {
    /// The tree over these rectangles.
    pub fn new(boxes: &[Bounds]) -> Self {
        let middle: Vec<Vector<2>> = boxes.iter().map(|b| 0.5 * (b.low + b.high)).collect();
        let order = along_curve(&middle);
        let mut levels = vec![order.iter().map(|&i| boxes[i as usize]).collect::<Vec<_>>()];
        while let Some(below) = levels.last().filter(|below| below.len() > 1) {
            let above = below.chunks(FAN).map(|some| some.iter().fold(Bounds::NONE, |all, b| all.joined(b))).collect();
            levels.push(above);
        }
        Self { order, levels }
    }

    /// The tree over points.
    pub fn points(points: impl IntoIterator<Item = Vector<2>>) -> Self {
        Self::new(&points.into_iter().map(|p| Bounds { low: p, high: p }).collect::<Vec<_>>())
    }

    /// The tree over line segments.
    pub fn segments(segments: &[[usize; 2]], x: &[Vector<2>]) -> Self {
        Self::new(&segments.iter().map(|s| Bounds::around(s.iter().map(|&i| &x[i]))).collect::<Vec<_>>())
    }

    /// Whether one of the rectangles that meet `area` is what is sought; they are shown until one is.
    pub fn any(&self, area: &Bounds, mut is_sought: impl FnMut(usize) -> bool) -> bool {
        self.descend((self.levels.len() - 1, 0), area, &mut is_sought)
    }

    fn descend(
        &self,
        (level, first): (usize, usize),
        area: &Bounds,
        is_sought: &mut impl FnMut(usize) -> bool,
    ) -> bool {
        let boxes = &self.levels[level];
        for (i, bounds) in boxes.iter().enumerate().skip(first).take(FAN) {
            let found = bounds.meets(area)
                && if level == 0 {
                    is_sought(self.order[i] as usize)
                } else {
                    self.descend((level - 1, i * FAN), area, is_sought)
                };
            if found {
                return true;
            }
        }
        false
    }
}

/// The order of points along a Morton curve over the square around them.
pub(super) fn along_curve(points: &[Vector<2>]) -> Vec<u32> {
    let bounds = Bounds::around(points);
    let edge = (bounds.high - bounds.low).max().max(f64::MIN_POSITIVE);
    let cell = |p: &Vector<2>| ((p - bounds.low) / edge * f64::from(u32::MAX)).map(|x| x as u32);
    let mut keyed: Vec<(u64, u32)> =
        points.iter().enumerate().map(|(i, p)| (morton(cell(p).into()), i as u32)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// The bits of two numbers in turn.
fn morton([a, b]: [u32; 2]) -> u64 {
    spread(a) | spread(b) << 1
}

/// Every bit of a number moved to twice its place.
fn spread(number: u32) -> u64 {
    let steps = [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ];
    steps.iter().fold(u64::from(number), |bits, (by, mask)| (bits | bits << by) & mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_walk_through_all_points_finds() {
        let points: Vec<Vector<2>> =
            (0..500).map(|i| Vector::<2>::new(f64::from(i * i % 97), f64::from(i * 7 % 61))).collect();
        let near = Near::points(points.iter().copied());
        for i in 0..40 {
            let area = Bounds::about(&Vector::<2>::new(f64::from(i) * 2.5, f64::from(i * 5 % 61)), f64::from(i % 9));
            let mut found = vec![];
            assert!(!near.any(&area, |i| {
                found.push(i);
                false
            }));
            found.sort_unstable();
            let inside = |p: &Vector<2>| area.meets(&Bounds { low: *p, high: *p });
            let walked: Vec<usize> = (0..points.len()).filter(|&i| inside(&points[i])).collect();
            assert_eq!(found, walked);
        }
    }

    #[test]
    fn a_tree_of_nothing_finds_nothing() {
        assert!(!Near::new(&[]).any(&Bounds::about(&Vector::<2>::zeros(), 1.0), |_| true));
    }

    #[test]
    fn bits_stand_in_turn() {
        assert_eq!(morton([0b11, 0b01]), 0b0111);
        assert_eq!(morton([u32::MAX, 0]), 0x5555_5555_5555_5555);
    }
}
