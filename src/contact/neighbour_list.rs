//! Neighbour list with a skin (Verlet 1967): a surface node is queried again only after bodies and nodes have
//! travelled more than its last gap.
//!
//! The distance of a point to a body changes by no more than the travel of both. The list stores the distance at the
//! last query of each node and one travel sum for all nodes. It queries a node only when the travel since could have
//! brought a body near. A skipped node is proved to be out of reach, so no result depends on the list. The same bound
//! skips the facets around a node, and the distortion check of elements whose nodes have not moved far enough.

use super::surface::ContactSurface;
use super::{BodyState, RigidBody, ShapeMotion};
use crate::math::{SUM_BLOCK, Vector3, least};
use crate::mesh::NodeId;

/// Neighbour list of one surface, with the travel bounds of the elements of its mesh.
#[derive(Debug)]
pub(crate) struct NeighbourList {
    /// Distance to the nearest body at the last query of each surface node, plus the travel up to that query, m.
    query_bound: Vec<f64>,
    /// Travel at which a facet around each surface node needs a query, m.
    facet_bound: Vec<f64>,
    /// Candidate nodes: those that may need a query before long.
    candidates: CandidateSet,
    /// Travel of the nodes of its part at which an element of each group can be distorted, m.
    distortion_bound: Vec<f64>,
    /// Travel of nodes and bodies so far, m.
    travel: f64,
    /// Greatest speed of a run of nodes, m/s.
    speeds: Vec<f64>,
    /// Travel of any node so far, m.
    node_travel: f64,
    /// Parts of the mesh, once the distortion monitor needs them.
    parts: Vec<MeshPart>,
    /// Bounding ball of the surface: its centre, and its radius with the travel of the nodes, m.
    bounding_ball: (Vector3, f64),
    /// Time of the last update, s, and the states of the bodies then.
    time: f64,
    bodies: Vec<BodyState>,
}

/// Candidate set of surface nodes, with the bounds within which no other node needs a query.
#[derive(Debug, Default)]
struct CandidateSet {
    /// Surface nodes, ascending.
    nodes: Vec<u32>,
    /// Travel at which another node needs a query, m, as long as no body and node approach each other by more than
    /// `reach`, m, in a step.
    next_travel: f64,
    reach: f64,
    /// Number of candidates that were tested and needed no query.
    n_idle: usize,
}

/// Distance to a body within which the facets around a node are queried, in element sizes; a surface stretched
/// further has long been stopped.
pub(crate) const STRETCH: f64 = 8.0;
/// Nodes of a run, for which the list keeps one bound of their speed: those of a block of sums.
const NODE_RUN: usize = SUM_BLOCK;
/// Skin of the candidate set, in element sizes, and the factor by which the reach may grow before a rebuild.
const SKIN: f64 = 1.0;
const REACH_GROWTH: f64 = 2.0;

/// Part of a mesh with its own travel bound.
#[derive(Debug)]
struct MeshPart {
    /// Runs of nodes of the part.
    runs: Vec<u32>,
    /// Travel bound of the nodes of the part, m.
    node_travel: f64,
    /// Least distortion bound of its groups, m.
    distortion_bound: f64,
}

impl NeighbourList {
    /// Creates the neighbour list of a surface with its nodes at these positions; `speeds` bounds the speed of each
    /// run of nodes. Nothing else is known yet.
    pub fn new(surface: &ContactSurface, time: f64, speeds: Vec<f64>, place: impl Fn(usize) -> Vector3) -> Self {
        let places = || surface.nodes.iter().map(|at| place(at.node.index()));
        let middle = places().sum::<Vector3>() / surface.nodes.len().max(1) as f64;
        let radius = places().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        let query_bound = vec![f64::NEG_INFINITY; surface.nodes.len()];
        Self {
            facet_bound: query_bound.clone(),
            query_bound,
            candidates: CandidateSet::default(),
            distortion_bound: vec![],
            travel: 0.0,
            node_travel: 0.0,
            speeds,
            parts: vec![],
            bounding_ball: (middle, radius),
            time,
            bodies: vec![],
        }
    }

    /// Divides the mesh into parts with travel bounds of their own, with the runs of nodes of each; the distortion
    /// bounds of the groups are not known yet.
    pub fn set_parts(&mut self, parts: Vec<Vec<u32>>, n_groups: usize) {
        self.parts = parts
            .into_iter()
            .map(|runs| MeshPart { runs, node_travel: 0.0, distortion_bound: f64::NEG_INFINITY })
            .collect();
        self.distortion_bound = vec![f64::NEG_INFINITY; n_groups];
    }

    /// Removes the parts of the mesh and their travel bounds.
    pub fn clear_parts(&mut self) {
        self.set_parts(vec![], 0);
    }

