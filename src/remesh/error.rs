//! Errors of remeshing.

use crate::mesh::NodeId;

/// Reason why the mesh cannot be remeshed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RemeshError {
    /// Number of sizes or positions differs from the number of nodes.
    #[error(
        "the mesh has {nodes} nodes, but {sizes} target sizes and {positions} positions: give one of each per node"
    )]
    Counts {
        /// Number of nodes of the old mesh.
        nodes: usize,
        /// Number of sizes.
        sizes: usize,
        /// Number of positions.
        positions: usize,
    },
    /// Target size that is not positive and finite.
    #[error("node {} has the target size {size:e} m: sizes are positive and finite", node.0)]
    Size {
        /// Node.
        node: NodeId,
        /// Target size, m.
        size: f64,
    },
    /// Node position that is not finite.
    #[error(
        "node {} is at ({:e} m, {:e} m, {:e} m): the state diverged before this remeshing",
        node.0, place[0], place[1], place[2]
    )]
    NotFinite {
        /// Node.
        node: NodeId,
        /// Position, m.
        place: [f64; 3],
    },
    /// Estimated number of points above the limit.
    #[error("the target sizes need about {points:.3e} points, expected at most {most}: raise the least size")]
    TooMany {
        /// Estimated number of points.
        points: f64,
        /// Greatest number of points.
        most: usize,
    },
    /// Two coincident points.
    #[error("two points of the new mesh are at ({} m, {} m): the boundary touches itself there", place[0], place[1])]
    Coincident {
        /// Position, m.
        place: [f64; 2],
    },
    /// Coordinates beyond the range of exact predicates.
    #[error("the point ({} m, {} m) is beyond the range of the exact predicates", place[0], place[1])]
    Place {
        /// Position, m.
        place: [f64; 2],
    },
}

/// Checks a number of points against its limit.
///
/// # Errors
/// [`RemeshError::TooMany`] above it.
pub(super) fn at_most(points: f64, most: usize) -> Result<(), RemeshError> {
    if points <= most as f64 { Ok(()) } else { Err(RemeshError::TooMany { points, most }) }
}
