//! Gap clocks: which nodes of the surface need not be looked at, because nothing can have come near them.
//!
//! The distance of a point to a body changes by no more than point and body move. When a node was looked at, its distance was
//! known; all that anything has travelled since is added up once for all nodes, and a node is looked at again only when that
//! could have brought a body near. What is not looked at is proved to be out of reach, so no result depends on the clocks.
//! So it is with the facets around a node, and with the shapes of elements: none wears out before its nodes have gone some way.

use super::gel::Surface;
use super::node_loop::RUN;
use crate::contact::{Body, BodyState};
use crate::math::Vector3;
use crate::mesh::NodeId;

/// The gap clocks of one surface, and of the elements of its mesh.
#[derive(Debug)]
pub(super) struct Watch {
    /// Distance to the nearest body when a node was looked at last, and what had been travelled then, m.
    until: Vec<f64>,
    /// What will have been travelled before a facet around a node need be looked at, m.
    clear: Vec<f64>,
    /// The nodes that may have to be looked at before long.
    sieve: Sieve,
    /// What the nodes of its part will have wandered before an element of a group can be worn, m.
    sound: Vec<f64>,
    /// What anything has travelled, m.
    travelled: f64,
    /// Greatest speed of a run of nodes, m/s.
    speeds: Vec<f64>,
    /// Parts of the mesh, once it is asked whether it is worn.
    parts: Vec<Part>,
    /// A ball around the surface: where, and its radius with all that nodes have travelled, m.
    ball: (Vector3, f64),
    /// When that was known, s, and where the bodies were.
    time: f64,
    bodies: Vec<BodyState>,
}

/// Nodes of the surface, and for how long no other need be looked at.
#[derive(Debug, Default)]
struct Sieve {
    /// Ascending.
    nodes: Vec<u32>,
    /// What will have been travelled before another one must be looked at, m, as long as no body and node come towards each other by more
    /// than `reach`, m, in a step.
    until: f64,
    reach: f64,
    /// How often one of them was asked and not looked at.
    idle: usize,
}

/// Facets are looked at around nodes so near to a body, in element sizes: a surface that is stretched further has long been
/// stopped.
pub(super) const STRETCH: f64 = 8.0;
/// How far ahead nodes are taken into the sieve, in element sizes, and how much more may be reached in a step before it is filled anew.
const AHEAD: f64 = 1.0;
const FASTER: f64 = 2.0;

/// A part of a mesh whose nodes wander by themselves.
#[derive(Debug)]
struct Part {
    /// In which runs its nodes are.
    runs: Vec<u32>,
    /// What any of them has wandered at most, m.
    wandered: f64,
    /// The least `sound` of its groups, m.
    sound: f64,
}

impl Watch {
    /// Of a surface with its nodes at these places at a time, no run of nodes of the mesh faster than that, nothing else known yet.
    pub fn new(surface: &Surface, (time, speeds): (f64, Vec<f64>), place: impl Fn(usize) -> Vector3) -> Self {
        let places = || surface.nodes.iter().map(|at| place(at.node.index()));
        let middle = places().sum::<Vector3>() / surface.nodes.len().max(1) as f64;
        let radius = places().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        let until = vec![f64::NEG_INFINITY; surface.nodes.len()];
        let (clear, sieve, sound, parts, bodies) = (until.clone(), Sieve::default(), vec![], vec![], vec![]);
        Self { until, clear, sieve, sound, travelled: 0.0, speeds, parts, ball: (middle, radius), time, bodies }
    }

    /// Has parts of a mesh of so many groups, with their nodes in these runs, wander by themselves from now on; how sound groups are is
    /// not known yet.
    pub fn divide(&mut self, parts: Vec<Vec<u32>>, n_groups: usize) {
        self.parts = parts.into_iter().map(|runs| Part { runs, wandered: 0.0, sound: f64::NEG_INFINITY }).collect();
        self.sound = vec![f64::NEG_INFINITY; n_groups];
    }

    /// Nothing wanders by itself any more.
    pub fn forget_parts(&mut self) {
        self.divide(vec![], 0);
    }

