//! Upright rectangles, and the order of points along a curve that stays near itself.

use crate::algebra::Vector;

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
    pub const NONE: Self =
        Self { low: Vector::<2>::new(f64::MAX, f64::MAX), high: Vector::<2>::new(-f64::MAX, -f64::MAX) };

    /// The smallest rectangle around these points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector<2>>) -> Self {
        points.into_iter().fold(Self::NONE, |all, p| Self { low: all.low.inf(p), high: all.high.sup(p) })
    }

    /// The square about a point, `reach` to every side.
    pub fn about(point: &Vector<2>, reach: f64) -> Self {
        let reach = Vector::<2>::repeat(reach);
        Self { low: point - reach, high: point + reach }
    }

    /// The smallest rectangle around both.
    pub fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Whether they have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        self.low[0] <= other.high[0]
            && other.low[0] <= self.high[0]
            && self.low[1] <= other.high[1]
            && other.low[1] <= self.high[1]
    }

    /// Squared distance of a point, m²; 0 inside.
    pub fn distance_squared(&self, p: &Vector<2>) -> f64 {
        (self.low - p).sup(&(p - self.high)).sup(&Vector::<2>::zeros()).norm_squared()
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
    fn bits_stand_in_turn() {
        assert_eq!(morton([0b11, 0b01]), 0b0111);
        assert_eq!(morton([u32::MAX, 0]), 0x5555_5555_5555_5555);
    }
}
