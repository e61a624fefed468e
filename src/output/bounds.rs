//! Axis-aligned bounding boxes.

use crate::math::Vector3;

/// Axis-aligned bounding box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisAlignedBox {
    pub(super) lower: Vector3,
    pub(super) upper: Vector3,
}

impl AxisAlignedBox {
    /// Returns the smallest box around points; without points, the origin.
    pub(super) fn around(points: impl IntoIterator<Item = Vector3>) -> Self {
        let boxes = points.into_iter().map(|p| Self { lower: p, upper: p });
        boxes.reduce(|a, b| a.union(&b)).unwrap_or(Self { lower: Vector3::zeros(), upper: Vector3::zeros() })
    }

    /// Returns the smallest box around both boxes.
    pub(super) fn union(&self, other: &Self) -> Self {
        Self { lower: self.lower.inf(&other.lower), upper: self.upper.sup(&other.upper) }
    }

    #[cfg(feature = "cli")]
    /// Returns the part of this box inside `other` grown by `margin`, m.
    pub(super) fn clipped_to(&self, other: &Self, margin: f64) -> Self {
        let limits = other.grown(margin);
        let clamp = |p: &Vector3| p.sup(&limits.lower).inf(&limits.upper);
        Self { lower: clamp(&self.lower), upper: clamp(&self.upper) }
    }

    #[cfg(feature = "cli")]
    /// Returns this box grown by `margin`, m, on every side.
    pub(super) fn grown(&self, margin: f64) -> Self {
        Self { lower: self.lower.add_scalar(-margin), upper: self.upper.add_scalar(margin) }
    }

    pub(super) fn centre(&self) -> Vector3 {
        0.5 * (self.lower + self.upper)
    }

    /// Returns half of the diagonal, m.
    pub(super) fn radius(&self) -> f64 {
        0.5 * (self.upper - self.lower).norm()
    }

    #[cfg(feature = "cli")]
    pub(super) fn corners(&self) -> impl Iterator<Item = Vector3> + '_ {
        (0..8).map(|bits| {
            Vector3::from_fn(|axis, _| if bits >> axis & 1 == 0 { self.lower[axis] } else { self.upper[axis] })
        })
    }
}