    /// Everything moves on to a time at which the bodies are there.
    pub fn go_on(&mut self, time: f64, bodies: &[BodyState]) {
        let passed = (time - self.time).max(0.0);
        let wandered = self.speed() * passed;
        for part in &mut self.parts {
            part.wandered += fastest(&part.runs, &self.speeds) * passed;
        }
        let known = self.bodies.len() == bodies.len()
            && self.bodies.iter().zip(bodies).all(|(was, now)| was.active || !now.active);
        if !known {
            self.until.fill(f64::NEG_INFINITY);
            self.clear.fill(f64::NEG_INFINITY);
            self.sieve = Sieve::default();
        }
        self.ball.1 += wandered;
        let moved = self.bodies.iter().zip(bodies).map(|(was, now)| self.displacement(was, now)).fold(0.0, f64::max);
        self.travelled += wandered + moved;
        self.time = time;
        self.bodies.clear();
        self.bodies.extend_from_slice(bodies);
    }

    /// Greatest speed of a node, m/s.
    pub fn speed(&self) -> f64 {
        self.speeds.iter().copied().fold(0.0, f64::max)
    }

    /// A node is as fast as that, m/s.
    pub fn note_speed(&mut self, node: usize, speed: f64) {
        let run = &mut self.speeds[node / RUN];
        *run = run.max(speed);
    }

    /// So fast is the fastest of each run that has moved on, m/s: of all its nodes, or of some.
    pub fn note_speeds(&mut self, of_all: bool, speeds: impl Iterator<Item = f64>) {
        for (run, speed) in self.speeds.iter_mut().zip(speeds) {
            *run = speed.max(if of_all { 0.0 } else { *run });
        }
    }

    /// Parts of the mesh.
    pub fn parts(&self) -> usize {
        self.parts.len()
    }

    /// What any node of a part has wandered at most up to a time that is not before the last one, m.
    pub fn wandered(&self, part: usize, time: f64) -> f64 {
        let Part { runs, wandered, .. } = &self.parts[part];
        wandered + fastest(runs, &self.speeds) * (time - self.time).max(0.0)
    }

    /// Whether an element of a part whose nodes have wandered so far, m, may be worn.
    pub fn may_be_worn(&self, part: usize, wandered: f64) -> bool {
        reaches(self.parts[part].sound, wandered)
    }

    /// The same of an element of a group.
    pub fn may_group_be_worn(&self, group: usize, wandered: f64) -> bool {
        reaches(self.sound[group], wandered)
    }

    /// Takes down what the nodes of its part will have wandered before an element of a group can be worn, m.
    pub fn note_sound(&mut self, group: usize, wandered: f64) {
        self.sound[group] = wandered;
    }

    /// Takes down that of a part of these groups.
    pub fn note_part(&mut self, part: usize, groups: std::ops::Range<usize>) {
        self.parts[part].sound = self.sound[groups].iter().copied().fold(f64::INFINITY, least);
    }

    /// How far a point of the body near the surface can have come, m: |R − R′| ≤ 2 |q − q′| for rotations.
    fn displacement(&self, was: &BodyState, now: &BodyState) -> f64 {
        let turned = 2.0 * (now.orientation.quaternion() - was.orientation.quaternion()).norm();
        let grown = match (&was.bulge, &now.bulge) {
            (Some(was), Some(now)) => (now.size - was.size).abs().sum(),
            _ => 0.0,
        };
        (now.position - was.position).norm() + turned * self.arm(was).max(self.arm(now)) + grown
    }

    /// Distance of the farthest node of the surface from the centre of a body, at most, m.
    fn arm(&self, body: &BodyState) -> f64 {
        (body.position - self.ball.0).norm() + self.ball.1
    }

    /// How far body and node can come towards each other in a time, as the limit on the path of a node has it, m.
    pub fn reach(&self, bodies: &[Body], horizon: f64) -> f64 {
        let approach = |(body, at): (&Body, &BodyState)| {
            let (growth, swelling) = at.bulge.map_or((0.0, 0.0), |bulge| (bulge.speed(), bulge.pull()));
            let pull = at.wrench.force.norm() / body.mass + swelling;
            at.velocity.norm() + body.angular_velocity(at).norm() * self.arm(at) + growth + pull * horizon
        };
        let active = bodies.iter().zip(&self.bodies).filter(|(_, at)| at.active);
        (active.map(approach).fold(0.0, f64::max) + self.speed()) * horizon
    }

