//! The whole dynamic state as a value: clone it, compare it, hash it, write it.

use crate::algebra::{Vector, Vector3};
use crate::contact::BodyState;
use crate::ledger::Ledger;
use serde::{Deserialize, Serialize};

/// Count of ticks since the start; the length of a tick is fixed when a simulation is built (numerics A3).
pub type Tick = u64;

/// Everything that changes while a simulation runs. What can be derived from it (queues, bins, batches) is not in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize> {
    /// x, position of each node at its own last tick, m.
    pub position: Vec<Vector<D>>,
    /// v, velocity of each node since that tick, m/s.
    pub velocity: Vec<Vector<D>>,
    /// Last tick of each node.
    pub tick: Vec<Tick>,
    /// The clocks of the patches.
    pub clocks: Vec<Clock>,
    /// The projectile, and the fragments beside it, each at its own last event.
    pub bodies: Vec<BodyState>,
    /// The books.
    pub ledger: Ledger,
    /// What has been seen of the contact and the cost.
    pub record: Record,
}

/// The clock of a patch and what it knew at its own last tick.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Clock {
    /// Its last tick.
    pub last: Tick,
    /// Its next tick.
    pub next: Tick,
    /// Its step, ticks: `next − last` but for the tick in which a queue aligns itself with its neighbours.
    pub step: Tick,
    /// Own ticks in a row at which its limit was at least four times its step.
    pub calm: u32,
    /// Whether J ≤ 0 at the last tick.
    pub inverted: bool,
    /// κ, N/m.
    pub stiffness: f64,
    /// V, J.
    pub energy: f64,
    /// The part of the last kick's work that belongs to the step ahead: W · next/(last + next steps), J.
    pub ahead: f64,
    /// J = det F.
    pub jacobian: f64,
}

/// What has been seen since the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Patch updates.
    pub updates: u64,
    /// Smallest J.
    pub min_jacobian: f64,
    /// One global stable step: its length now, ticks; up to which tick it is counted; the updates so far.
    pub synchronous: (f64, Tick, f64),
    /// The contact of each body.
    pub contacts: Vec<ContactRecord>,
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
}

impl Record {
    /// Nothing yet, of so many bodies.
    #[must_use]
    pub fn new(n_bodies: usize) -> Self {
        let contacts = vec![ContactRecord::default(); n_bodies];
        Self { updates: 0, min_jacobian: 1.0, synchronous: (f64::INFINITY, 0, 0.0), contacts }
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
        }
    }
}

impl<const D: usize> State<D> {
    /// What contradicts itself, if anything: lengths, clocks that stand still, numbers that are none.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check_invariants(&self, (n_nodes, n_patches, n_bodies): (usize, usize, usize)) -> Result<(), &'static str> {
        let lengths = [self.position.len(), self.velocity.len(), self.tick.len()];
        let holds = |good: bool, what| if good { Ok(()) } else { Err(what) };
        holds(lengths == [n_nodes; 3] && self.clocks.len() == n_patches, "nodes or elements are missing")?;
        holds([self.bodies.len(), self.record.contacts.len()] == [n_bodies; 2], "a body is missing")?;
        let finite = |vectors: &[Vector<D>]| vectors.iter().flatten().all(|component| component.is_finite());
        holds(finite(&self.position) && finite(&self.velocity), "a position or velocity is not a number")?;
        let begun = self.clocks.iter().any(|clock| clock.step > 0);
        let runs = |clock: &Clock| clock.step > 0 && clock.next > clock.last;
        holds(!begun || self.clocks.iter().all(runs), "the clock of an element stands still")?;
        let next = self.clocks.iter().map(|clock| clock.next).max().unwrap_or(0);
        holds(self.tick.iter().all(|tick| *tick <= next), "a node is ahead of its elements")
    }

    /// Hash of the bytes of the state: equal digests are equal bits.
    ///
    /// # Panics
    /// Never: a state is plain numbers.
    #[must_use]
    pub fn digest(&self) -> u128 {
        let bytes = postcard::to_stdvec(self).expect("a state is plain numbers");
        xxhash_rust::xxh3::xxh3_128(&bytes)
    }
}
