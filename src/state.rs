//! Dynamic state of a simulation as a value that can be cloned, compared, hashed and serialised.

use crate::contact::BodyState;
use crate::fem::HistoryVariables;
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

mod bytes;
mod mesh_instance;

pub use mesh_instance::MeshInstance;

/// Tick count since the start; the length of a tick is fixed when a simulation is built (method A3).
pub type Tick = u64;

/// Bound below which ticks are exact in floating point.
pub const MOST_TICKS: Tick = 1 << 53;

/// Dynamic state of a simulation. Data derived from it (queues, bins, batches, the last tick of each node) is not
/// part of it.
#[derive(Debug, PartialEq)]
pub struct DynamicState<const D: usize> {
    /// x, position of each node at its own last tick, m.
    pub position: Vec<Vector<D>>,
    /// v, velocity of each node since that tick, m/s.
    pub velocity: Vec<Vector<D>>,
    /// Q = ½ p·Δv of the last kick of each node, J: A + Q is the leading work of the kick with the velocity after it.
    pub excess: Vec<f64>,
    /// κ, stiffness of each element at its own last tick, N/m, in the order of the groups.
    pub stiffness: Vec<f64>,
    /// Clocks of the groups of patches that step together.
    pub clocks: Vec<GroupClock>,
    /// Last and next tick of each group of the queue; the groups of bins are active on the multiples of their steps.
    pub alarms: Vec<GroupAlarm>,
    /// History variables by element; empty for elements without any.
    pub memory: Vec<HistoryVariables<D>>,
    /// Mesh instance, unless it is the first mesh.
    pub birth: Option<Arc<MeshInstance<D>>>,
    /// Last tick that was processed.
    pub now: Option<Tick>,
    /// States of the projectile and of the fragments, each at its own last event.
    pub bodies: Vec<BodyState>,
    /// Balance ledger.
    pub ledger: Ledger,
    /// Record of the contact and the cost.
    pub record: RunRecord,
}

impl<const D: usize> DynamicState<D> {
    /// Returns the position of a node drifted by a time since its last tick, s, in m.
    #[inline]
    #[must_use]
    pub fn drifted(&self, node: usize, time: f64) -> Vector<D> {
        self.position[node] + self.velocity[node] * time
    }
}

/// Clock of a group of patches, with its values at its own last tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroupClock {
    /// Step, ticks; 0 before the first tick.
    pub step: Tick,
    /// V, stored energy, J.
    pub energy: f64,
    /// A = ½ Δt f·v, leading work of the last kick with the velocity before it, J.
    pub ahead: f64,
    /// Hold count: own ticks in a row at which the limit was at least four times the step.
    pub calm: u32,
    /// Bit set of the elements with J ≤ 0 at the last tick, by their index in the group.
    pub inverted: u32,
    /// Number of elements compressed beyond the start of the energy's continuation.
    pub crushed: u32,
}

/// Alarm of a group of the queue: its last and next active ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GroupAlarm {
    /// Last tick of the group.
    pub last: Tick,
    /// Next tick of the group: one step later, except where the group aligns itself with its neighbours.
    pub next: Tick,
}

/// Record of the contact and the cost since the start.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Number of element updates.
    pub updates: u64,
    /// Number of remeshes.
    pub remeshes: u64,
    /// Number of ticks at which the contact solver ended without reaching its residual.
    pub unconverged_solves: u64,
    /// Eroded mass, kg.
    pub eroded_mass: f64,
    /// Smallest J so far.
    pub min_jacobian: f64,
    /// Stretch of the surface over a body at the last tick.
    pub stretch: SurfaceStretch,
    /// Reference of one global stable step: its present length, ticks; the tick up to which it is counted; the
    /// updates so far.
    pub synchronous: (f64, Tick, f64),
    /// Σ |J| of the pressures on faces, N·s.
    pub pressed: f64,
    /// Impulse on the gel from outside.
    pub outside: OutsideImpulse,
    /// Air in the cavity, where it flows in; in the bytes of a state it follows the arrays.
    #[serde(skip)]
    pub gas: Option<CavityGas>,
    /// True if the gel is no longer integrated: the projectile has left it, and its end after the exit has
    /// come.
    pub at_rest: bool,
    /// Contact record of each body.
    pub contacts: Vec<ContactRecord>,
}

