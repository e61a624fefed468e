//! Axis-aligned bounding boxes, and Morton order of points.

use crate::math::Vector;

/// Axis-aligned bounding rectangle or box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BoundingBox<const D: usize> {
    /// Lower corner, m.
    pub low: Vector<D>,
    /// Upper corner, m.
    pub high: Vector<D>,
}

impl<const D: usize> BoundingBox<D> {
    /// Empty box: the neutral element of the union.
    pub const NONE: Self = Self { low: all(f64::MAX), high: all(-f64::MAX) };

    /// Smallest box around points.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector<D>>) -> Self {
        points.into_iter().fold(Self::NONE, |all, point| all.with(point))
    }

    /// Smallest box around this one and a point.
    #[inline]
    pub fn with(&self, point: &Vector<D>) -> Self {
        Self { low: self.low.inf(point), high: self.high.sup(point) }
    }

    /// Square or cube about a point, `reach` to every side.
    pub fn about(point: &Vector<D>, reach: f64) -> Self {
        let reach = Vector::<D>::repeat(reach);
        Self { low: point - reach, high: point + reach }
    }

    /// Union of two boxes.
    #[inline]
    pub fn joined(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Returns true if two boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..D).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// Squared distance of a point, m²; 0 inside the box.
    pub fn distance_squared(&self, p: &Vector<D>) -> f64 {
        (self.low - p).sup(&(p - self.high)).sup(&Vector::<D>::zeros()).norm_squared()
    }

    /// Support function of the box along a direction.
    pub fn reach(&self, direction: &Vector<D>) -> f64 {
        (0..D).map(|i| (self.low[i] * direction[i]).max(self.high[i] * direction[i])).sum()
    }
}

/// Vector of equal components.
const fn all<const D: usize>(component: f64) -> Vector<D> {
    Vector::<D>::from_array_storage(nalgebra::ArrayStorage([[component; D]]))
}

/// Order of points along a Morton curve over the square or cube around them.
pub(crate) fn morton_order<const D: usize>(points: &[Vector<D>]) -> Vec<u32> {
    // A 64-bit key holds 32 bits of each coordinate in the plane, 21 in space.
    let most = if D == 2 { u32::MAX } else { (1 << 21) - 1 };
    let bounds = BoundingBox::around(points);
    let edge = (bounds.high - bounds.low).max().max(f64::MIN_POSITIVE);
    let cell = |p: &Vector<D>| -> [u32; D] { ((p - bounds.low) / edge * f64::from(most)).map(|x| x as u32).into() };
    let mut keyed: Vec<(u64, u32)> = points.iter().enumerate().map(|(i, p)| (morton(cell(p)), i as u32)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// Interleaves the bits of the numbers.
fn morton<const D: usize>(numbers: [u32; D]) -> u64 {
    let spread = if D == 2 { twice } else { thrice };
    numbers.iter().zip(0..).fold(0, |bits, (number, axis): (&u32, u32)| bits | spread(*number) << axis)
}

/// Moves every bit of a number to twice its position.
fn twice(number: u32) -> u64 {
    let steps = [
        (16, 0x0000_ffff_0000_ffff),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ];
    steps.iter().fold(u64::from(number), |bits, (by, mask)| (bits | bits << by) & mask)
}

/// Moves every bit of a 21-bit number to three times its position.
fn thrice(number: u32) -> u64 {
    let steps = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
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
        assert_eq!(morton([0b11, 0b01, 0b10]), 0b101_011);
        let every: u64 = (0..21).map(|bit| 1 << (3 * bit)).sum();
        assert_eq!(
            [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|n| morton(n.map(|n| n * 0x1f_ffff))),
            [every, 2 * every, 4 * every]
        );
    }
}
