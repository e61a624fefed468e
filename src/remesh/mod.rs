//! A new mesh for a gel that has moved, and what it carries over: pure functions from a mesh where its nodes are to another one.
//!
//! In the plane the old surface and the old nodes stay where they are good, and so do the elements between them. What is left
//! is filled anew: long edges of the boundary are split, needless nodes left out ([`propose`]), middles of a quadtree's cells
//! put where no point is near, joined by a constrained Delaunay triangulation, and trimmed to the boundary.
//!
//! How fine a mesh should be ([`curved`], [`graded`]), whether a new one may be taken ([`judge`]) and what it carries over
//! ([`transfer()`]) is the same in the plane and in space.

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
use boundary_loops::Surface;
use bounds::Bounds;
use point_insertion::{Limits, Part};
use point_set::Cloud;
use quadtree::Square;
use retained_region::Parts;

pub use acceptance::{Acceptance, Known, Quality, Rejected, judge, judge_known};
pub use adjacency::{Neighbours, neighbours_after};
pub use conservation::{Books, Defects};
pub use correspondence::{Pairing, Same};
pub use curvature::{bends, bends_within};
pub use detached_parts::with_what_hangs_on;
pub use error::RemeshError;
pub use immersed::{
    Background, Cell, Immersed, Steps, cells, cut_out, distances, immerse, rounding, snapped, triangulated,
};
pub use load_markers::marks;
pub use nodal_fields::{Carried, Symmetry, Transferred, corner_masses, lightest, nodal_masses};
pub use point_location::{is_inside, nearest};
pub use self_overlap::overlapped;
pub use sizing::{Range, curved, graded};
pub use supermesh::Source;
pub use thin_features::{sheets, thinned};
pub use transfer::{transfer, transfer_paired};

/// A mesh where its nodes are.
#[derive(Debug, Clone, Copy)]
pub struct Moved<'a, const D: usize> {
    /// The mesh at rest.
    pub mesh: &'a Mesh<D>,
    /// Where its nodes are, m.
    pub position: &'a [Vector<D>],
}

/// Where a node of a new mesh comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// A node of the old mesh, where it was.
    Kept(NodeId),
    /// A point of the old boundary, as weights of the nodes of one of its facets, none negative and of sum 1. An edge of the
    /// plane has two of them: the third stands there again, and weighs nothing.
    Surface([NodeId; 3], [f64; 3]),
    /// A point inside.
    Inside,
}

/// A new mesh of the same body, and nothing on it yet.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal<const D: usize> {
    /// Where the nodes are, m.
    pub position: Vec<Vector<D>>,
    /// Where they come from.
    pub origin: Vec<Origin>,
    /// The elements, positively oriented there.
    pub elements: Vec<Simplex>,
    /// By element, the old elements that it can lie over, ascending; none named where any can, and not at all where that is so of all.
    /// Where a body passes through itself, what is near need not be what an element is made of.
    pub over: Vec<Vec<ElementId>>,
    /// What the area or volume is less by because loops and needles of the boundary were cut off, and new points of it put clear of
    /// bodies, m² or m³.
    pub cleared: f64,
}

/// What a new mesh is made by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Elements of at least this quality, q = 4√3 A/Σl², stay as they are if those around them do. Right-angled halves of a
    /// square have 0.87, triangles with the angles 30°, 30° and 120° have 0.6.
    pub good: f64,
    /// Nodes inside whose worst element is no better than this are given up. A needle of 10° has 0.3.
    pub poor: f64,
    /// Nodes of the boundary are left out where it is within so many chords of the chord without them, now and, if it rests, at rest, and
    /// within as many of the longest edges there may be; 0 leaves all of them in.
    pub sag: f64,
    /// In space, points of the surface go along it to where their elements are better, off its facets by so many target lengths
    /// at most; 0 leaves them where they are.
    pub slide: f64,
    /// Whether the gel has a surface at rest, whose corners stay and along which a new one lies. What flows has none.
    pub rests: bool,
    /// Points of a mesh at most.
    pub most: usize,
}

impl Default for Rules {
    fn default() -> Self {
        Self { good: 0.5, poor: 0.3, sag: 0.06, slide: 0.0, rests: true, most: 4_000_000 }
    }
}

