//! The boundary of the new mesh: that of the old one, with long edges split and nodes that nobody needs left out.

use super::bounds::Bounds;
use super::box_tree::Near;
use super::point_set::Cloud;
use super::triangle::{Point, cross, distance, do_cross};
use super::untangle::Cuttings;
use super::{Moved, Origin, RemeshError, Rules};
use crate::mesh::{Incidence, NodeId};

/// An edge longer than this many target sizes is split evenly, and one shorter than `SHORT` joined to the next before that. Parts
/// of an edge that was just split are longer than 0.7 sizes: neither undoes the other.
/// With edges of 0.45 sizes and circles of 0.9, angles at the boundary are at least asin(0.45 / 1.8) = 14°.
const LONG: f64 = 1.4;
const SHORT: f64 = 0.45;
/// Cosine of the turn beyond which a node is a corner of the body, 30°.
pub(super) const CORNER: f64 = 0.866;
/// A new point is put clear of a body by less than so many of its sizes.
const NEAR: f64 = 0.2;
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
    pub near: Near<2>,
    /// What the area is less by because loops and needles were cut off and new points put clear of bodies, m².
    pub cleared: f64,
}

/// The place nearest to a point that is in no body.
pub(super) type Cleared<'a> = &'a dyn Fn(&Point) -> Point;

/// The old boundary as chains: the nodes before and after each node that has one of each.
pub(super) struct Chain<'a> {
    pub old: &'a Moved<'a, 2>,
    pub edges: Vec<[usize; 2]>,
    pub first_after: Vec<Option<usize>>,
    pub before: Vec<Option<usize>>,
    pub after: Vec<Option<usize>>,
    pub can_go: Vec<bool>,
    /// Whether there is a surface at rest.
    rests: bool,
    /// Where loaded faces end.
    ends: Vec<u8>,
    pub members: Vec<usize>,
    near: Near<2>,
}

/// Why a node of the boundary must stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Feature {
    /// A corner of the body at rest, unless it flows, a fork, or the last node that is held in a direction or loaded.
    Always,
    /// A corner where the boundary is now.
    Now,
}

/// The nodes of the boundary that must stay, in their order.
pub(super) fn features(old: &Moved<'_, 2>) -> impl Iterator<Item = (usize, Feature)> {
    let chain = Chain::new(old, true);
    let members = chain.members.clone();
    members.into_iter().filter_map(move |node| Some((node, chain.feature(node)?)))
}

/// By how much the boundary turns at each of its nodes that has one before and one after it, rad.
pub(super) fn turns(old: &Moved<'_, 2>) -> impl Iterator<Item = (usize, f64)> {
    let chain = Chain::new(old, true);
    let members = chain.members.clone();
    members.into_iter().filter_map(move |node| {
        let [before, at, after] = [chain.before[node]?, node, chain.after[node]?].map(|n| &chain.old.position[n]);
        let turn = libm::atan2(cross(before, at, after), (at - before).dot(&(after - at)));
        Some((node, turn.abs()))
    })
}