    /// What will have been travelled before a node of this size may be met in a step in which body and node come towards each other by
    /// `reach`, or a facet around it must be looked at, m.
    #[inline]
    fn wake(&self, node: u32, size: f64, reach: f64) -> f64 {
        let (until, clear) = (self.until[node as usize], self.clear[node as usize]);
        least(until - size.max(reach), (until - STRETCH * size).max(clear))
    }

    /// Whether that is so now.
    #[inline]
    pub fn must_see(&self, node: u32, size: f64, reach: f64) -> bool {
        reaches(self.wake(node, size, reach), self.travelled)
    }

    /// Adds all nodes of the surface for which it is so and that fire, ascending.
    pub fn find_seen(&mut self, surface: &Surface, reach: f64, fires: impl Fn(NodeId) -> bool, seen: &mut Vec<u32>) {
        let sieve = &self.sieve;
        let holds = !reaches(sieve.until, self.travelled) && reach <= sieve.reach && sieve.idle <= surface.nodes.len();
        if !holds {
            self.sift(surface, FASTER * reach);
        }
        let before = seen.len();
        seen.extend(self.sieve.nodes.iter().copied().filter(|node| {
            let at = &surface.nodes[*node as usize];
            self.must_see(*node, at.size, reach) && fires(at.node)
        }));
        self.sieve.idle += self.sieve.nodes.len() - (seen.len() - before);
    }

    /// Fills the sieve. Only nodes in it are looked at and noted, so what is known of the others stays until it is filled anew.
    fn sift(&mut self, surface: &Surface, reach: f64) {
        let (mut nodes, mut until) = (std::mem::take(&mut self.sieve.nodes), f64::INFINITY);
        nodes.clear();
        for (node, at) in (0..).zip(&surface.nodes) {
            let wake = self.wake(node, at.size, reach);
            if reaches(wake, self.travelled + AHEAD * at.size) {
                nodes.push(node);
            } else {
                until = until.min(wake);
            }
        }
        self.sieve = Sieve { nodes, until, reach, idle: 0 };
    }

    /// Takes down how far the nearest body was.
    #[inline]
    pub fn note(&mut self, node: u32, distance: f64) {
        self.until[node as usize] = self.travelled + distance;
    }

    /// Whether a facet around a node may be deep in a body.
    #[inline]
    pub fn may_touch_facets(&self, node: u32) -> bool {
        reaches(self.clear[node as usize], self.travelled)
    }

    /// Takes down how far anything may travel before a facet around a node need be looked at, m.
    #[inline]
    pub fn note_facets(&mut self, node: u32, room: f64) {
        self.clear[node as usize] = self.travelled + room;
    }

    /// When the gaps were known, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Until when nothing comes within a distance, by node, of a surface that stands still: s after the time known.
    pub fn quiet(&self, bodies: &[Body], within: impl Fn(usize) -> f64) -> f64 {
        /// Halvings from a second; what is shorter than this is not worth skipping.
        const HALVINGS: i32 = 40;
        let room = |(i, until): (usize, &f64)| until - self.travelled - within(i);
        let margin = self.until.iter().enumerate().map(room).fold(f64::INFINITY, f64::min);
        let travel = |h: f64| {
            let way = |(body, at): (&Body, &BodyState)| self.way(body, at, h);
            let active = bodies.iter().zip(&self.bodies).filter(|(_, at)| at.active);
            active.map(way).fold(0.0, f64::max)
        };
        let lengths = (0..HALVINGS).map(|n| 0.5_f64.powi(n));
        lengths.into_iter().find(|h| travel(*h) < margin).unwrap_or(0.0)
    }

    /// How far a point of a body can come in a time, m.
    fn way(&self, body: &Body, at: &BodyState, h: f64) -> f64 {
        let wrench = &at.wrench;
        let pull = (wrench.force.norm() + wrench.force_rate.norm() * h) / body.mass;
        let turning = at.angular_momentum.norm() + (wrench.torque.norm() + wrench.torque_rate.norm() * h) * h;
        let grown = at.bulge.map_or(0.0, |bulge| bulge.speed() * h + 0.5 * bulge.pull() * h * h);
        let straight = at.velocity.norm() * h + 0.5 * pull * h * h;
        straight + body.inverse_inertia.norm() * turning * h * (self.arm(at) + straight) + grown
    }
}

