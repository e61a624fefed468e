//! Interface of the makers of a new mesh, and the rules of remeshing.

use super::error::at_most;
use super::{DeformedMesh, ProposedMesh, RemeshError};
use crate::math::{Vector, embed};
use crate::mesh::{Facet, NodeId, Simplex, facet_measure, signed_volume};

/// Maker of a new mesh of a deformed body: a pure function.
pub trait Mesher<const D: usize> {
    /// Makes a mesh.
    ///
    /// # Errors
    /// [`RemeshError`] for invalid sizes or positions, or if the maker cannot mesh this boundary.
    fn remesh(&self, request: &MeshRequest<'_, D>) -> Result<Remeshed<D>, RemeshError>;
}

/// Request of a new mesh.
#[derive(Clone, Copy)]
pub struct MeshRequest<'a, const D: usize> {
    /// Old mesh.
    pub old: DeformedMesh<'a, D>,
    /// Target sizes by node of the old mesh, m. They should satisfy the growth limit of [`graded`](super::graded).
    pub size: &'a [f64],
    /// Rules.
    pub rules: RemeshRules,
    /// Projection of a point to the nearest position outside all bodies.
    pub cleared: &'a dyn Fn(&Vector<D>) -> Vector<D>,
}

/// New mesh of a body, without fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Remeshed<const D: usize> {
    /// Mesh.
    pub proposal: ProposedMesh<D>,
    /// Greatest relative change of area or volume that the method itself causes.
    pub rounding: f64,
}

/// Rules of remeshing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RemeshRules {
    /// Quality, q = 4√3 A/Σl², from which an element is kept if its neighbours are good too. Right-angled halves of a
    /// square have 0.87, triangles with angles 30°, 30° and 120° have 0.6.
    pub good: f64,
    /// Quality of the worst element up to which an interior node is given up. A needle of 10° has 0.3.
    pub poor: f64,
    /// Sagitta limit for leaving out a boundary node: a fraction of the new chord, now and, if `rests`, at rest, and of
    /// the longest permitted edge. 0 keeps all nodes.
    pub sag: f64,
    /// Greatest distance, in target lengths, that a surface point in space may slide off its facets to improve its
    /// elements; 0 disables sliding.
    pub slide: f64,
    /// True for a gel with a surface at rest, whose corners stay and along which a new surface lies. A two-network gel has
    /// none.
    pub rests: bool,
    /// Greatest number of points of a mesh.
    pub most: usize,
}

impl Default for RemeshRules {
    fn default() -> Self {
        Self { good: 0.5, poor: 0.3, sag: 0.06, slide: 0.0, rests: true, most: 4_000_000 }
    }
}

/// Checks the old mesh and its target sizes.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions.
pub(super) fn check<const D: usize>(
    old: &DeformedMesh<'_, D>,
    size: &[f64],
    rules: &RemeshRules,
) -> Result<(), RemeshError> {
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
    at_most(estimate(old, size), rules.most)
}

/// Estimates the number of points of a mesh of these sizes from areas or volumes, and from the boundary measure, each
/// over that of a point.
fn estimate<const D: usize>(old: &DeformedMesh<'_, D>, size: &[f64]) -> f64 {
    let least = |nodes: &[NodeId]| nodes.iter().map(|n| size[n.index()]).fold(f64::MAX, f64::min);
    let power = |size: f64, n: usize| (0..n).map(|_| size).product::<f64>();
    let inside = |e: &Simplex| signed_volume(old.position, e).abs() / power(least(&e[..=D]), D);
    let along = |f: &Facet| facet_measure(old.position, f) / power(least(&f[..D]), D - 1);
    old.mesh.elements.iter().map(inside).sum::<f64>() + old.mesh.facets.iter().map(along).sum::<f64>()
}