/// A new mesh of a plane body with these target sizes, m, by node. Where the old mesh is good and has these sizes it stays.
///
/// The sizes should grow no faster than [`graded`] allows. Kept nodes come first and in their old order, then points of the
/// old boundary, then those inside; elements of the old mesh come first and in their old order, then new ones.
///
/// New points of the boundary are put where `cleared` says, if that is near.
///
/// # Errors
/// If sizes or positions are no numbers to mesh with, or the boundary meets itself.
pub fn propose(
    old: &Moved<'_, 2>,
    size: &[f64],
    rules: &Rules,
    cleared: &dyn Fn(&Vector<2>) -> Vector<2>,
) -> Result<Proposal<2>, RemeshError> {
    check(old, size, rules)?;
    let limits = Limits { poor: rules.poor, good: rules.good };
    let worst = retained_region::worst(old);
    let mut cloud = Cloud::new(old, size);
    let surface = boundary_loops::resample(old, &mut cloud, (rules, cleared))?;
    point_insertion::keep(old, &worst, &limits, &mut cloud, &surface);
    let parts = retained_region::divide(old, &worst, &limits, &cloud, &surface);
    let filled = if parts.edges.is_empty() { vec![] } else { fill(old, (size, rules.most), &parts, &mut cloud)? };
    Ok(Proposal { cleared: surface.cleared, ..cloud.proposal(&parts.joined(old, &filled)) })
}

/// A new mesh of a body in space with these target sizes, m, by node. Where the old mesh is good and has these sizes it stays.
///
/// The sizes should grow no faster than [`graded`] allows. Kept nodes come first and in their old order, then points of the old
/// surface, then those inside; elements of the old mesh come first and in their old order, then new ones.
///
/// New points of the surface are put where `cleared` says, if the elements around them bear it.
///
/// # Errors
/// If sizes or positions are no numbers to mesh with.
pub fn propose_in_space(
    old: &Moved<'_, 3>,
    size: &[f64],
    rules: &Rules,
    cleared: &dyn Fn(&Vector<3>) -> Vector<3>,
) -> Result<Proposal<3>, RemeshError> {
    check(old, size, rules)?;
    // Without a surface at rest that a new one would have to lie along: the mesh as if it were at rest now.
    let flown = (!rules.rests).then(|| Mesh { rest: old.position.to_vec(), ..old.mesh.clone() });
    let old = flown.as_ref().map_or(*old, |mesh| Moved { mesh, position: old.position });
    Ok(space::propose(&old, size, rules, cleared))
}

/// The new elements between those that stay.
fn fill(
    old: &Moved<'_, 2>,
    (size, most): (&[f64], usize),
    parts: &Parts,
    cloud: &mut Cloud,
) -> Result<Vec<[usize; 3]>, RemeshError> {
    let open = parts.open.iter().map(|e| old.mesh.elements[e.index()]).collect();
    let part = Part::new(old, size, open);
    let around = Surface::around(parts.edges.clone(), cloud);
    point_insertion::fill(&part, (&square(old), most), cloud, &around)?;
    let sites = sites(&part, &around, cloud, old.position.len());
    delaunay::triangulate(&sites, &around, &part, cloud)
}

fn check<const D: usize>(old: &Moved<'_, D>, size: &[f64], rules: &Rules) -> Result<(), RemeshError> {
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

/// About how many points a mesh of these sizes has: areas, or volumes, and those of the boundary over those of a point.
fn estimate<const D: usize>(old: &Moved<'_, D>, size: &[f64]) -> f64 {
    let least = |nodes: &[NodeId]| nodes.iter().map(|n| size[n.index()]).fold(f64::MAX, f64::min);
    let power = |size: f64, n: usize| (0..n).map(|_| size).product::<f64>();
    let inside = |e: &Simplex| signed_volume(old.position, e).abs() / power(least(&e[..=D]), D);
    let along = |f: &Facet| facet_measure(old.position, f) / power(least(&f[..D]), D - 1);
    old.mesh.elements.iter().map(inside).sum::<f64>() + old.mesh.facets.iter().map(along).sum::<f64>()
}

/// The square around the body.
fn square(old: &Moved<'_, 2>) -> Square {
    let Bounds { low, high } = Bounds::around(old.position);
    Square { corner: low, edge: (high - low).max() }
}

/// The points that the new part is made of: ends of its edges, and chosen ones inside.
fn sites(part: &Part<'_>, around: &Surface, cloud: &Cloud, n_old: usize) -> Vec<usize> {
    let mut is_site = vec![false; cloud.position.len()];
    part.nodes().chain(n_old..cloud.position.len()).for_each(|p| is_site[p] = cloud.chosen[p]);
    around.edges.iter().flatten().for_each(|&p| is_site[p] = true);
    (0..is_site.len()).filter(|&p| is_site[p]).collect()
}
