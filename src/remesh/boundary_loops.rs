//! Boundary loops of a plane mesh: their features, their turning angles and their crossings.

use super::DeformedMesh;
use super::triangle::{PlanarPoint, cross, do_cross};
use crate::geometry::{BoundingBox, Bvh};
use crate::mesh::{NodeId, NodeIncidence};

/// Cosine of the turning angle, 30°, beyond which a node is a corner of the body.
const CORNER: f64 = 0.866;

/// Boundary loops of the old mesh as linked lists: the nodes before and after each node with exactly two edges.
struct BoundaryLoops<'a> {
    old: &'a DeformedMesh<'a, 2>,
    before: Vec<Option<usize>>,
    after: Vec<Option<usize>>,
    /// Loads that end at each node.
    ends: Vec<u8>,
    members: Vec<usize>,
}

/// Reason why a boundary node must stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BoundaryFeature {
    /// Corner of the body at rest; fork; or last node that is held in a direction or loaded.
    Always,
    /// Corner of the deformed boundary.
    Now,
}

/// Iterates over the boundary nodes that must stay, in their order.
pub(super) fn features(old: &DeformedMesh<'_, 2>) -> impl Iterator<Item = (usize, BoundaryFeature)> {
    let chain = BoundaryLoops::new(old);
    let members = chain.members.clone();
    members.into_iter().filter_map(move |node| Some((node, chain.feature(node)?)))
}

/// Iterates over the turning angles of the boundary, rad, at nodes with exactly one edge before and one after.
pub(super) fn turns(old: &DeformedMesh<'_, 2>) -> impl Iterator<Item = (usize, f64)> {
    let chain = BoundaryLoops::new(old);
    let members = chain.members.clone();
    members.into_iter().filter_map(move |node| {
        let [before, at, after] = [chain.before[node]?, node, chain.after[node]?].map(|n| &chain.old.position[n]);
        let turn = libm::atan2(cross(before, at, after), (at - before).dot(&(after - at)));
        Some((node, turn.abs()))
    })
}

/// Finds two segments that cross.
pub(super) fn crossing(edges: &[[usize; 2]], x: &[PlanarPoint]) -> Option<[[usize; 2]; 2]> {
    let near = Bvh::segments(edges, x);
    edges.iter().enumerate().find_map(|(i, edge)| {
        let ends = edge.map(|n| &x[n]);
        let mut other = None;
        near.any(&BoundingBox::around(ends), |j| {
            let crosses = j > i && do_cross(ends, edges[j].map(|n| &x[n]));
            other = crosses.then_some(edges[j]);
            crosses
        });
        other.map(|other| [*edge, other])
    })
}

impl<'a> BoundaryLoops<'a> {
    fn new(old: &'a DeformedMesh<'a, 2>) -> Self {
        let groups = old.mesh.facets.iter().map(|f| &f[..2]);
        let incidence = NodeIncidence::new(old.position.len(), groups);
        let mut chain = Self {
            old,
            before: vec![None; old.position.len()],
            after: vec![None; old.position.len()],
            ends: super::load_markers::ends(old.mesh),
            members: (0..old.position.len()).filter(|&n| !incidence.of(NodeId(n as u32)).is_empty()).collect(),
        };
        let is_simple = |n: usize| incidence.of(NodeId(n as u32)).len() == 2;
        for [a, b] in old.mesh.facets.iter().map(|f| [f[0].index(), f[1].index()]) {
            chain.after[a] = is_simple(a).then_some(b);
            chain.before[b] = is_simple(b).then_some(a);
        }
        chain
    }

    /// Reason why a node must stay, if it must.
    fn feature(&self, node: usize) -> Option<BoundaryFeature> {
        let (Some(before), Some(after)) = (self.before[node], self.after[node]) else {
            return Some(BoundaryFeature::Always);
        };
        let held = &self.old.mesh.held;
        let is_corner = |x: &[PlanarPoint]| {
            let (u, v) = (x[node] - x[before], x[after] - x[node]);
            u.dot(&v) < CORNER * u.norm() * v.norm()
        };
        let ends = |other: usize| (0..2).any(|i| held[node][i] && !held[other][i]);
        let is_end = self.ends.get(node).is_some_and(|loads| *loads != 0);
        if ends(before) || ends(after) || is_end || is_corner(&self.old.mesh.rest) {
            return Some(BoundaryFeature::Always);
        }
        is_corner(self.old.position).then_some(BoundaryFeature::Now)
    }
}
