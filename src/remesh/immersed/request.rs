//! Checks of what an immersed mesh is asked for.

use crate::math::embed;
use crate::mesh::{Facet, NodeId, Simplex, facet_measure, signed_volume};
use crate::remesh::error::at_most;
use crate::remesh::{DeformedMesh, RemeshError};

/// Greatest number of points of a mesh.
pub(super) const MAX_POINTS: usize = 4_000_000;

/// Checks the old mesh and its target sizes.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions.
pub(super) fn check(old: &DeformedMesh<'_, 2>, size: &[f64]) -> Result<(), RemeshError> {
    let nodes = old.mesh.rest.len();
    if size.len() != nodes || old.position.len() != nodes {
        return Err(RemeshError::Counts { nodes, sizes: size.len(), positions: old.position.len() });
    }
    let id = |n: usize| NodeId(n as u32);
    if let Some(n) = size.iter().position(|h| !(h.is_finite() && *h > 0.0)) {
        return Err(RemeshError::Size { node: id(n), size: size[n] });
    }
    if let Some(n) = old.position.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
        return Err(RemeshError::NotFinite { node: id(n), place: embed(&old.position[n]).into() });
    }
    at_most(estimate(old, size), MAX_POINTS)
}

/// Estimates the number of points of a mesh of these sizes from the area and from the length of the boundary, each over
/// that of a point.
fn estimate(old: &DeformedMesh<'_, 2>, size: &[f64]) -> f64 {
    let least = |nodes: &[NodeId]| nodes.iter().map(|n| size[n.index()]).fold(f64::MAX, f64::min);
    let inside = |e: &Simplex| signed_volume(old.position, e).abs() / least(&e[..3]).powi(2);
    let along = |f: &Facet| facet_measure(old.position, f) / least(&f[..2]);
    old.mesh.elements.iter().map(inside).sum::<f64>() + old.mesh.facets.iter().map(along).sum::<f64>()
}