/// Air in the cavity behind the projectile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CavityGas {
    /// Pressure relative to that of the surrounding air.
    pub pressure: f64,
    /// Volume, m³.
    pub volume: f64,
    /// Tick at which both were found.
    pub tick: Tick,
}

impl CavityGas {
    /// Returns true if both numbers are finite and positive.
    fn is_valid(&self) -> bool {
        [self.pressure, self.volume].iter().all(|x| *x > 0.0 && x.is_finite())
    }
}

/// Impulse on the gel from outside, by bodies, pressures, air and damping, with its moment in time.
///
/// Both change at impulses alone, so that they do not depend on communication points.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct OutsideImpulse {
    /// Σ J, N·s.
    pub sum: Vector3,
    /// Σ J t of impulses at times t, N·s².
    pub moment: Vector3,
}

impl OutsideImpulse {
    /// Adds an impulse, N·s, at a time, s.
    pub fn add(&mut self, impulse: &Vector3, time: f64) {
        self.sum += impulse;
        self.moment += impulse * time;
    }

    /// Returns Σ J (t − t_J), the integral of the impulse over time up to `time`, s, in N·s².
    #[must_use]
    pub fn integral(&self, time: f64) -> Vector3 {
        self.sum * time - self.moment
    }

    /// Returns true if all numbers are finite.
    fn is_valid(&self) -> bool {
        self.sum.iter().chain(&self.moment).all(|x| x.is_finite())
    }
}

/// Stretch of the surface over a body, by the depth of the facets; between the nodes nothing else shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SurfaceStretch {
    /// Within the limit of a mesh.
    Little,
    /// Deep enough that the mesh is distorted.
    Distorted,
    /// Beyond the leak depth (A11): the mesh ends.
    Leaking,
}

/// Contact record of a body since the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactRecord {
    /// Impulse on the body, N·s.
    pub impulse: Vector3,
    /// Direction of the last impulse on the body; zero before the first.
    pub direction: Vector3,
    /// Times of the first and the last impulse, s.
    pub touched: Option<(f64, f64)>,
    /// Greatest approach speed of a touching node, m/s.
    pub approach: f64,
    /// Window of the peak force: its number, the impulse in it, N·s, and the greatest of all windows, N·s.
    pub window: (u64, Vector3, f64),
    /// Greatest depth at an impulse, m, and its time, s.
    pub peak_depth: (f64, f64),
    /// Σ |g|/h over impulses on nodes, and the number of impulses.
    pub standing: (f64, u64),
    /// Greatest |g|/h of an impulse on a node.
    pub deepest: f64,
    /// Work of the contact on the body, J; negative for a body that gives energy to the gel.
    pub work: f64,
    /// Exit record of a body that has left the gel at its back face.
    pub exit: Option<ExitRecord>,
}

impl ContactRecord {
    /// Returns the energy that the body has given to the gel, J, in an inertial frame of this velocity, m/s.
    #[must_use]
    pub fn energy_given(&self, frame: &Vector3) -> f64 {
        frame.dot(&self.impulse) - self.work
    }

    /// Adds an impulse on the body, N·s, at a time, s, and its depth, m: to the sum, and to the window of the peak force, s.
    pub fn add_impulse(&mut self, impulse: &Vector3, time: f64, depth: f64, window: f64) {
        self.impulse += impulse;
        self.direction = impulse.try_normalize(0.0).unwrap_or(self.direction);
        self.touched = Some((self.touched.map_or(time, |touched| touched.0), time));
        if depth > self.peak_depth.0 {
            self.peak_depth = (depth, time);
        }
        let present = (time / window) as u64;
        let (number, sum, greatest) = self.window;
        let sum = if present == number { sum + impulse } else { *impulse };
        self.window = (present, sum, greatest.max(sum.norm()));
    }
}

