//! The boundary of the new mesh: that of the old one, with long edges split and nodes that nobody needs left out.

use super::cloud::Cloud;
use super::near::{Bounds, Near};
use super::shape::{Point, cross, distance, do_cross};
use super::{Moved, Origin, RemeshError, Rules};
use crate::mesh::{Incidence, NodeId};

/// An edge longer than this many target sizes is split, and one shorter than `SHORT` can go. Halves of an edge that was just
/// split are longer than `SHORT`, two short edges that were joined are shorter than `LONG`: neither undoes the other.
const LONG: f64 = 1.4;
const SHORT: f64 = 0.45;
/// Cosine of the turn beyond which a node is a corner of the body, 30°.
const CORNER: f64 = 0.866;
/// Walks along the boundary that leave out nodes: each can halve the number of edges.
const WALKS: usize = 12;

/// The boundary of the new mesh.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// Its edges, the body on their left.
    pub edges: Vec<[usize; 2]>,
    /// Edges of the old boundary that are not edges of the new one.
    pub lost: Vec<[usize; 2]>,
    /// The new edges by place.
    pub near: Near,
}

/// The old boundary as chains: the nodes before and after each node that has one of each.
struct Chain<'a> {
    old: &'a Moved<'a, 2>,
    edges: Vec<[usize; 2]>,
    first_after: Vec<Option<usize>>,
    before: Vec<Option<usize>>,
    after: Vec<Option<usize>>,
    can_go: Vec<bool>,
    members: Vec<usize>,
    near: Near,
}

/// Chooses the points of the new boundary.
///
/// # Errors
/// If two edges of the old boundary cross.
pub(super) fn resample(old: &Moved<'_, 2>, cloud: &mut Cloud, rules: &Rules) -> Result<Surface, RemeshError> {
    let mut chain = Chain::new(old);
    if let Some(edges) = crossing(&chain.edges, old.position) {
        return Err(RemeshError::Crossing { edges: edges.map(|e| e.map(|n| NodeId(n as u32))) });
    }
    chain.members.iter().for_each(|&node| cloud.chosen[node] = true);
    if rules.sag > 0.0 {
        (0..WALKS).any(|_| !chain.leave_out(cloud, rules.sag));
    }
    let mut surface = Surface { edges: vec![], lost: vec![], near: Near::new(&[]) };
    for &edge in &chain.edges {
        surface.take(&chain, cloud, edge);
    }
    surface.near = Near::segments(&surface.edges, &cloud.position);
    Ok(surface)
}

/// Two segments that cross, if there are any.
pub(super) fn crossing(edges: &[[usize; 2]], x: &[Point]) -> Option<[[usize; 2]; 2]> {
    let near = Near::segments(edges, x);
    edges.iter().enumerate().find_map(|(i, edge)| {
        let ends = edge.map(|n| &x[n]);
        let mut other = None;
        near.any(&Bounds::around(ends), |j| {
            let crosses = j > i && do_cross(ends, edges[j].map(|n| &x[n]));
            other = crosses.then_some(edges[j]);
            crosses
        });
        other.map(|other| [*edge, other])
    })
}

impl<'a> Chain<'a> {
    fn new(old: &'a Moved<'a, 2>) -> Self {
        let edges: Vec<[usize; 2]> = old.mesh.facets.iter().map(|f| [f[0].index(), f[1].index()]).collect();
        let groups = old.mesh.facets.iter().map(|f| &f[..2]);
        let incidence = Incidence::new(old.position.len(), groups);
        let mut chain = Self {
            old,
            first_after: vec![],
            before: vec![None; old.position.len()],
            after: vec![None; old.position.len()],
            can_go: vec![false; old.position.len()],
            members: (0..old.position.len()).filter(|&n| !incidence.of(NodeId(n as u32)).is_empty()).collect(),
            near: Near::new(&[]),
            edges,
        };
        let is_simple = |n: usize| incidence.of(NodeId(n as u32)).len() == 2;
        for &[a, b] in &chain.edges {
            chain.after[a] = is_simple(a).then_some(b);
            chain.before[b] = is_simple(b).then_some(a);
        }
        chain.first_after = chain.after.clone();
        chain.near = Near::points(chain.members.iter().map(|&n| old.position[n]));
        for &node in &chain.members {
            chain.can_go[node] = !chain.is_feature(node);
        }
        chain
    }

