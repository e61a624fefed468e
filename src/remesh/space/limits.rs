//! Limits of length and quality of tetrahedra.

/// Edges of a tetrahedron.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// Length, in target lengths, above which an edge is split: the diagonal of a cube of Kuhn's lattice has 1.73.
pub(super) const LONG: f64 = 1.8;
/// Length, in target lengths, below which an edge is collapsed: where the centred lattice meets its boundary edges have
/// 0.5.
pub(super) const SHORT: f64 = 0.45;
/// Quality below which a tetrahedron is improved; those of the centred lattice have 0.8. More changes cost more energy:
/// a ball of 20 m/s at R/2 lost 3.5 % in 3 ms with 0.5 (11 meshes), 1.6 % with 0.35 (16).
pub(super) const FAIR: f64 = 0.35;
/// Gain in the cubed quality that makes an operation worthwhile.
pub(super) const GAIN: f64 = 1.02;
/// Depth, in target lengths, that surface points may stand in a body: twice the depth that contact leaves, for a
/// two-network gel exactly that depth.
pub(super) const STANDING: f64 = 0.06;
/// Cubed quality.
pub(super) fn cube(quality: f64) -> f64 {
    quality * quality * quality
}