    /// Advances the travel sums to a time and to the states of the bodies at that time.
    pub fn go_on(&mut self, time: f64, bodies: &[BodyState]) {
        let passed = (time - self.time).max(0.0);
        let node_travel = self.speed() * passed;
        self.node_travel += node_travel;
        for part in &mut self.parts {
            part.node_travel += greatest_speed(&part.runs, &self.speeds) * passed;
        }
        let are_known = self.bodies.len() == bodies.len()
            && self.bodies.iter().zip(bodies).all(|(was, now)| was.active || !now.active);
        if !are_known {
            self.query_bound.fill(f64::NEG_INFINITY);
            self.facet_bound.fill(f64::NEG_INFINITY);
            self.candidates = CandidateSet::default();
        }
        self.bounding_ball.1 += node_travel;
        let body_travel =
            self.bodies.iter().zip(bodies).map(|(was, now)| self.displacement(was, now)).fold(0.0, f64::max);
        self.travel += node_travel + body_travel;
        self.time = time;
        self.bodies.clear();
        self.bodies.extend_from_slice(bodies);
    }

    /// Returns a bound of the travel of any node so far, m.
    pub fn node_travel(&self) -> f64 {
        self.node_travel
    }

    /// Returns the greatest speed of a node, m/s.
    pub fn speed(&self) -> f64 {
        self.speeds.iter().copied().fold(0.0, f64::max)
    }

    /// Raises the speed bound of the run of a node to the speed of the node, m/s.
    pub fn note_speed(&mut self, node: usize, speed: f64) {
        let run = &mut self.speeds[node / NODE_RUN];
        *run = run.max(speed);
    }

    /// Sets or raises the speed bound of each run, m/s: sets it if the speeds are those of all nodes.
    pub fn note_speeds(&mut self, of_all: bool, speeds: impl Iterator<Item = f64>) {
        for (run, speed) in self.speeds.iter_mut().zip(speeds) {
            *run = speed.max(if of_all { 0.0 } else { *run });
        }
    }

    /// Returns the number of parts of the mesh.
    pub fn n_parts(&self) -> usize {
        self.parts.len()
    }

    /// Returns the travel bound of the nodes of a part up to a time that is not before the last update, m.
    pub fn part_travel(&self, part: usize, time: f64) -> f64 {
        let MeshPart { runs, node_travel, .. } = &self.parts[part];
        node_travel + greatest_speed(runs, &self.speeds) * (time - self.time).max(0.0)
    }

    /// Returns true if an element of a part whose nodes have travelled this far, m, may be distorted.
    pub fn may_part_be_distorted(&self, part: usize, travel: f64) -> bool {
        may_exceed(self.parts[part].distortion_bound, travel)
    }

    /// Returns true if an element of a group whose nodes have travelled this far, m, may be distorted.
    pub fn may_group_be_distorted(&self, group: usize, travel: f64) -> bool {
        may_exceed(self.distortion_bound[group], travel)
    }

    /// Sets the travel of its nodes at which an element of a group can be distorted, m.
    pub fn set_group_bound(&mut self, group: usize, travel: f64) {
        self.distortion_bound[group] = travel;
    }

    /// Sets the distortion bound of a part to the least bound of its groups.
    pub fn set_part_bound(&mut self, part: usize, groups: std::ops::Range<usize>) {
        self.parts[part].distortion_bound = self.distortion_bound[groups].iter().copied().fold(f64::INFINITY, least);
    }

    /// Returns the greatest travel of a point of a body near the surface, m: |R − R′| ≤ 2 |q − q′| for rotations.
    fn displacement(&self, was: &BodyState, now: &BodyState) -> f64 {
        let rotation = 2.0 * (now.orientation.quaternion() - was.orientation.quaternion()).norm();
        let growth = match (&was.shape_motion, &now.shape_motion) {
            (Some(was), Some(now)) => was.greatest_distance(now),
            _ => 0.0,
        };
        (now.position - was.position).norm()
            + rotation * self.greatest_distance(was).max(self.greatest_distance(now))
            + growth
    }

    /// Returns an upper bound of the distance from the centre of a body to any surface node, m.
    fn greatest_distance(&self, body: &BodyState) -> f64 {
        (body.position - self.bounding_ball.0).norm() + self.bounding_ball.1
    }

