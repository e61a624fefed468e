//! Untangling of the boundary: self-intersecting loops, piercing tips and needles are cut off.

use super::RemeshError;
use super::boundary_loops::{BoundaryFeature, BoundaryLoops, CORNER, crossing};
use super::point_set::PointSet;
use super::triangle::{cross, do_cross};
use crate::mesh::NodeId;

/// Limits of a loop: number of loops that are cut off, edges of each, and its area in squares of its target size.
const MOST_LOOPS: usize = 64;
const MOST_LOOP_EDGES: usize = 12;
const LARGEST_LOOP: f64 = 1.0;
/// Greatest number of nodes of a piercing tip.
const MOST_TIP_NODES: usize = 4;
/// Width of a needle, in target sizes, measured at the end of its shorter side. A tenth of a size gives a triangle of
/// quality 0.3 on an edge of half a size, which counts as distorted.
const NEEDLE: f64 = 0.1;

/// Parts cut off the old boundary.
#[derive(Debug, Default)]
pub(super) struct BoundaryCuts {
    /// Old edges that were removed.
    pub edges: Vec<[usize; 2]>,
    /// Loss of area, m².
    pub area: f64,
}

impl BoundaryLoops<'_> {
    /// Cuts off small loops of a self-intersecting boundary, as at the tips of a rough wall, and tips that pierce
    /// another wall, as those of a falling splash.
    ///
    /// # Errors
    /// [`RemeshError`] if the boundary crosses itself in a large loop.
    pub fn untangle(&mut self, cloud: &mut PointSet, cut: &mut BoundaryCuts) -> Result<(), RemeshError> {
        for _ in 0..MOST_LOOPS {
            let Some([first, second]) = crossing(&self.edges, self.old.position) else { return Ok(()) };
            // A tip that pierces an edge enters and leaves: the longest loop contains all of it.
            let pairs = std::iter::once([first, second]).chain(self.crossed_beside([first, second]));
            let small_loop = pairs.filter_map(|pair| self.small_loop(pair, cloud)).max_by_key(Vec::len);
            let Some(walk) = small_loop.or_else(|| self.tip([first, second], cloud)) else {
                return Err(RemeshError::Crossing { edges: [first, second].map(|e| e.map(|n| NodeId(n as u32))) });
            };
            self.cut_off(&walk, cloud, cut);
        }
        match crossing(&self.edges, self.old.position) {
            Some(edges) => Err(RemeshError::Crossing { edges: edges.map(|e| e.map(|n| NodeId(n as u32))) }),
            None => Ok(()),
        }
    }

    /// Small loop that begins with one of two crossing edges and ends with the other, if there is one.
    fn small_loop(&self, [first, second]: [[usize; 2]; 2], cloud: &PointSet) -> Option<Vec<usize>> {
        let walks = [[first, second], [second, first]].map(|[from, to]| self.between(from, to));
        walks.into_iter().flatten().filter(|walk| self.is_small(walk, cloud)).min_by_key(Vec::len)
    }

    /// For two crossing edges, the further pairs of each with the crossed neighbours of the other.
    fn crossed_beside(&self, [first, second]: [[usize; 2]; 2]) -> impl Iterator<Item = [[usize; 2]; 2]> {
        let x = |edge: [usize; 2]| edge.map(|n| &self.old.position[n]);
        let beside = |[from, to]: [usize; 2]| {
            let sides = [self.before[from].map(|before| [before, from]), self.after[to].map(|after| [to, after])];
            sides.into_iter().flatten()
        };
        let seconds = beside(second).map(move |other| [first, other]);
        seconds.chain(beside(first).map(move |other| [other, second])).filter(move |[a, b]| do_cross(x(*a), x(*b)))
    }

    fn is_small(&self, walk: &[usize], cloud: &PointSet) -> bool {
        self.area(walk).abs() < LARGEST_LOOP * cloud.size[walk[0]].powi(2)
    }

    /// Smallest tip of gel with one of the two crossing edges whose cut nothing crosses. A gap that pierces a wall is
    /// excluded: closing it would create gel.
    fn tip(&self, crossing: [[usize; 2]; 2], cloud: &PointSet) -> Option<Vec<usize>> {
        let tips = crossing.into_iter().flat_map(|edge| self.tips(edge));
        let free = tips.filter(|tip| self.area(tip) > 0.0 && self.is_small(tip, cloud) && self.is_clear(tip));
        free.map(|tip| (self.area(&tip), tip)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, tip)| tip)
    }

    /// Removable stretches of the boundary around an edge, with at least one end of it in their interior.
    fn tips(&self, edge: [usize; 2]) -> Vec<Vec<usize>> {
        let mut walk = edge.to_vec();
        for _ in 0..MOST_TIP_NODES {
            let (Some(before), Some(after)) = (self.before[walk[0]], walk.last().and_then(|last| self.after[*last]))
            else {
                break;
            };
            walk.insert(0, before);
            walk.push(after);
        }
        let may_go = |node: &usize| self.feature(*node) != Some(BoundaryFeature::Always);
        let is_tip = |tip: &&[usize]| {
            let [start, removed @ .., end] = *tip else { return false };
            edge.iter().any(|node| removed.contains(node))
                && removed.iter().all(may_go)
                && !removed.contains(start)
                && self.after[*end].is_some_and(|next| next != *start && next != removed[0])
                && self.before[*start].is_some()
                && start != end
        };
        let lengths = 3..=MOST_TIP_NODES + 2;
        lengths.flat_map(|n| walk.windows(n).filter(is_tip).map(<[usize]>::to_vec).collect::<Vec<_>>()).collect()
    }

    /// Returns true if no other boundary edge crosses the segment that joins the ends of a stretch.
    fn is_clear(&self, walk: &[usize]) -> bool {
        let [start, removed @ .., end] = walk else { return false };
        let x = |node: usize| &self.old.position[node];
        let stays = |edge: &&[usize; 2]| !edge.iter().any(|node| removed.contains(node));
        !self.edges.iter().filter(stays).any(|[a, b]| do_cross([x(*start), x(*end)], [x(*a), x(*b)]))
    }

    /// Joins the ends of a stretch of the boundary, and removes the nodes between them.
    fn cut_off(&mut self, walk: &[usize], cloud: &mut PointSet, cut: &mut BoundaryCuts) {
        let [start, removed @ .., end] = walk else { return };
        cut.area += self.area(walk);
        cut.edges.extend(walk.windows(2).map(|pair| [pair[0], pair[1]]));
        for node in removed {
            cloud.chosen[*node] = false;
        }
        self.edges.retain(|edge| !removed.contains(&edge[0]));
        self.edges.iter_mut().filter(|edge| **edge == [*start, walk[1]]).for_each(|edge| edge[1] = *end);
        (self.after[*start], self.first_after[*start], self.before[*end]) = (Some(*end), Some(*end), Some(*start));
    }

    /// Signed area of the polygon of these nodes, m².
    fn area(&self, nodes: &[usize]) -> f64 {
        let x = |i: usize| &self.old.position[nodes[i]];
        (2..nodes.len()).map(|i| 0.5 * cross(x(0), x(i - 1), x(i))).sum()
    }

    /// Cuts off needle-shaped tips, no two of them adjacent, and returns true if there were any. Nothing else helps
    /// them: the only element of such a tip has all its nodes on the boundary.
    pub fn cut_needles(&mut self, cloud: &mut PointSet, cut: &mut BoundaryCuts) -> bool {
        let mut waits = vec![false; self.can_go.len()];
        let mut any = false;
        for i in 0..self.members.len() {
            let node = self.members[i];
            let Some((before, after)) = self.needle(node, cloud).filter(|_| !waits[node]) else { continue };
            (waits[before], waits[after]) = (true, true);
            self.cut_off(&[before, node, after], cloud, cut);
            any = true;
        }
        any
    }

    /// Neighbours of a node that is the tip of a needle, or beyond the axis.
    fn needle(&self, node: usize, cloud: &PointSet) -> Option<(usize, usize)> {
        let (before, after) = (self.before[node]?, self.after[node]?);
        let x = self.old.position;
        let (u, v) = (x[before] - x[node], x[after] - x[node]);
        let wide = cross(&x[before], &x[node], &x[after]);
        // A fold of the axis has no width.
        let is_thin = wide >= 0.0 && wide < NEEDLE * cloud.size[node] * u.norm().max(v.norm());
        let is_sharp = u.dot(&v) > CORNER * u.norm() * v.norm();
        let joined = self.before[before].is_some() && self.after[after].is_some_and(|next| next != before);
        let may_go =
            cloud.chosen[node] && (is_thin && is_sharp || self.is_beyond([before, node, after], cloud)) && joined;
        (may_go
            && self.feature(node) != Some(BoundaryFeature::Always)
            && !self.is_inside_another([before, node, after], cloud))
        .then_some((before, after))
    }

    /// Returns true if a node is beyond the axis x = 0 and may be cut off: the body is at x ≥ 0, the boundary comes
    /// from or leads to the axis, and the loss is small.
    fn is_beyond(&self, [before, node, after]: [usize; 3], cloud: &PointSet) -> bool {
        let x = self.old.position;
        let is_axial = |n: usize| self.old.mesh.held[n][0] && x[n][0] == 0.0;
        let is_edge = |one: usize, next: Option<usize>| is_axial(one) && next.is_some_and(is_axial);
        x[node][0] < 0.0
            && (is_edge(before, self.before[before]) || is_edge(after, self.after[after]))
            && self.is_small(&[before, node, after], cloud)
    }

    /// Nodes from the start of an edge to the end of another edge nearby along the boundary, if all nodes between are
    /// removable.
    fn between(&self, [start, next]: [usize; 2], [last, end]: [usize; 2]) -> Option<Vec<usize>> {
        let mut walk = vec![start, next];
        while *walk.last()? != last {
            let at = self.after[*walk.last()?]?;
            (walk.len() < MOST_LOOP_EDGES).then(|| walk.push(at))?;
        }
        let may_go = |node: &usize| self.feature(*node) != Some(BoundaryFeature::Always);
        let simple = self.before[start].is_some() && self.after[end].is_some() && start != end;
        (simple && walk[1..].iter().all(may_go)).then_some(())?;
        walk.push(end);
        Some(walk)
    }
}
