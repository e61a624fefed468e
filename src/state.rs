//! The whole dynamic state as a value: clone it, compare it, hash it, write it.

use crate::contact::BodyState;
use crate::fem::Memory;
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

mod bytes;
mod mesh_instance;

pub use mesh_instance::Birth;

/// Count of ticks since the start; the length of a tick is fixed when a simulation is built (numerics A3).
pub type Tick = u64;

/// Ticks are exact in floating point below this.
pub const MOST_TICKS: Tick = 1 << 53;

/// Everything that changes while a simulation runs. What can be derived from it (queues, bins, batches, the last tick of each
/// node) is not in it.
#[derive(Debug, PartialEq)]
pub struct State<const D: usize> {
    /// x, position of each node at its own last tick, m.
    pub position: Vec<Vector<D>>,
    /// v, velocity of each node since that tick, m/s.
    pub velocity: Vec<Vector<D>>,
    /// Q = ½ p·Δv of the last kick of each node, J: with A what is ahead of it has the velocity after the kick.
    pub excess: Vec<f64>,
    /// κ of each element at its own last tick, N/m, in the order of the groups.
    pub stiffness: Vec<f64>,
    /// The clocks of the groups of patches that step together.
    pub clocks: Vec<Clock>,
    /// Last and next tick of each group of the queue; the bins need none: their groups fire on the multiples of their steps.
    pub alarms: Vec<Alarm>,
    /// What elements remember, by element; nothing of those that do not.
    pub memory: Vec<Memory<D>>,
    /// The mesh, unless it is that of the start.
    pub birth: Option<Arc<Birth<D>>>,
    /// The last tick that was processed.
    pub now: Option<Tick>,
    /// The projectile, and the fragments beside it, each at its own last event.
    pub bodies: Vec<BodyState>,
    /// The books.
    pub ledger: Ledger,
    /// What has been seen of the contact and the cost.
    pub record: Record,
}

/// The clock of a group of patches and what it knew at its own last tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Clock {
    /// Its step, ticks; 0 before the first.
    pub step: Tick,
    /// V, J.
    pub energy: f64,
    /// A = ½ Δt f·v, the work of the last kick in the first half of the step ahead, J, with the velocity before the kick.
    pub ahead: f64,
    /// Own ticks in a row at which its limit was at least four times its step.
    pub calm: u32,
    /// Which elements had J ≤ 0 at the last tick, by their place in the group.
    pub inverted: u32,
    /// How many elements are below the continuation.
    pub crushed: u32,
}

/// When a group of the queue fires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Alarm {
    /// Its last tick.
    pub last: Tick,
    /// Its next tick: a step later, but for the tick in which it aligns itself with its neighbours.
    pub next: Tick,
}

/// What has been seen since the start.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Element updates.
    pub updates: u64,
    /// Exchanges of the mesh.
    pub remeshes: u64,
    /// Mass of what has broken off, kg.
    pub splashed: f64,
    /// Smallest J.
    pub min_jacobian: f64,
    /// How far the surface was stretched over a body at the last tick.
    pub stretch: Stretch,
    /// One global stable step: its length now, ticks; up to which tick it is counted; the updates so far.
    pub synchronous: (f64, Tick, f64),
    /// Σ |J| of the pressures on faces, N·s.
    pub pressed: f64,
    /// Tells that the gel is no longer integrated: the projectile has left it, and `scene.stop_after_exit` has passed.
    pub at_rest: bool,
    /// The contact of each body.
    pub contacts: Vec<ContactRecord>,
}

/// How deep facets are in bodies: between its nodes nothing else shows how far a surface is stretched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Stretch {
    /// No deeper than a mesh bears.
    Little,
    /// So deep that the mesh is worn.
    Worn,
    /// Deeper than anything may be (A11): the mesh ends.
    Leaking,
}

/// What has been seen of the contact of a body since the start.
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
    /// The window of the peak force: its number, the impulse in it, N·s, and the greatest of all windows, N·s.
    pub window: (u64, Vector3, f64),
    /// Greatest depth at an impulse, m, and when, s.
    pub peak_depth: (f64, f64),
    /// Σ |g|/h over impulses on nodes, and their number.
    pub standing: (f64, u64),
    /// Greatest |g|/h of an impulse on a node.
    pub deepest: f64,
    /// Work of the contact on the body, J; negative of one that gives energy to the gel.
    pub work: f64,
    /// The exit of a body that has left the gel at its back face.
    pub exit: Option<ExitRecord>,
}

/// The exit of a body: its rear end passes the undisturbed back face of the gel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExitRecord {
    /// Time, s.
    pub time: f64,
    /// Velocity then, m/s.
    pub velocity: Vector3,
    /// Kinetic energy then, J.
    pub residual_energy: f64,
    /// Energy that the body had given to the gel by then, J.
    pub energy_deposited: f64,
}