/// Exit record of a body: its rear end passes the undisturbed back face of the gel. Velocity and energies are those in
/// the inertial frame in which the gel was at rest at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExitRecord {
    /// Time, s.
    pub time: f64,
    /// Velocity at the exit, m/s.
    pub velocity: Vector3,
    /// Kinetic energy at the exit, J.
    pub residual_energy: f64,
    /// Energy given to the gel up to the exit, J.
    pub energy_deposited: f64,
}

impl ExitRecord {
    /// Returns true if all numbers are finite.
    fn is_valid(&self) -> bool {
        let Self { time, velocity, residual_energy, energy_deposited } = self;
        velocity.iter().chain([time, residual_energy, energy_deposited]).all(|x| x.is_finite())
    }
}

impl RunRecord {
    /// Creates an empty record of `n_bodies` bodies.
    #[must_use]
    pub fn new(n_bodies: usize) -> Self {
        let contacts = vec![ContactRecord::default(); n_bodies];
        Self {
            updates: 0,
            remeshes: 0,
            unconverged_solves: 0,
            eroded_mass: 0.0,
            min_jacobian: 1.0,
            stretch: SurfaceStretch::Little,
            synchronous: (f64::INFINITY, 0, 0.0),
            pressed: 0.0,
            outside: OutsideImpulse::default(),
            gas: None,
            at_rest: false,
            contacts,
        }
    }

    /// Checks the records of contact and the impulse on the gel.
    ///
    /// # Errors
    /// The first number that is none.
    pub fn check_contacts(&self) -> Result<(), &'static str> {
        let exits = self.contacts.iter().filter_map(|contact| contact.exit.as_ref());
        let has_valid_exits = exits.fold(true, |good, exit| good & exit.is_valid());
        has_valid_exits.then_some(()).ok_or("the exit of a body is not a number")?;
        self.outside.is_valid().then_some(()).ok_or("the impulse on the gel is not a number")
    }
}

impl Default for ContactRecord {
    fn default() -> Self {
        Self {
            impulse: Vector3::zeros(),
            direction: Vector3::zeros(),
            touched: None,
            approach: 0.0,
            window: (0, Vector3::zeros(), 0.0),
            peak_depth: (f64::NEG_INFINITY, 0.0),
            standing: (0.0, 0),
            deepest: 0.0,
            work: 0.0,
            exit: None,
        }
    }
}

/// Sizes of the arrays of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateSizes {
    /// Nodes.
    pub nodes: usize,
    /// Slots of elements, empty ones included.
    pub slots: usize,
    /// Groups of patches.
    pub groups: usize,
    /// Groups of the queue.
    pub alarms: usize,
    /// Elements with history variables.
    pub memories: usize,
    /// Bodies.
    pub bodies: usize,
    /// Elements of a mesh that is not the first one.
    pub born: usize,
    /// Elements of that mesh whose reference shape is not that of their nodes' rest positions.
    pub references: usize,
    /// Elements of that mesh with parts of several materials: none or all.
    pub layered: usize,
}

