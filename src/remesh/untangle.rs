//! What is cut off a boundary: loops in which it crosses itself, tips that are pushed through another wall, and needles.

use super::RemeshError;
use super::boundary_loops::{CORNER, Chain, Feature, crossing};
use super::point_set::Cloud;
use super::triangle::{cross, do_cross};
use crate::mesh::NodeId;

/// Loops that are cut off at most, edges of each, and its area in squares of its target size.
const KNOTS: usize = 64;
const LOOP: usize = 12;
const LARGEST_LOOP: f64 = 1.0;
/// Nodes of a tip that is pushed through another wall at most.
const TIP: usize = 4;
/// A tip is a needle if it is so many target sizes wide, measured where its shorter side ends. A tenth of a size is a triangle of
/// quality 0.3 on an edge of half a size: what wears a mesh.
const NEEDLE: f64 = 0.1;

/// What was cut off the old boundary.
#[derive(Debug, Default)]
pub(super) struct Cuttings {
    /// Old edges that are gone.
    pub edges: Vec<[usize; 2]>,
    /// What the area is less by, m².
    pub area: f64,
}

impl Chain<'_> {
    /// Cuts off small loops in which the boundary crosses itself, as the tips of a rough wall do, and tips that are pushed through
    /// another wall, as those of a splash that comes down.
    ///
    /// # Errors
    /// If it crosses itself in a large one.
    pub fn unknot(&mut self, cloud: &mut Cloud, cut: &mut Cuttings) -> Result<(), RemeshError> {
        for _ in 0..KNOTS {
            let Some([first, second]) = crossing(&self.edges, self.old.position) else { return Ok(()) };
            // A tip that is pushed through an edge goes in and comes out: all of it is in the longest loop.
            let pairs = std::iter::once([first, second]).chain(self.crossed_beside([first, second]));
            let knot = pairs.filter_map(|pair| self.knot(pair, cloud)).max_by_key(Vec::len);
            let Some(walk) = knot.or_else(|| self.tip([first, second], cloud)) else {
                return Err(RemeshError::Crossing { edges: [first, second].map(|e| e.map(|n| NodeId(n as u32))) });
            };
            self.cut_off(&walk, cloud, cut);
        }
        match crossing(&self.edges, self.old.position) {
            Some(edges) => Err(RemeshError::Crossing { edges: edges.map(|e| e.map(|n| NodeId(n as u32))) }),
            None => Ok(()),
        }
    }

    /// The loop that begins with one of two edges that cross and ends with the other one, if there is a small one.
    fn knot(&self, [first, second]: [[usize; 2]; 2], cloud: &Cloud) -> Option<Vec<usize>> {
        let walks = [[first, second], [second, first]].map(|[from, to]| self.between(from, to));
        walks.into_iter().flatten().filter(|walk| self.is_small(walk, cloud)).min_by_key(Vec::len)
    }

    /// Of two edges that cross, each with the edges beside the other one that it crosses, too.
    fn crossed_beside(&self, [first, second]: [[usize; 2]; 2]) -> impl Iterator<Item = [[usize; 2]; 2]> {
        let x = |edge: [usize; 2]| edge.map(|n| &self.old.position[n]);
        let beside = |[from, to]: [usize; 2]| {
            let sides = [self.before[from].map(|before| [before, from]), self.after[to].map(|after| [to, after])];
            sides.into_iter().flatten()
        };
        let seconds = beside(second).map(move |other| [first, other]);
        seconds.chain(beside(first).map(move |other| [other, second])).filter(move |[a, b]| do_cross(x(*a), x(*b)))
    }

    fn is_small(&self, walk: &[usize], cloud: &Cloud) -> bool {
        self.area(walk).abs() < LARGEST_LOOP * cloud.size[walk[0]].powi(2)
    }

    /// Of the tips of gel that one of two crossing edges belongs to, the smallest that can be cut off so that nothing crosses the cut. A gap
    /// that is pushed through a wall is none: what closed it would be made of nothing.
    fn tip(&self, crossing: [[usize; 2]; 2], cloud: &Cloud) -> Option<Vec<usize>> {
        let tips = crossing.into_iter().flat_map(|edge| self.tips(edge));
        let free = tips.filter(|tip| self.area(tip) > 0.0 && self.is_small(tip, cloud) && self.is_clear(tip));
        free.map(|tip| (self.area(&tip), tip)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, tip)| tip)
    }

    /// The walks along the boundary around an edge, at least one end of which is between their ends, and all that is may go.
    fn tips(&self, edge: [usize; 2]) -> Vec<Vec<usize>> {
        let mut walk = edge.to_vec();
        for _ in 0..TIP {
            let (Some(before), Some(after)) = (self.before[walk[0]], walk.last().and_then(|last| self.after[*last]))
            else {
                break;
            };
            walk.insert(0, before);
            walk.push(after);
        }
        let may_go = |node: &usize| self.feature(*node) != Some(Feature::Always);
        let is_tip = |tip: &&[usize]| {
            let [start, removed @ .., end] = *tip else { return false };
            edge.iter().any(|node| removed.contains(node))
                && removed.iter().all(may_go)
                && !removed.contains(start)
                && self.after[*end].is_some_and(|next| next != *start && next != removed[0])
                && self.before[*start].is_some()
                && start != end
        };
        let lengths = 3..=TIP + 2;
        lengths.flat_map(|n| walk.windows(n).filter(is_tip).map(<[usize]>::to_vec).collect::<Vec<_>>()).collect()
    }

    /// Whether no other edge of the boundary crosses the line that joins the ends of a walk.
    fn is_clear(&self, walk: &[usize]) -> bool {
        let [start, removed @ .., end] = walk else { return false };
        let x = |node: usize| &self.old.position[node];
        let stays = |edge: &&[usize; 2]| !edge.iter().any(|node| removed.contains(node));
        !self.edges.iter().filter(stays).any(|[a, b]| do_cross([x(*start), x(*end)], [x(*a), x(*b)]))
    }

    /// Joins the ends of a walk along the boundary, and leaves out what is between them.
    fn cut_off(&mut self, walk: &[usize], cloud: &mut Cloud, cut: &mut Cuttings) {
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

    /// Cuts off tips that have become needles, no two beside each other; whether there were any. Nothing else can be done about them:
    /// the one element of such a tip has all its nodes on the boundary.
    pub fn blunt(&mut self, cloud: &mut Cloud, cut: &mut Cuttings) -> bool {
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

    /// The nodes before and after a node that is the tip of a needle, or is beyond the axis.
    fn needle(&self, node: usize, cloud: &Cloud) -> Option<(usize, usize)> {
        let (before, after) = (self.before[node]?, self.after[node]?);
        let x = self.old.position;
        let (u, v) = (x[before] - x[node], x[after] - x[node]);
        let wide = cross(&x[before], &x[node], &x[after]);
        // A fold of the axis has no width at all.
        let is_thin = wide >= 0.0 && wide < NEEDLE * cloud.size[node] * u.norm().max(v.norm());
        let is_sharp = u.dot(&v) > CORNER * u.norm() * v.norm();
        let joined = self.before[before].is_some() && self.after[after].is_some_and(|next| next != before);
        let may_go =
            cloud.chosen[node] && (is_thin && is_sharp || self.is_beyond([before, node, after], cloud)) && joined;
        (may_go && self.feature(node) != Some(Feature::Always) && !self.is_inside_another([before, node, after], cloud))
            .then_some((before, after))
    }

    /// Whether a node is beyond the axis x = 0, where the body is at x ≥ 0, that the boundary comes from or leads to, and little would go
    /// with it.
    fn is_beyond(&self, [before, node, after]: [usize; 3], cloud: &Cloud) -> bool {
        let x = self.old.position;
        let is_axial = |n: usize| self.old.mesh.held[n][0] && x[n][0] == 0.0;
        let is_edge = |one: usize, next: Option<usize>| is_axial(one) && next.is_some_and(is_axial);
        x[node][0] < 0.0
            && (is_edge(before, self.before[before]) || is_edge(after, self.after[after]))
            && self.is_small(&[before, node, after], cloud)
    }

    /// The nodes from the start of an edge to the end of another one that is not far along the boundary, if all between may go.
    fn between(&self, [start, next]: [usize; 2], [last, end]: [usize; 2]) -> Option<Vec<usize>> {
        let mut walk = vec![start, next];
        while *walk.last()? != last {
            let at = self.after[*walk.last()?]?;
            (walk.len() < LOOP).then(|| walk.push(at))?;
        }
        let may_go = |node: &usize| self.feature(*node) != Some(Feature::Always);
        let simple = self.before[start].is_some() && self.after[end].is_some() && start != end;
        (simple && walk[1..].iter().all(may_go)).then_some(())?;
        walk.push(end);
        Some(walk)
    }
}
