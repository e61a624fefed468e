//! Boundary loops of a plane mesh: their order, their features and their crossings.

use super::DeformedMesh;
use super::point_set::PointSet;
use super::triangle::{PlanarPoint, cross, do_cross};
use crate::geometry::{BoundingBox, Bvh};
use crate::mesh::{NodeId, NodeIncidence};

/// Cosine of the turning angle, 30°, beyond which a node is a corner of the body.
pub(super) const CORNER: f64 = 0.866;
/// Boundary loops of the old mesh as linked lists: the nodes before and after each node with exactly two edges.
pub(super) struct BoundaryLoops<'a> {
    pub old: &'a DeformedMesh<'a, 2>,
    pub edges: Vec<[usize; 2]>,
    pub first_after: Vec<Option<usize>>,
    pub before: Vec<Option<usize>>,
    pub after: Vec<Option<usize>>,
    pub can_go: Vec<bool>,
    /// True if the body has a surface at rest.
    pub rests: bool,
    /// Loads that end at each node.
    ends: Vec<u8>,
    pub members: Vec<usize>,
    near: Bvh<2>,
}

/// Reason why a boundary node must stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BoundaryFeature {
    /// Corner of the body at rest, unless it flows; fork; or last node that is held in a direction or loaded.
    Always,
    /// Corner of the deformed boundary.
    Now,
}

/// Iterates over the boundary nodes that must stay, in their order.
pub(super) fn features(old: &DeformedMesh<'_, 2>) -> impl Iterator<Item = (usize, BoundaryFeature)> {
    let chain = BoundaryLoops::new(old, true);
    let members = chain.members.clone();
    members.into_iter().filter_map(move |node| Some((node, chain.feature(node)?)))
}

/// Iterates over the turning angles of the boundary, rad, at nodes with exactly one edge before and one after.
pub(super) fn turns(old: &DeformedMesh<'_, 2>) -> impl Iterator<Item = (usize, f64)> {
    let chain = BoundaryLoops::new(old, true);
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
    /// Builds the loops of a mesh; `rests` is true for a body with a surface at rest.
    pub fn new(old: &'a DeformedMesh<'a, 2>, rests: bool) -> Self {
        let edges: Vec<[usize; 2]> = old.mesh.facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
        let groups = old.mesh.facets.iter().map(|f| &f[..2]);
        let incidence = NodeIncidence::new(old.position.len(), groups);
        let mut chain = Self {
            old,
            first_after: vec![],
            before: vec![None; old.position.len()],
            after: vec![None; old.position.len()],
            can_go: vec![false; old.position.len()],
            members: (0..old.position.len()).filter(|&n| !incidence.of(NodeId(n as u32)).is_empty()).collect(),
            near: Bvh::new(&[]),
            rests,
            ends: super::load_markers::ends(old.mesh),
            edges,
        };
        let is_simple = |n: usize| incidence.of(NodeId(n as u32)).len() == 2;
        for &[a, b] in &chain.edges {
            chain.after[a] = is_simple(a).then_some(b);
            chain.before[b] = is_simple(b).then_some(a);
        }
        chain.first_after = chain.after.clone();
        chain.near = Bvh::points(chain.members.iter().map(|&n| old.position[n]));
        for &node in &chain.members {
            chain.can_go[node] = chain.feature(node).is_none();
        }
        chain
    }

    /// Reason why a node must stay, if it must.
    pub fn feature(&self, node: usize) -> Option<BoundaryFeature> {
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
        if ends(before) || ends(after) || is_end || self.rests && is_corner(&self.old.mesh.rest) {
            return Some(BoundaryFeature::Always);
        }
        is_corner(self.old.position).then_some(BoundaryFeature::Now)
    }

    /// Returns true if another boundary node lies in the triangle that is cut off or filled.
    pub fn is_inside_another(&self, corners: [usize; 3], cloud: &PointSet) -> bool {
        let [a, b, c] = corners.map(|n| &self.old.position[n]);
        let orientation = cross(a, b, c).signum();
        self.near.any(&BoundingBox::around([a, b, c]), |i| {
            let node = self.members[i];
            let p = &self.old.position[node];
            let is_in = [cross(a, b, p), cross(b, c, p), cross(c, a, p)].iter().all(|s| s * orientation >= 0.0);
            is_in && cloud.chosen[node] && !corners.contains(&node)
        })
    }
}
