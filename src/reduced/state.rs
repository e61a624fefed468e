//! Dynamic state of the reduced model as a value.

use super::CavityRing;
use crate::contact::BodyState;
use crate::ledger::Ledger;
use crate::state::{MOST_TICKS, RunRecord, Tick};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

/// Dynamic state of a gel of rings and a body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReducedState {
    /// Last tick; `None` before the first.
    pub now: Option<Tick>,
    /// Next tick.
    pub next: Tick,
    /// Depth at which the spring is anchored, m.
    pub anchor: f64,
    /// Energy that the body has given to the gel, J.
    pub given: f64,
    /// State of the body at its last event; of one body.
    pub bodies: Vec<BodyState>,
    /// Balance ledger.
    pub ledger: Ledger,
    /// Record of the contact and the cost.
    pub record: RunRecord,
    /// Rings that the nose has passed, from the entry on.
    pub rings: Vec<CavityRing>,
}

impl ReducedState {
    /// Creates the state of a body before the first tick.
    #[must_use]
    pub fn at_start(body: BodyState) -> Self {
        Self {
            now: None,
            next: 0,
            anchor: 0.0,
            given: 0.0,
            bodies: vec![body],
            ledger: Ledger::default(),
            record: RunRecord::new(1),
            rings: vec![],
        }
    }

    /// Creates an empty state, to be written over.
    #[must_use]
    pub fn empty() -> Self {
        Self::at_start(BodyState::at_start(crate::math::Vector3::zeros(), crate::math::Vector3::zeros()))
    }

    /// Checks the consistency of the state for a gel of this greatest number of rings.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check_invariants(&self, most_rings: usize) -> Result<(), &'static str> {
        let holds = |good: bool, what| if good { Ok(()) } else { Err(what) };
        holds([self.bodies.len(), self.record.contacts.len()] == [1; 2], "a body is missing")?;
        holds(self.bodies.iter().all(BodyState::is_valid), "the state of a body has a value that is not a number")?;
        holds(self.anchor.is_finite() && self.given.is_finite(), "the spring is not a number")?;
        holds(self.rings.len() <= most_rings, "the gel has fewer rings")?;
        holds(self.rings.iter().all(CavityRing::is_valid), "a ring of the cavity is not a number")?;
        self.record.check_contacts()?;
        holds(self.next < MOST_TICKS && self.now.is_none_or(|now| now < self.next), "a tick is too far away")
    }

    /// Returns the bytes of the state.
    ///
    /// # Panics
    /// Never: a state is plain values.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        postcard::to_stdvec(self).expect("a state is plain values")
    }

    /// Reads a state from bytes; `None` if they are no state.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        postcard::take_from_bytes(bytes).ok().filter(|(_, rest)| rest.is_empty()).map(|(state, _)| state)
    }

    /// Returns the hash of the state.
    #[must_use]
    pub fn digest(&self) -> u128 {
        xxh3_128(&self.to_bytes())
    }
}
