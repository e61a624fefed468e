//! Why there is no new mesh.

use crate::mesh::NodeId;

/// No new mesh can be made of this one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RemeshError {
    /// Not one size, or not one position, per node.
    #[error(
        "the mesh has {nodes} nodes, but {sizes} target sizes and {positions} positions: give one of each per node"
    )]
    Counts {
        /// Nodes of the old mesh.
        nodes: usize,
        /// Sizes given.
        sizes: usize,
        /// Positions given.
        positions: usize,
    },
    /// A target size that is not a length.
    #[error("node {} has the target size {size:e} m: sizes are positive and finite", node.0)]
    Size {
        /// The node.
        node: NodeId,
        /// Its size, m.
        size: f64,
    },
    /// A node that is nowhere.
    #[error(
        "node {} is at ({:e} m, {:e} m, {:e} m): the state has diverged before this remesh",
        node.0, place[0], place[1], place[2]
    )]
    NotFinite {
        /// The node.
        node: NodeId,
        /// Where it is, m.
        place: [f64; 3],
    },
    /// More points than a mesh may have.
    #[error("these target sizes ask for about {points:.3e} points, more than {most}: raise the least size")]
    TooMany {
        /// Points asked for.
        points: f64,
        /// Points allowed.
        most: usize,
    },
    /// A way to make meshes that there is not in space.
    #[error("a mesh can be immersed in the plane only: use the method that retains old nodes")]
    PlaneOnly,
    /// The boundary crosses itself.
    #[error(
        "the boundary crosses itself: the edge of nodes {} and {} crosses that of nodes {} and {}; remesh before it does",
        edges[0][0].0, edges[0][1].0, edges[1][0].0, edges[1][1].0
    )]
    Crossing {
        /// The two edges.
        edges: [[NodeId; 2]; 2],
    },
    /// An edge that cannot be an edge of the new mesh.
    #[error(
        "the edge from ({} m, {} m) to ({} m, {} m) crosses another or goes through a point: the boundary touches itself there",
        edge[0][0], edge[0][1], edge[1][0], edge[1][1]
    )]
    Blocked {
        /// Its ends, m.
        edge: [[f64; 2]; 2],
    },
    /// Two points in one place.
    #[error("two points of the new mesh are at ({} m, {} m): the boundary touches itself there", place[0], place[1])]
    Coincident {
        /// Where, m.
        place: [f64; 2],
    },
    /// A point too far away for exact predicates.
    #[error("the point ({} m, {} m) is beyond what exact predicates allow", place[0], place[1])]
    Place {
        /// Where, m.
        place: [f64; 2],
    },
}
