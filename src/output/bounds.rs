//! Boxes around things.

use crate::math::Vector3;

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) lower: Vector3,
    pub(super) upper: Vector3,
}

impl Bounds {
    /// The smallest box around points; a point at the origin if there are none.
    pub(super) fn around(points: impl IntoIterator<Item = Vector3>) -> Self {
        let boxes = points.into_iter().map(|p| Self { lower: p, upper: p });
        boxes.reduce(|a, b| a.with(&b)).unwrap_or(Self { lower: Vector3::zeros(), upper: Vector3::zeros() })
    }

    /// The smallest box around both.
    pub(super) fn with(&self, other: &Self) -> Self {
        Self { lower: self.lower.inf(&other.lower), upper: self.upper.sup(&other.upper) }
    }

    /// The part of this box in the other one grown by `margin`, m, on every side.
    pub(super) fn near(&self, other: &Self, margin: f64) -> Self {
        let room = other.grown(margin);
        let clamp = |p: &Vector3| p.sup(&room.lower).inf(&room.upper);
        Self { lower: clamp(&self.lower), upper: clamp(&self.upper) }
    }

    /// This box grown by `margin`, m, on every side.
    pub(super) fn grown(&self, margin: f64) -> Self {
        Self { lower: self.lower.add_scalar(-margin), upper: self.upper.add_scalar(margin) }
    }

    pub(super) fn centre(&self) -> Vector3 {
        0.5 * (self.lower + self.upper)
    }

    /// Half the diagonal, m.
    pub(super) fn radius(&self) -> f64 {
        0.5 * (self.upper - self.lower).norm()
    }

    pub(super) fn corners(&self) -> impl Iterator<Item = Vector3> + '_ {
        (0..8).map(|bits| {
            Vector3::from_fn(|axis, _| if bits >> axis & 1 == 0 { self.lower[axis] } else { self.upper[axis] })
        })
    }
}
