//! Attempts of the immersed method, and the generator of their meshes.

use crate::remesh::{self, DeformedMesh, ImmersionSteps, ProposedMesh, RemeshError};

/// Mesh generator of a dimension for target sizes of the nodes, m, and the factor by which an attempt scales them: returns a
/// proposal and its tolerance for the change of area.
pub(super) type MeshGenerator<const D: usize> =
    fn(&DeformedMesh<'_, D>, &[f64], f64) -> Result<(ProposedMesh<D>, f64), RemeshError>;

/// Factors of the target sizes of the attempts, in their order.
pub(super) const SIZE_FACTORS: [f64; 3] = [1.0, 0.7, 0.5];
/// Tolerance for the relative change of area beside that of cutting.
const AREA_TOLERANCE: f64 = 1e-5;

/// Generates a mesh by the immersed method.
pub(super) fn generate_mesh(
    moved: &DeformedMesh<'_, 2>,
    size: &[f64],
    size_factor: f64,
) -> Result<(ProposedMesh<2>, f64), RemeshError> {
    let size: Vec<f64> = size.iter().map(|size| size_factor * size).collect();
    let ImmersionSteps { proposal, .. } = remesh::immerse(moved, &size)?;
    Ok((proposal, AREA_TOLERANCE + remesh::rounding(moved, &size)))
}
