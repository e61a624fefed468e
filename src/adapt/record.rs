//! Record of a remeshing.

use crate::remesh::MeshQuality;
use crate::remesh::operations::EditCounts;

/// Record of a remeshing.
#[derive(Debug, Clone, PartialEq)]
pub struct RemeshRecord {
    /// Time, s.
    pub time: f64,
    /// Number of the successful attempt, from 1.
    pub attempt: usize,
    /// Quality of the new mesh.
    pub quality: MeshQuality,
    /// Fraction of the mass that was deposited where no new element covers the old ones.
    pub mass: f64,
    /// Momentum defect before any correction, apart from held nodes, N·s.
    pub momentum: f64,
    /// Kinetic energy before and after, J.
    pub kinetic: [f64; 2],
    /// Change of kinetic and stored energy with what was returned, J.
    pub energy: f64,
    /// Elements of the new mesh.
    pub elements: usize,
    /// Fraction of the new elements that are elements of the old mesh.
    pub unchanged: f64,
    /// Local operations; none of a mesh that was made as a whole.
    pub edits: EditCounts,
    /// Wall-clock time of all attempts, s.
    pub seconds: f64,
}