    /// Returns how far a body and a node can approach each other in a time, m, by the same bounds as the path limit
    /// of a node.
    pub fn reach(&self, bodies: &[RigidBody], horizon: f64) -> f64 {
        let approach = |(body, at): (&RigidBody, &BodyState)| {
            let (growth_speed, growth_acceleration) =
                at.shape_motion.map_or((0.0, 0.0), |shape| (shape.max_speed(), shape.max_acceleration()));
            let acceleration = at.wrench.force.norm() / body.mass + growth_acceleration;
            at.velocity.norm()
                + body.angular_velocity(at).norm() * self.greatest_distance(at)
                + growth_speed
                + acceleration * horizon
        };
        let active = bodies.iter().zip(&self.bodies).filter(|(_, at)| at.active);
        (active.map(approach).fold(0.0, f64::max) + self.speed()) * horizon
    }

    /// Returns the travel, m, at which a node of this size needs a query: a body may reach it within a step, or a
    /// facet around it may be deep. `reach` is the greatest approach of body and node in a step.
    #[inline]
    fn query_travel(&self, node: u32, size: f64, reach: f64) -> f64 {
        let (query, facet) = (self.query_bound[node as usize], self.facet_bound[node as usize]);
        least(query - size.max(reach), (query - STRETCH * size).max(facet))
    }

    /// Returns true if a node needs a query now.
    #[inline]
    pub fn needs_query(&self, node: u32, size: f64, reach: f64) -> bool {
        may_exceed(self.query_travel(node, size, reach), self.travel)
    }

    /// Appends the active surface nodes that need a query, in ascending order.
    pub fn append_queries(
        &mut self,
        surface: &ContactSurface,
        reach: f64,
        is_active: impl Fn(NodeId) -> bool,
        queries: &mut Vec<u32>,
    ) {
        let candidates = &self.candidates;
        let is_valid = !may_exceed(candidates.next_travel, self.travel)
            && reach <= candidates.reach
            && candidates.n_idle <= surface.nodes.len();
        if !is_valid {
            self.rebuild(surface, REACH_GROWTH * reach);
        }
        let before = queries.len();
        queries.extend(self.candidates.nodes.iter().copied().filter(|node| {
            let at = &surface.nodes[*node as usize];
            self.needs_query(*node, at.size, reach) && is_active(at.node)
        }));
        self.candidates.n_idle += self.candidates.nodes.len() - (queries.len() - before);
    }

    /// Rebuilds the candidate set. Only candidates are queried, so the bounds of all other nodes hold until the next
    /// rebuild.
    fn rebuild(&mut self, surface: &ContactSurface, reach: f64) {
        let (mut nodes, mut next_travel) = (std::mem::take(&mut self.candidates.nodes), f64::INFINITY);
        nodes.clear();
        for (node, at) in (0..).zip(&surface.nodes) {
            let query_travel = self.query_travel(node, at.size, reach);
            if may_exceed(query_travel, self.travel + SKIN * at.size) {
                nodes.push(node);
            } else {
                next_travel = next_travel.min(query_travel);
            }
        }
        self.candidates = CandidateSet { nodes, next_travel, reach, n_idle: 0 };
    }

    /// Sets the distance of a node to the nearest body, m.
    #[inline]
    pub fn set_gap(&mut self, node: u32, distance: f64) {
        self.query_bound[node as usize] = self.travel + distance;
    }

    /// Returns true if a facet around a node may be deep in a body.
    #[inline]
    pub fn needs_facet_query(&self, node: u32) -> bool {
        may_exceed(self.facet_bound[node as usize], self.travel)
    }

    /// Sets how far anything may travel before a facet around a node needs a query, m.
    #[inline]
    pub fn set_facet_bound(&mut self, node: u32, room: f64) {
        self.facet_bound[node as usize] = self.travel + room;
    }

    /// Returns the time of the last update, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns how long no body comes within a distance, by node, of a surface that stands still, s after the last
    /// update.
    pub fn quiet_time(&self, bodies: &[RigidBody], within: impl Fn(usize) -> f64) -> f64 {
        /// Halvings of one second; a shorter time is not worth skipping.
        const HALVINGS: i32 = 40;
        let room = |(i, bound): (usize, &f64)| bound - self.travel - within(i);
        let margin = self.query_bound.iter().enumerate().map(room).fold(f64::INFINITY, f64::min);
        let greatest_travel = |h: f64| {
            let travel = |(body, at): (&RigidBody, &BodyState)| self.body_travel(body, at, h);
            let active = bodies.iter().zip(&self.bodies).filter(|(_, at)| at.active);
            active.map(travel).fold(0.0, f64::max)
        };
        let lengths = (0..HALVINGS).map(|n| 0.5_f64.powi(n));
        lengths.into_iter().find(|h| greatest_travel(*h) < margin).unwrap_or(0.0)
    }