/// Whether what was sound so far, m, may not be so any more; what is no number hides nothing.
fn reaches(sound: f64, wandered: f64) -> bool {
    let far = sound > wandered;
    !far
}

/// The least of two, or what is no number, which must not be lost: `f64::min` would drop it.
pub(super) fn least(least: f64, it: f64) -> f64 {
    if least.is_nan() || it >= least { least } else { it }
}

/// Greatest speed of these runs, m/s.
fn fastest(runs: &[u32], speeds: &[f64]) -> f64 {
    runs.iter().map(|run| speeds[*run as usize]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::test_cube::{self, any};
    use super::*;
    use crate::math::Vector3;

    #[test]
    fn no_node_slips_through_the_sieve() {
        let mesh = test_cube::mesh(&[0.0, 0.1, 0.2, 0.5, 1.0]);
        let mut surface = test_cube::gel(&mesh).surface;
        surface.nodes.iter_mut().zip(0..).for_each(|(at, i)| at.size = 0.02 + 0.01 * any(i));
        let n = surface.nodes.len();
        let place = |node: u32| mesh.rest[surface.nodes[node as usize].node.index()];
        let mut at = BodyState::starting(Vector3::new(1.06, 0.5, 0.5), Vector3::zeros());
        let mut watch = Watch::new(&surface, (0.0, vec![0.0]), |node| mesh.rest[node]);
        let fires = |i: usize| move |node: NodeId| any(i + 3 * node.index()) > -0.5;
        let (mut sifted, mut some) = (0, 0);
        for i in 1..=1000 {
            // To and fro in front of a face, and at last into it.
            at.position.x = if i < 800 { 1.06 + 0.002 * any(i) } else { at.position.x - 0.003 };
            watch.go_on(i as f64, &[at]);
            let reach = if i % 100 < 50 { 0.01 } else { 0.08 };
            let must = |node: &u32| {
                let of = &surface.nodes[*node as usize];
                watch.must_see(*node, of.size, reach) && fires(i)(of.node)
            };
            let all: Vec<u32> = (0..n as u32).filter(must).collect();
            let (mut seen, until) = (vec![], watch.sieve.until);
            watch.find_seen(&surface, reach, fires(i), &mut seen);
            assert_eq!(seen, all, "at {i}");
            sifted += usize::from(watch.sieve.until != until);
            some += usize::from(!seen.is_empty() && watch.sieve.nodes.len() < n);
            for node in seen {
                watch.note(node, (place(node) - at.position).norm());
                watch.note_facets(node, 0.1 * any(i + node as usize));
            }
        }
        assert!((3..500).contains(&sifted) && some > 100, "sifted {sifted} times, some were seen {some} times");
        watch.note_facets(3, f64::INFINITY);
        watch.note(3, f64::INFINITY);
        let is_in_sieve = |watch: &mut Watch| {
            watch.sieve = Sieve::default();
            watch.find_seen(&surface, 0.0, |_| true, &mut vec![]);
            watch.sieve.nodes.contains(&3)
        };
        assert!(!is_in_sieve(&mut watch));
        watch.note(3, f64::NAN);
        assert!(is_in_sieve(&mut watch), "what is no number hides nothing");
    }

    #[test]
    fn nothing_is_known_of_a_body_that_is_switched_on() {
        let mesh = test_cube::mesh(&[0.0, 1.0]);
        let surface = test_cube::gel(&mesh).surface;
        let mut watch = Watch::new(&surface, (0.0, vec![0.0]), |node| mesh.rest[node]);
        let on = BodyState::starting(Vector3::new(4.0, 0.5, 0.5), Vector3::zeros());
        let off = BodyState { active: false, ..on };
        let mut seen = |time: f64, at: BodyState| {
            let mut seen = vec![];
            watch.go_on(time, &[at]);
            watch.find_seen(&surface, 0.1, |_| true, &mut seen);
            for node in &seen {
                watch.note(*node, f64::INFINITY);
            }
            seen.len()
        };
        let n = surface.nodes.len();
        assert_eq!([seen(0.0, off), seen(1.0, off), seen(2.0, on)], [n, 0, n]);
    }
}