/// Chooses the points of the new boundary; new ones are put where `cleared` says.
///
/// # Errors
/// If two edges of the old boundary cross.
pub(super) fn resample(
    old: &Moved<'_, 2>,
    cloud: &mut Cloud,
    (rules, cleared): (&Rules, Cleared<'_>),
) -> Result<Surface, RemeshError> {
    let mut chain = Chain::new(old, rules.rests);
    chain.members.iter().for_each(|&node| cloud.chosen[node] = true);
    let mut cut = Cuttings::default();
    // A pit that a tip beside it is pushed through looks like a needle; what crosses and cannot be cut off may be at one.
    let _ = chain.unknot(cloud, &mut cut);
    (0..WALKS).any(|_| !chain.blunt(cloud, &mut cut));
    chain.unknot(cloud, &mut cut)?;
    if rules.sag > 0.0 {
        (0..WALKS).any(|_| !chain.leave_out(cloud, rules.sag));
    }
    let mut surface = Surface { edges: vec![], lost: cut.edges, near: Near::new(&[]), cleared: 0.0 };
    for &edge in &chain.edges {
        if cloud.chosen[edge[0]] {
            surface.take(&chain.stretch(edge), cloud);
        }
    }
    surface.clear(cloud, &old.mesh.held, cleared);
    surface.cleared += cut.area;
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
    fn new(old: &'a Moved<'a, 2>, rests: bool) -> Self {
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
        chain.near = Near::points(chain.members.iter().map(|&n| old.position[n]));
        for &node in &chain.members {
            chain.can_go[node] = chain.feature(node).is_none();
        }
        chain
    }

    /// The old nodes from the start of this edge to the next one that stays.
    fn stretch(&self, [start, next]: [usize; 2]) -> Vec<usize> {
        let mut nodes = vec![start, next];
        let mut at = next;
        while let (true, Some(after)) = (self.after[start].is_some_and(|end| end != at), self.first_after[at]) {
            nodes.push(after);
            at = after;
        }
        nodes
    }

    /// Whether and why a node must stay.
    pub fn feature(&self, node: usize) -> Option<Feature> {
        let (Some(before), Some(after)) = (self.before[node], self.after[node]) else { return Some(Feature::Always) };
        let held = &self.old.mesh.held;
        let is_corner = |x: &[Point]| {
            let (u, v) = (x[node] - x[before], x[after] - x[node]);
            u.dot(&v) < CORNER * u.norm() * v.norm()
        };
        let ends = |other: usize| (0..2).any(|i| held[node][i] && !held[other][i]);
        let is_end = self.ends.get(node).is_some_and(|loads| *loads != 0);
        if ends(before) || ends(after) || is_end || self.rests && is_corner(&self.old.mesh.rest) {
            return Some(Feature::Always);
        }
        is_corner(self.old.position).then_some(Feature::Now)
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
            (waits[before], waits[after]) = (true, true);
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
        let size = cloud.size[node];
        let short = distance(&x[before], &x[node]).min(distance(&x[node], &x[after]));
        short < SHORT * size
            && before != after
            && self.after[after] != Some(before)
            && self.after[before].is_some()
            && self.before[after].is_some()
            && self.is_straight([before, after], x, sag * LONG * size)
            && [Some(x), self.rests.then_some(&*self.old.mesh.rest)]
                .iter()
                .flatten()
                .all(|x| self.is_straight([before, after], x, sag * distance(&x[before], &x[after])))
            && !self.is_inside_another([before, node, after], cloud)
    }

    /// Whether all old nodes of a stretch are within so much, m, of its chord.
    fn is_straight(&self, [from, to]: [usize; 2], x: &[Point], sag: f64) -> bool {
        let chord = distance(&x[from], &x[to]);
        let mut node = self.first_after[from];
        while let Some(at) = node.filter(|&at| at != to) {
            if cross(&x[from], &x[to], &x[at]).abs() > sag * chord {
                return false;
            }
            node = self.first_after[at];
        }
        chord > 0.0
    }

    /// Whether another node of the boundary is in the triangle that is cut off or filled.
    pub fn is_inside_another(&self, corners: [usize; 3], cloud: &Cloud) -> bool {
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
    /// Puts the new points where `cleared` says, if that is near: a chord of a wall that lies around a body runs through it.
    fn clear(&mut self, cloud: &mut Cloud, held: &[[bool; 2]], cleared: Cleared<'_>) {
        let area = |edges: &[[usize; 2]], x: &[Point]| -> f64 {
            edges.iter().map(|[a, b]| 0.5 * (x[*a][0] * x[*b][1] - x[*a][1] * x[*b][0])).sum()
        };
        let before = area(&self.edges, &cloud.position);
        for point in held.len()..cloud.position.len() {
            let mut there = cleared(&cloud.position[point]);
            for axis in 0..2 {
                if cloud.stays(point, axis, held) {
                    there[axis] = cloud.position[point][axis];
                }
            }
            if distance(&there, &cloud.position[point]) < NEAR * cloud.size[point] {
                cloud.position[point] = there;
            }
        }
        self.cleared = before - area(&self.edges, &cloud.position);
    }

    /// Takes over a stretch of the old boundary, given by its nodes: as one edge, or split evenly along it.
    fn take(&mut self, stretch: &[usize], cloud: &mut Cloud) {
        let [Some(&first), Some(&last)] = [stretch.first(), stretch.last()] else { return };
        let length = |[a, b]: [usize; 2], cloud: &Cloud| distance(&cloud.position[a], &cloud.position[b]);
        let sizes = [first, last].map(|n| cloud.size[n]);
        let size = 0.5 * (sizes[0] + sizes[1]);
        let edges = || stretch.windows(2).map(|w| [w[0], w[1]]);
        let whole: f64 = edges().map(|edge| length(edge, cloud)).sum();
        let parts = if whole <= LONG * size { 1 } else { (whole / size).round().max(2.0) as usize };
        if stretch.len() > 2 || parts > 1 {
            self.lost.extend(edges());
        }
        let (mut from, mut part, mut walked) = (first, 1, 0.0);
        for [a, b] in edges() {
            let along = length([a, b], cloud);
            while part < parts && walked + along >= whole * part as f64 / parts as f64 && along > 0.0 {
                let at = part as f64 / parts as f64;
                let share = (whole * at - walked) / along;
                let position = (1.0 - share) * cloud.position[a] + share * cloud.position[b];
                let ends = [a, b, b].map(|n| NodeId(n as u32));
                let origin = Origin::Surface(ends, [1.0 - share, share, 0.0]);
                let to = cloud.add(position, (1.0 - at) * sizes[0] + at * sizes[1], origin);
                self.edges.push([from, to]);
                (from, part) = (to, part + 1);
            }
            walked += along;
        }
        self.edges.push([from, last]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_meshes::{moved, rings, square};
    use super::super::{Acceptance, judge, propose};
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn edges_of_straight_sides_end_up_near_their_size() {
        let mesh = square(12);
        let position = moved(&mesh, |x| Point::new(x[0].powi(3), x[1] + 0.4 * x[1] * (1.0 - x[1])));
        let old = Moved { mesh: &mesh, position: &position };
        for size in [0.03, 0.1, 0.2, 0.4] {
            let new = propose(&old, &vec![size; position.len()], &Rules::default(), &|x| *x).unwrap();
            judge(&old, &new, &Acceptance { measure: 1e-12, quality: 0.3 }).unwrap();
            let mesh = Mesh::<2>::new(new.position, new.elements);
            for facet in &mesh.facets {
                let length = distance(&mesh.rest[facet[0].index()], &mesh.rest[facet[1].index()]);
                assert!(length > 0.999 * SHORT * size && length < 1.001 * LONG * size, "{length} for {size}");
            }
        }
    }

    #[test]
    fn no_node_is_left_out_across_another_wall() {
        // A wall with a dent, and close to it another one with a tip, which is held, in the dent.
        let mut mesh = rings(2, 0.25);
        let (dent, tip) = (Point::new(3.0, 1.5), Point::new(4.0, 1.5));
        let mut position = moved(&mesh, |x| if x[0] > 3.5 { x - Point::new(0.995, 0.0) } else { *x });
        for (n, x) in mesh.rest.iter().enumerate() {
            if *x == dent {
                position[n] = Point::new(2.98, 1.5);
            } else if *x == tip {
                position[n] = Point::new(2.99, 1.5);
                mesh.held[n] = [true; 2];
            }
        }
        let sizes = vec![1.2; position.len()];
        let proposed = |position: &[Point]| {
            let old = Moved { mesh: &mesh, position };
            let new = propose(&old, &sizes, &Rules::default(), &|x| *x).unwrap();
            judge(&old, &new, &Acceptance { measure: 0.01, quality: 0.0 }).unwrap();
            new.position.contains(&Point::new(2.98, 1.5))
        };
        assert!(proposed(&position));
        // Without the tip in it the dent is filled.
        let apart: Vec<Point> =
            position.iter().map(|x| if x[0] > 2.985 && x[0] != 3.0 { x + Point::new(0.5, 0.0) } else { *x }).collect();
        assert!(!proposed(&apart));
    }
}
