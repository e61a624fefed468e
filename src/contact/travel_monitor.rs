//! Monitor of travel: tells which sets of nodes may have travelled farther than they are allowed since their
//! measurement.
//!
//! A *set* is the nodes of one side of a separation proof ([`super::separation_list`]). The proof holds until a node of
//! the set has travelled farther than a bound, as the distances in a Verlet list hold until an atom has crossed the
//! skin (Verlet 1967). At most ticks no set is exhausted. To see that, the monitor looks at batches of nodes, not at
//! sets.
//!
//! [`BatchTravel`] gives the travel s_b of each batch b of 32 consecutive nodes, a sum of greatest speed times step. It
//! bounds the displacement of every node of the batch, and never falls. A set k that was measured at the travels s_b⁰
//! and may travel by a_k since is exhausted as soon as
//!
//! ```text
//!   max over b of k  (s_b − s_b⁰) > a_k      or, for one of its batches,      s_b > s_b⁰ + a_k =: limit of k in b
//! ```
//!
//! Each batch has an *alarm* at the least limit of its sets. Only a batch that has passed its alarm makes the monitor
//! look at the sets of this batch:
//!
//! ```text
//!   travel of batch b
//!     │ ─────────────────────────────────────  limit of set 2
//!     │                              ▗▄▀
//!     │ ───────────────────────────▄▀────────  limit of set 1 = alarm of b
//!     │                      ▗▄▄▄▀▀  ↑
//!     │                 ▗▄▀▀▘        set 1 is exhausted and measured again; the alarm rises to its next least limit
//!     │  ▗▄▄▄▄▄▄▄▄▄▄▄▄▄▀▘
//!     └──────────────────────────────────────▶ time
//! ```
//!
//! A bound that falls lowers the alarms of its batches at once. A measurement raises limits, but leaves alarms: one
//! that is too low costs a look, and is then reset. No alarm is ever above a limit of its sets, so no exhausted set is
//! missed.

use super::batch_travel::BatchTravel;
use crate::mesh::NodeId;
use std::ops::Range;

/// Monitor of the travel of sets of nodes. The travel of a node is bounded by that of its batch.
///
/// An *entry* is one batch of one set. The entries of all sets stand in one list, set by set.
#[derive(Debug)]
pub(super) struct TravelMonitor {
    /// Range of each set in the list of entries.
    entries: Vec<Range<usize>>,
    /// Batch of each entry.
    batches: Vec<u32>,
    /// Travel s_b⁰ of the batch of each entry when its set was measured, m.
    measured: Vec<f64>,
    /// Bound a_k of the travel of each set since its measurement, m.
    bounds: Vec<f64>,
    /// Travel of each batch from which on one of its sets may be exhausted, m: at most the least limit of these.
    alarms: Vec<f64>,
    /// Entries of each batch.
    of_batch: Vec<Vec<SetEntry>>,
}

/// Entry of a set in the list of entries.
#[derive(Debug, Clone, Copy)]
struct SetEntry {
    set: u32,
    entry: u32,
}

impl TravelMonitor {
    /// Creates the monitor of sets of nodes, measured at these travels of the batches, m, without a bound.
    pub fn new<'a>(sets: impl Iterator<Item = &'a [NodeId]>, travel: &[f64]) -> Self {
        let (mut entries, mut batches, mut of_batch) = (vec![], vec![], vec![vec![]; travel.len()]);
        for (set, nodes) in (0..).zip(sets) {
            let first = batches.len();
            let mut own: Vec<u32> = nodes.iter().map(|node| BatchTravel::batch_of(*node) as u32).collect();
            own.sort_unstable();
            own.dedup();
            batches.append(&mut own);
            for entry in first..batches.len() {
                of_batch[batches[entry] as usize].push(SetEntry { set, entry: entry as u32 });
            }
            entries.push(first..batches.len());
        }
        Self {
            measured: batches.iter().map(|batch| travel[*batch as usize]).collect(),
            bounds: vec![f64::INFINITY; entries.len()],
            alarms: vec![f64::INFINITY; travel.len()],
            entries,
            batches,
            of_batch,
        }
    }

    /// Returns true if a batch has passed its alarm, so that a set may be exhausted.
    #[inline]
    pub fn has_alarm(&self, travel: &[f64]) -> bool {
        self.alarms.iter().zip(travel).any(|(alarm, travel)| exceeds(*travel, *alarm))
    }

    /// Appends the exhausted sets, those with several batches perhaps more than once.
    pub fn append_exhausted(&self, travel: &[f64], exhausted: &mut Vec<u32>) {
        for (batch, travel) in
            travel.iter().enumerate().filter(|(batch, travel)| exceeds(**travel, self.alarms[*batch]))
        {
            let is_exhausted = |at: &&SetEntry| exceeds(*travel, self.limit(**at));
            exhausted.extend(self.of_batch[batch].iter().filter(is_exhausted).map(|at| at.set));
        }
    }

    /// Resets the alarms that have been passed to the least limit of the sets of their batch.
    pub fn reset_alarms(&mut self, travel: &[f64]) {
        for (batch, travel) in travel.iter().enumerate() {
            if exceeds(*travel, self.alarms[batch]) {
                self.alarms[batch] =
                    self.of_batch[batch].iter().map(|at| self.limit(*at)).fold(f64::INFINITY, f64::min);
            }
        }
    }

    /// Returns the limit s_b⁰ + a_k of a set in one of its batches, m.
    fn limit(&self, at: SetEntry) -> f64 {
        self.measured[at.entry as usize] + self.bounds[at.set as usize]
    }

    /// Starts the travel of a set anew at its measurement, s_b⁰ = s_b, without a bound until [`Self::limit_travel`].
    pub fn restart(&mut self, set: usize, travel: &[f64]) {
        for entry in self.entries[set].clone() {
            self.measured[entry] = travel[self.batches[entry] as usize];
        }
        self.bounds[set] = f64::INFINITY;
    }

    /// Returns the greatest travel max (s_b − s_b⁰) of a set since its measurement, m.
    #[inline]
    pub fn travel_since_measured(&self, set: usize, travel: &[f64]) -> f64 {
        let (range, mut most) = (self.entries[set].clone(), 0.0_f64);
        for (batch, measured) in self.batches[range.clone()].iter().zip(&self.measured[range]) {
            most = most.max(travel[*batch as usize] - measured);
        }
        most
    }

    /// Limits the travel of a set since its measurement, m; the least of all bounds since then counts.
    #[inline]
    pub fn limit_travel(&mut self, set: usize, bound: f64) {
        if bound < self.bounds[set] {
            self.bounds[set] = bound;
            for entry in self.entries[set].clone() {
                let alarm = &mut self.alarms[self.batches[entry] as usize];
                *alarm = alarm.min(self.measured[entry] + bound);
            }
        }
    }
}

/// Returns true if a travel exceeds a limit, or if one of them is not a number: the set is then looked at.
#[inline]
fn exceeds(travel: f64, limit: f64) -> bool {
    let is_within = travel <= limit;
    !is_within
}