impl ExitRecord {
    /// Returns true if all of it are finite numbers.
    fn is_valid(&self) -> bool {
        let Self { time, velocity, residual_energy, energy_deposited } = self;
        velocity.iter().chain([time, residual_energy, energy_deposited]).all(|x| x.is_finite())
    }
}

impl Record {
    /// Nothing yet, of so many bodies.
    #[must_use]
    pub fn new(n_bodies: usize) -> Self {
        let contacts = vec![ContactRecord::default(); n_bodies];
        Self {
            updates: 0,
            remeshes: 0,
            splashed: 0.0,
            min_jacobian: 1.0,
            stretch: Stretch::Little,
            synchronous: (f64::INFINITY, 0, 0.0),
            pressed: 0.0,
            at_rest: false,
            contacts,
        }
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

/// How much of everything a state has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sizes {
    /// Nodes.
    pub nodes: usize,
    /// Places for elements, empty ones included.
    pub slots: usize,
    /// Groups of patches.
    pub groups: usize,
    /// Groups of the queue.
    pub alarms: usize,
    /// Elements that remember.
    pub memories: usize,
    /// Bodies.
    pub bodies: usize,
    /// Elements of a mesh that is not that of the start.
    pub born: usize,
    /// Those of them that are not at rest what their nodes say.
    pub references: usize,
}

impl<const D: usize> State<D> {
    /// A state of nothing.
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
            record: Record::new(0),
        }
    }

    /// Bytes of its arrays, but for a mesh, which copies share.
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

    /// What contradicts itself, if anything: lengths, clocks that stand still, numbers that are none.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check_invariants(&self, sizes: &Sizes) -> Result<(), &'static str> {
        let holds = |good: bool, what| if good { Ok(()) } else { Err(what) };
        let nodes = [self.position.len(), self.velocity.len(), self.excess.len()];
        let lengths = [nodes[0], nodes[1], nodes[2], self.stiffness.len(), self.clocks.len()];
        let expected = [sizes.nodes, sizes.nodes, sizes.nodes, sizes.slots, sizes.groups];
        holds(lengths == expected && self.alarms.len() == sizes.alarms, "nodes or elements are missing")?;
        holds([self.bodies.len(), self.record.contacts.len()] == [sizes.bodies; 2], "a body is missing")?;
        let finite = |vectors: &[Vector<D>]| each(vectors, |x| x.iter().fold(true, |good, c| good & c.is_finite()));
        holds(finite(&self.position) && finite(&self.velocity), "a position or velocity is not a number")?;
        holds(
            each(&self.stiffness, |stiffness| (0.0..f64::INFINITY).contains(stiffness)),
            "the stiffness of an element is not a number",
        )?;
        let exits = self.record.contacts.iter().filter_map(|contact| contact.exit.as_ref());
        holds(exits.fold(true, |good, exit| good & exit.is_valid()), "the exit of a body is no number")?;
        let begun = self.now.is_some();
        holds(begun || !self.record.at_rest, "a gel that has not begun is at rest")?;
        holds(each(&self.clocks, |clock| begun == (clock.step > 0)), "the clock of an element stands still")?;
        let memories = self.memory.len() == sizes.memories && self.memory.iter().all(Memory::is_valid);
        holds(memories, "what an element remembers is missing or no number")?;
        holds(self.bodies.iter().all(BodyState::is_valid), "a number of a body is none")?;
        let ticks = self
            .clocks
            .iter()
            .map(|clock| clock.step)
            .chain(self.alarms.iter().map(|alarm| alarm.next))
            .chain(self.now);
        holds(ticks.fold(0, Tick::max) < MOST_TICKS, "a tick is too far away")?;
        let runs = |alarm: &Alarm| alarm.next > alarm.last && Some(alarm.last) <= self.now;
        holds(!begun || self.alarms.iter().all(runs), "the clock of an element stands still")
    }
}

/// By hand, because a derived one copies into new memory even where there is some.
impl<const D: usize> Clone for State<D> {
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

impl Clone for Record {
    fn clone(&self) -> Self {
        Self { contacts: self.contacts.clone(), ..*self }
    }

    fn clone_from(&mut self, from: &Self) {
        let Self { updates, remeshes, splashed, min_jacobian, stretch, synchronous, pressed, at_rest, contacts } = from;
        self.contacts.clone_from(contacts);
        (self.updates, self.remeshes, self.splashed) = (*updates, *remeshes, *splashed);
        (self.pressed, self.at_rest) = (*pressed, *at_rest);
        (self.min_jacobian, self.stretch, self.synchronous) = (*min_jacobian, *stretch, *synchronous);
    }
}

/// Whether all of them are good; counted to the end, because a way out in between keeps the machine from taking several at once.
fn each<T>(items: &[T], good: impl Fn(&T) -> bool) -> bool {
    items.iter().filter(|item| !good(item)).count() == 0
}