    /// Whether a node must stay: a corner now or at rest, a fork, or where the directions that are held change.
    fn is_feature(&self, node: usize) -> bool {
        let (Some(before), Some(after)) = (self.before[node], self.after[node]) else { return true };
        let held = &self.old.mesh.held;
        let is_corner = |x: &[Point]| {
            let (u, v) = (x[node] - x[before], x[after] - x[node]);
            u.dot(&v) < CORNER * u.norm() * v.norm()
        };
        held[before] != held[node]
            || held[after] != held[node]
            || is_corner(self.old.position)
            || is_corner(&self.old.mesh.rest)
    }

    /// Leaves out nodes, no two beside each other; whether there were any.
    fn leave_out(&mut self, cloud: &mut Cloud, sag: f64) -> bool {
        let mut waits = vec![false; self.can_go.len()];
        let mut any = false;
        for i in 0..self.members.len() {
            let node = self.members[i];
            if waits[node] || !cloud.chosen[node] || !self.can_go[node] || !self.is_needless(node, cloud, sag) {
                continue;
            }
            let (Some(before), Some(after)) = (self.before[node], self.after[node]) else { continue };
            [before, after].iter().for_each(|&n| waits[n] = true);
            cloud.chosen[node] = false;
            self.after[before] = Some(after);
            self.before[after] = Some(before);
            any = true;
        }
        any
    }

    /// Whether the boundary is nearly the same without this node, and it is not needed for its size.
    fn is_needless(&self, node: usize, cloud: &Cloud, sag: f64) -> bool {
        let (Some(before), Some(after)) = (self.before[node], self.after[node]) else { return false };
        let x = self.old.position;
        let short = SHORT * cloud.size[node];
        distance(&x[before], &x[node]) < short
            && distance(&x[node], &x[after]) < short
            && before != after
            && self.after[after] != Some(before)
            && self.after[before].is_some()
            && self.before[after].is_some()
            && [x, &self.old.mesh.rest].iter().all(|x| self.is_straight([before, after], x, sag))
            && !self.is_inside_another([before, node, after], cloud)
    }

    /// Whether all old nodes of a stretch are within `sag` chords of its chord.
    fn is_straight(&self, [from, to]: [usize; 2], x: &[Point], sag: f64) -> bool {
        let chord = distance(&x[from], &x[to]);
        let mut node = self.first_after[from];
        while let Some(at) = node.filter(|&at| at != to) {
            if cross(&x[from], &x[to], &x[at]).abs() > sag * chord * chord {
                return false;
            }
            node = self.first_after[at];
        }
        chord > 0.0
    }

    /// Whether another node of the boundary is in the triangle that is cut off or filled.
    fn is_inside_another(&self, corners: [usize; 3], cloud: &Cloud) -> bool {
        let [a, b, c] = corners.map(|n| &self.old.position[n]);
        let orientation = cross(a, b, c).signum();
        self.near.any(&Bounds::around([a, b, c]), |i| {
            let node = self.members[i];
            let p = &self.old.position[node];
            let is_in = [cross(a, b, p), cross(b, c, p), cross(c, a, p)].iter().all(|s| s * orientation >= 0.0);
            is_in && cloud.chosen[node] && !corners.contains(&node)
        })
    }
}

impl Surface {
    /// Takes over an edge of the old boundary: as it is, joined to those after it, or split evenly.
    fn take(&mut self, chain: &Chain<'_>, cloud: &mut Cloud, [a, b]: [usize; 2]) {
        if !cloud.chosen[a] || !cloud.chosen[b] {
            self.lost.push([a, b]);
            self.edges.extend(chain.after[a].filter(|_| cloud.chosen[a]).map(|next| [a, next]));
            return;
        }
        let size = 0.5 * (cloud.size[a] + cloud.size[b]);
        let length = distance(&cloud.position[a], &cloud.position[b]);
        if length <= LONG * size {
            self.edges.push([a, b]);
            return;
        }
        self.lost.push([a, b]);
        let parts = (length / size).round().max(2.0) as usize;
        let mut from = a;
        for part in 1..parts {
            let share = part as f64 / parts as f64;
            let position = (1.0 - share) * cloud.position[a] + share * cloud.position[b];
            let between = (1.0 - share) * cloud.size[a] + share * cloud.size[b];
            let origin = Origin::Edge(NodeId(a as u32), NodeId(b as u32), share);
            let to = cloud.add(position, between, origin);
            self.edges.push([from, to]);
            from = to;
        }
        self.edges.push([from, b]);
    }
}