impl<const D: usize> DynamicState<D> {
    /// Creates a state with empty arrays.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            position: vec![],
            velocity: vec![],
            excess: vec![],
            stiffness: vec![],
            clocks: vec![],
            alarms: vec![],
            memory: vec![],
            birth: None,
            now: None,
            bodies: vec![],
            ledger: Ledger::default(),
            record: RunRecord::new(0),
        }
    }

    /// Returns the bytes of its arrays, without the mesh, which copies share.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let Self { position, velocity, excess, stiffness, clocks, alarms, memory, bodies, .. } = self;
        size_of_val(&position[..])
            + size_of_val(&velocity[..])
            + size_of_val(&excess[..])
            + size_of_val(&stiffness[..])
            + size_of_val(&clocks[..])
            + size_of_val(&alarms[..])
            + size_of_val(&memory[..])
            + size_of_val(&bodies[..])
    }

    /// Checks the consistency of the state: lengths, clocks that stand still, numbers that are not finite.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check_invariants(&self, sizes: &StateSizes) -> Result<(), &'static str> {
        let holds = |good: bool, what| if good { Ok(()) } else { Err(what) };
        let nodes = [self.position.len(), self.velocity.len(), self.excess.len()];
        let lengths = [nodes[0], nodes[1], nodes[2], self.stiffness.len(), self.clocks.len()];
        let expected = [sizes.nodes, sizes.nodes, sizes.nodes, sizes.slots, sizes.groups];
        holds(lengths == expected && self.alarms.len() == sizes.alarms, "nodes or elements are missing")?;
        holds([self.bodies.len(), self.record.contacts.len()] == [sizes.bodies; 2], "a body is missing")?;
        let finite = |vectors: &[Vector<D>]| all_hold(vectors, |x| x.iter().fold(true, |good, c| good & c.is_finite()));
        holds(finite(&self.position) && finite(&self.velocity), "a position or velocity is not a number")?;
        holds(
            all_hold(&self.stiffness, |stiffness| (0.0..f64::INFINITY).contains(stiffness)),
            "the stiffness of an element is not a number",
        )?;
        self.record.check_contacts()?;
        let is_past = |gas: CavityGas| gas.is_valid() && Some(gas.tick) <= self.now;
        holds(self.record.gas.is_none_or(is_past), "the air in the cavity is not a positive number")?;
        let begun = self.now.is_some();
        holds(begun || !self.record.at_rest, "a gel that has not started is marked as at rest")?;
        holds(all_hold(&self.clocks, |clock| begun == (clock.step > 0)), "the clock of an element has no step ahead")?;
        let memories = self.memory.len() == sizes.memories && self.memory.iter().all(HistoryVariables::is_valid);
        holds(memories, "a history variable of an element is missing or not a number")?;
        holds(self.bodies.iter().all(BodyState::is_valid), "the state of a body has a value that is not a number")?;
        let ticks = self
            .clocks
            .iter()
            .map(|clock| clock.step)
            .chain(self.alarms.iter().map(|alarm| alarm.next))
            .chain(self.now);
        holds(ticks.fold(0, Tick::max) < MOST_TICKS, "a tick is too far away")?;
        let runs = |alarm: &GroupAlarm| alarm.next > alarm.last && Some(alarm.last) <= self.now;
        holds(!begun || self.alarms.iter().all(runs), "the clock of an element has no step ahead")
    }
}

/// Cloned by hand, as a derived `clone_from` allocates new memory even where there is some.
impl<const D: usize> Clone for DynamicState<D> {
    fn clone(&self) -> Self {
        let mut copy = Self::empty();
        copy.clone_from(self);
        copy
    }

    fn clone_from(&mut self, from: &Self) {
        let Self { position, velocity, excess, stiffness, clocks, alarms, memory, birth, now, bodies, ledger, record } =
            from;
        self.position.clone_from(position);
        self.velocity.clone_from(velocity);
        self.excess.clone_from(excess);
        self.stiffness.clone_from(stiffness);
        self.clocks.clone_from(clocks);
        self.alarms.clone_from(alarms);
        self.memory.clone_from(memory);
        self.birth.clone_from(birth);
        self.bodies.clone_from(bodies);
        self.record.clone_from(record);
        (self.now, self.ledger) = (*now, *ledger);
    }
}

impl Clone for RunRecord {
    fn clone(&self) -> Self {
        Self { contacts: self.contacts.clone(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        let Self { updates, remeshes, eroded_mass, min_jacobian, stretch, synchronous, pressed, .. } = from;
        let Self { outside, gas, at_rest, contacts, unconverged_solves, .. } = from;
        self.contacts.clone_from(contacts);
        (self.outside, self.gas) = (*outside, *gas);
        (self.updates, self.remeshes, self.eroded_mass) = (*updates, *remeshes, *eroded_mass);
        self.unconverged_solves = *unconverged_solves;
        (self.pressed, self.at_rest) = (*pressed, *at_rest);
        (self.min_jacobian, self.stretch, self.synchronous) = (*min_jacobian, *stretch, *synchronous);
    }
}

/// Returns true if all items are good. It counts to the end, as an early return prevents vectorisation.
fn all_hold<T>(items: &[T], good: impl Fn(&T) -> bool) -> bool {
    items.iter().filter(|item| !good(item)).count() == 0
}
