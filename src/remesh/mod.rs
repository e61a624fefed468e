//! Remeshing of a deformed gel, and the transfer of its nodal fields: pure functions from a deformed mesh to a new
//! mesh.
//!
//! In the plane the old boundary and the old nodes stay where they are good, and so do the elements between them. The
//! rest is remeshed: long boundary edges are split and needless boundary nodes are left out ([`propose`]). Centres of
//! quadtree cells are inserted where no point is near. A constrained Delaunay triangulation joins the points and is
//! carved to the boundary.
//!
//! Target sizes ([`sizes_from_curvature`], [`graded`]), acceptance of a new mesh ([`check_acceptance`]) and field transfer ([`transfer()`]) are
//! the same in the plane and in space.

mod acceptance;
mod adjacency;
mod barycentric;
mod boundary_loops;
mod bounds;
mod box_tree;
mod carve;
mod conservation;
mod correspondence;
mod curvature;
mod delaunay;
mod detached_parts;
mod error;
mod immersed;
mod load_markers;
mod nodal_fields;
mod overlap_candidates;
mod overlap_integrals;
mod point_insertion;
mod point_location;
mod point_set;
mod polygon;
mod polyhedron;
mod quadtree;
mod rest_positions;
mod retained_region;
mod self_overlap;
mod sizing;
mod space;
#[cfg(test)]
mod space_transfer_tests;
mod supermesh;
#[cfg(test)]
mod test_bodies;
#[cfg(test)]
mod test_meshes;
#[cfg(test)]
mod tests;
mod thin_features;
mod transfer;
mod triangle;
mod untangle;
mod velocity;
#[cfg(test)]
mod wave_tests;

use crate::math::{Vector, embed};
use crate::mesh::{ElementId, Facet, Mesh, NodeId, Simplex, facet_measure, signed_volume};
use boundary_loops::NewBoundary;
use bounds::BoundingBox;
use point_insertion::{OpenRegion, QualityLimits};
use point_set::PointSet;
use quadtree::RootSquare;
use retained_region::RegionDivision;

pub use acceptance::{
    AcceptanceLimits, KnownQuality, MeshQuality, MeshRejected, check_acceptance, check_acceptance_known,
};
pub use adjacency::{ElementNeighbours, neighbours_after};
pub use conservation::{ConservationDefects, ConservedTotals};
pub use correspondence::{MeshCorrespondence, UnchangedElement};
pub use curvature::{curvature_angles, curvature_angles_within};
pub use detached_parts::with_detached_parts;
pub use error::RemeshError;
pub use immersed::{
    BackgroundCell, BackgroundMesh, ImmersedMesh, ImmersionSteps, cells, cut_out, distances, immerse, rounding,
    snapped, triangulated,
};
pub use load_markers::facet_load_markers;
pub use nodal_fields::{
    BodySymmetry, NodalFields, TransferredFields, corner_masses, least_relative_mass, nodal_masses,
};
pub use point_location::{is_inside, nearest};
pub use self_overlap::self_overlap_mass;
pub use sizing::{SizeRange, graded, sizes_from_curvature};
pub use supermesh::OverlapSource;
pub use thin_features::{limit_sheet_sizes, thin_elements};
pub use transfer::{transfer, transfer_paired};

/// Mesh in its deformed configuration.
#[derive(Debug, Clone, Copy)]
pub struct DeformedMesh<'a, const D: usize> {
    /// Mesh with its rest positions.
    pub mesh: &'a Mesh<D>,
    /// Current positions of the nodes, m.
    pub position: &'a [Vector<D>],
}

/// Origin of a node of a new mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NodeOrigin {
    /// Node of the old mesh at its current position.
    Kept(NodeId),
    /// Point of the old boundary, as weights of the nodes of one of its facets: none negative, of sum 1. An edge of the
    /// plane repeats its second node with weight 0.
    Surface([NodeId; 3], [f64; 3]),
    /// Point in the interior.
    Inside,
}

/// Proposed mesh of the same body, without fields.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedMesh<const D: usize> {
    /// Positions of the nodes, m.
    pub position: Vec<Vector<D>>,
    /// Origins of the nodes.
    pub origin: Vec<NodeOrigin>,
    /// Elements, positively oriented at `position`.
    pub elements: Vec<Simplex>,
    /// Old elements that each new element may overlap, ascending. An empty entry, or an empty list, admits all old
    /// elements. The restriction matters where a body overlaps itself: a nearby old element need not be the source of a
    /// new one.
    pub over: Vec<Vec<ElementId>>,
    /// Loss of area or volume, m² or m³, by cutting off loops and needles of the boundary and by moving new boundary
    /// points out of bodies.
    pub cleared: f64,
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
    /// True for a gel with a surface at rest, whose corners stay and along which a new surface lies. A flowing gel has
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

