//! Triangles and tetrahedra: their sizes, kinematic models and reference shapes.

use crate::math::{Tensor, Vector};
use crate::mesh::{Simplex, edges};

/// Most nodes of an element.
pub const MAX_NODES: usize = 4;
/// Most elements of a patch.
pub const DEPTH: usize = max_patch_size(3);

/// Returns the most elements of a patch: pairs in the plane, fours in space.
#[must_use]
pub const fn max_patch_size(dimensions: usize) -> usize {
    2 * (dimensions - 1)
}

/// Kinematic model of the gel: plane strain, axisymmetric or three-dimensional.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Section {
    /// Plane strain in (x, z), for a thickness, m.
    Planar {
        /// Thickness, m.
        thickness: f64,
    },
    /// Axisymmetry in (r, z), for the full revolution.
    Axisymmetric,
    /// Three dimensions.
    Spatial,
}

impl Section {
    /// Returns the volume of an element over its measure: the thickness of its area, m, 2π of its area times its radius, or 1.
    #[must_use]
    pub fn extent(self) -> f64 {
        match self {
            Self::Planar { thickness } => thickness,
            Self::Axisymmetric => std::f64::consts::TAU,
            Self::Spatial => 1.0,
        }
    }
}

/// Reference shape of an incompatible element.
///
/// After a remesh the rest positions of the nodes need not be the rest shape of the elements between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceShape<const D: usize> {
    /// Edges from the first node at rest, as columns, m.
    pub edges: Tensor<D>,
    /// R̄ of a ring, m.
    pub radius: f64,
}

impl<const D: usize> ReferenceShape<D> {
    /// Returns the shape of an element with its nodes at these rest positions.
    #[must_use]
    pub fn of(rest: &[Vector<D>], nodes: &Simplex) -> Self {
        let radius = nodes[..=D].iter().map(|n| rest[n.index()][0]).sum::<f64>() / (D + 1) as f64;
        Self { edges: edges(rest, nodes), radius }
    }
}
