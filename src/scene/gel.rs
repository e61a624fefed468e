//! Extent of a gel at rest: its thickness and its bounding box.

use super::GelShape;
use crate::math::Vector3;

/// Bounding box of a gel at rest, m; infinite across the plane of a planar gel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GelBox {
    /// Lower corner.
    pub lower: Vector3,
    /// Upper corner.
    pub upper: Vector3,
}

impl GelShape {
    /// Thickness from the entry surface to the back face at rest, m; `None` for a shape without a flat back face.
    #[must_use]
    pub fn thickness(&self) -> Option<f64> {
        match self {
            Self::Block { size } => size.last().copied(),
            Self::Cylinder { height, .. } => Some(*height),
            Self::Shell { .. } | Self::LBeam { .. } => None,
        }
    }

    /// Bounding box of a block or a cylinder at rest.
    #[must_use]
    pub fn bounding_box(&self) -> Option<GelBox> {
        let [x, y] = match self {
            Self::Block { size } if size.len() == 3 => [0.5 * size[0], 0.5 * size[1]],
            Self::Block { size } => [0.5 * size[0], f64::INFINITY],
            Self::Cylinder { radius, .. } => [*radius; 2],
            Self::Shell { .. } | Self::LBeam { .. } => return None,
        };
        Some(GelBox { lower: Vector3::new(-x, -y, -self.thickness()?), upper: Vector3::new(x, y, 0.0) })
    }
}