    /// Returns how far a point of a body can travel in a time, m.
    fn body_travel(&self, body: &RigidBody, at: &BodyState, h: f64) -> f64 {
        let wrench = &at.wrench;
        let acceleration = (wrench.force.norm() + wrench.force_rate.norm() * h) / body.mass;
        let angular_momentum_bound =
            at.angular_momentum.norm() + (wrench.torque.norm() + wrench.torque_rate.norm() * h) * h;
        let growth = |shape: ShapeMotion| shape.max_speed() * h + 0.5 * shape.max_acceleration() * h * h;
        let translation = at.velocity.norm() * h + 0.5 * acceleration * h * h;
        translation
            + body.greatest_inverse_inertia() * angular_momentum_bound * h * (self.greatest_distance(at) + translation)
            + at.shape_motion.map_or(0.0, growth)
    }
}

/// Returns true if a travel, m, may have exceeded a bound; a bound that is not a number never hides a node.
fn may_exceed(bound: f64, travel: f64) -> bool {
    let is_below = bound > travel;
    !is_below
}

/// Returns the greatest speed bound of these runs, m/s.
fn greatest_speed(runs: &[u32], speeds: &[f64]) -> f64 {
    runs.iter().map(|run| speeds[*run as usize]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::test_surface::{self, any};
    use super::*;
    use crate::math::Vector3;

    #[test]
    fn no_node_that_needs_a_query_is_missed() {
        let mesh = test_surface::mesh(&[0.0, 0.1, 0.2, 0.5, 1.0]);
        let mut surface = test_surface::surface(&mesh);
        surface.nodes.iter_mut().zip(0..).for_each(|(at, i)| at.size = 0.02 + 0.01 * any(i));
        let n = surface.nodes.len();
        let place = |node: u32| mesh.rest[surface.nodes[node as usize].node.index()];
        let mut at = BodyState::at_start(Vector3::new(1.06, 0.5, 0.5), Vector3::zeros());
        let mut watch = NeighbourList::new(&surface, 0.0, vec![0.0], |node| mesh.rest[node]);
        let is_active = |i: usize| move |node: NodeId| any(i + 3 * node.index()) > -0.5;
        let (mut n_rebuilt, mut some) = (0, 0);
        for i in 1..=1000 {
            // To and fro in front of a face, and at last into it.
            at.position.x = if i < 800 { 1.06 + 0.002 * any(i) } else { at.position.x - 0.003 };
            watch.go_on(i as f64, &[at]);
            let reach = if i % 100 < 50 { 0.01 } else { 0.08 };
            let must = |node: &u32| {
                let of = &surface.nodes[*node as usize];
                watch.needs_query(*node, of.size, reach) && is_active(i)(of.node)
            };
            let all: Vec<u32> = (0..n as u32).filter(must).collect();
            let (mut seen, until) = (vec![], watch.candidates.next_travel);
            watch.append_queries(&surface, reach, is_active(i), &mut seen);
            assert_eq!(seen, all, "at {i}");
            n_rebuilt += usize::from(watch.candidates.next_travel != until);
            some += usize::from(!seen.is_empty() && watch.candidates.nodes.len() < n);
            for node in seen {
                watch.set_gap(node, (place(node) - at.position).norm());
                watch.set_facet_bound(node, 0.1 * any(i + node as usize));
            }
        }
        assert!((3..500).contains(&n_rebuilt) && some > 100, "rebuilt {n_rebuilt} times, some were seen {some} times");
        watch.set_facet_bound(3, f64::INFINITY);
        watch.set_gap(3, f64::INFINITY);
        let is_candidate = |watch: &mut NeighbourList| {
            watch.candidates = CandidateSet::default();
            watch.append_queries(&surface, 0.0, |_| true, &mut vec![]);
            watch.candidates.nodes.contains(&3)
        };
        assert!(!is_candidate(&mut watch));
        watch.set_gap(3, f64::NAN);
        assert!(is_candidate(&mut watch), "what is no number hides nothing");
    }

    #[test]
    fn a_body_that_becomes_active_invalidates_all_bounds() {
        let mesh = test_surface::mesh(&[0.0, 1.0]);
        let surface = test_surface::surface(&mesh);
        let mut watch = NeighbourList::new(&surface, 0.0, vec![0.0], |node| mesh.rest[node]);
        let on = BodyState::at_start(Vector3::new(4.0, 0.5, 0.5), Vector3::zeros());
        let off = BodyState { active: false, ..on };
        let mut seen = |time: f64, at: BodyState| {
            let mut seen = vec![];
            watch.go_on(time, &[at]);
            watch.append_queries(&surface, 0.1, |_| true, &mut seen);
            for node in &seen {
                watch.set_gap(*node, f64::INFINITY);
            }
            seen.len()
        };
        let n = surface.nodes.len();
        assert_eq!([seen(0.0, off), seen(1.0, off), seen(2.0, on)], [n, 0, n]);
    }
}