/// Proposes a mesh of a plane body with these target sizes, m, by node. The old mesh stays where it is good and of
/// these sizes.
///
/// The sizes should satisfy the growth limit of [`graded`]. Kept nodes come first and in their old order, then points
/// of the old boundary, then interior points; kept elements come first and in their old order, then new ones.
///
/// New boundary points are projected by `cleared` where that moves them little.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions, or if the boundary crosses or touches itself.
pub fn propose(
    old: &DeformedMesh<'_, 2>,
    size: &[f64],
    rules: &RemeshRules,
    cleared: &dyn Fn(&Vector<2>) -> Vector<2>,
) -> Result<ProposedMesh<2>, RemeshError> {
    check(old, size, rules)?;
    let limits = QualityLimits { poor: rules.poor, good: rules.good };
    let worst = retained_region::worst(old);
    let mut cloud = PointSet::new(old, size);
    let surface = boundary_loops::resample(old, &mut cloud, (rules, cleared))?;
    point_insertion::keep(old, &worst, &limits, &mut cloud, &surface);
    let parts = retained_region::divide_regions(old, &worst, &limits, &cloud, &surface);
    let filled = if parts.edges.is_empty() { vec![] } else { fill(old, (size, rules.most), &parts, &mut cloud)? };
    Ok(ProposedMesh { cleared: surface.cleared, ..cloud.proposal(&parts.joined(old, &filled)) })
}

/// Proposes a mesh of a body in space with these target sizes, m, by node. The old mesh stays where it is good and of
/// these sizes.
///
/// The sizes should satisfy the growth limit of [`graded`]. Kept nodes come first and in their old order, then points
/// of the old surface, then interior points; kept elements come first and in their old order, then new ones.
///
/// New surface points are projected by `cleared` if the elements around them stay good enough.
///
/// # Errors
/// [`RemeshError`] for invalid sizes or positions.
pub fn propose_in_space(
    old: &DeformedMesh<'_, 3>,
    size: &[f64],
    rules: &RemeshRules,
    cleared: &dyn Fn(&Vector<3>) -> Vector<3>,
) -> Result<ProposedMesh<3>, RemeshError> {
    check(old, size, rules)?;
    // A flowing gel has no surface at rest that a new one must lie along: treat the current configuration as the rest
    // configuration.
    let flown = (!rules.rests).then(|| Mesh { rest: old.position.to_vec(), ..old.mesh.clone() });
    let old = flown.as_ref().map_or(*old, |mesh| DeformedMesh { mesh, position: old.position });
    Ok(space::propose(&old, size, rules, cleared))
}

/// Fills the open region with new elements.
fn fill(
    old: &DeformedMesh<'_, 2>,
    (size, most): (&[f64], usize),
    parts: &RegionDivision,
    cloud: &mut PointSet,
) -> Result<Vec<[usize; 3]>, RemeshError> {
    let open = parts.open.iter().map(|e| old.mesh.elements[e.index()]).collect();
    let part = OpenRegion::new(old, size, open);
    let around = NewBoundary::around(parts.edges.clone(), cloud);
    point_insertion::fill(&part, (&square(old), most), cloud, &around)?;
    let sites = sites(&part, &around, cloud, old.position.len());
    delaunay::triangulate(&sites, &around, &part, cloud)
}

fn check<const D: usize>(old: &DeformedMesh<'_, D>, size: &[f64], rules: &RemeshRules) -> Result<(), RemeshError> {
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

fn at_most(points: f64, most: usize) -> Result<(), RemeshError> {
    if points <= most as f64 { Ok(()) } else { Err(RemeshError::TooMany { points, most }) }
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

/// Root square of the quadtree around the body.
fn square(old: &DeformedMesh<'_, 2>) -> RootSquare {
    let BoundingBox { low, high } = BoundingBox::around(old.position);
    RootSquare { corner: low, edge: (high - low).max() }
}

/// Sites of the triangulation of the open region: ends of its edges, and chosen interior points.
fn sites(part: &OpenRegion<'_>, around: &NewBoundary, cloud: &PointSet, n_old: usize) -> Vec<usize> {
    let mut is_site = vec![false; cloud.position.len()];
    part.nodes().chain(n_old..cloud.position.len()).for_each(|p| is_site[p] = cloud.chosen[p]);
    around.edges.iter().flatten().for_each(|&p| is_site[p] = true);
    (0..is_site.len()).filter(|&p| is_site[p]).collect()
}
