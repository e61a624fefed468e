//! Monitor of travel: it tells when the nodes of a set have travelled as far as the set is allowed since it was measured.

use super::batch_travel::BatchTravel;
use crate::mesh::NodeId;
use std::ops::Range;

/// Monitor of the travel of sets of nodes. The travel of a node is bounded by that of its batch.
#[derive(Debug)]
pub(super) struct TravelMonitor {
    /// Range of each set in the lists of its batches.
    ranges: Vec<Range<usize>>,
    /// Batches of each set.
    batches: Vec<u32>,
    /// Travel of each batch of each set when the set was measured, m.
    measured: Vec<f64>,
    /// Travel since that each set is allowed, m.
    allowed: Vec<f64>,
    /// Travel of each batch at which a set has used up what it is allowed, m.
    alarms: Vec<f64>,
    /// Sets with nodes of each batch, with the place of the batch in their lists.
    of_batch: Vec<Vec<[u32; 2]>>,
}

impl TravelMonitor {
    /// Creates the monitor of sets of nodes that have travelled this far, m; they are allowed any travel.
    pub fn new<'a>(sets: impl Iterator<Item = &'a [NodeId]>, travel: &[f64]) -> Self {
        let (mut ranges, mut batches, mut of_batch) = (vec![], vec![], vec![vec![]; travel.len()]);
        for (set, nodes) in (0..).zip(sets) {
            let first = batches.len();
            let mut own: Vec<u32> = nodes.iter().map(|node| BatchTravel::batch_of(*node) as u32).collect();
            own.sort_unstable();
            own.dedup();
            batches.append(&mut own);
            (first..batches.len()).for_each(|at| of_batch[batches[at] as usize].push([set, at as u32]));
            ranges.push(first..batches.len());
        }
        Self {
            measured: batches.iter().map(|batch| travel[*batch as usize]).collect(),
            allowed: vec![f64::INFINITY; ranges.len()],
            alarms: vec![f64::INFINITY; travel.len()],
            ranges,
            batches,
            of_batch,
        }
    }

    /// Returns true if a set has used up its travel.
    #[inline]
    pub fn has_alarm(&self, travel: &[f64]) -> bool {
        self.alarms.iter().zip(travel).any(|(alarm, travel)| exceeds(*travel, *alarm))
    }

    /// Appends the sets that have used up their travel.
    pub fn append_due(&self, travel: &[f64], due: &mut Vec<u32>) {
        for (batch, travel) in
            travel.iter().enumerate().filter(|(batch, travel)| exceeds(**travel, self.alarms[*batch]))
        {
            let is_due = |at: &&[u32; 2]| exceeds(*travel, self.limit(**at));
            due.extend(self.of_batch[batch].iter().filter(is_due).map(|[set, _]| *set));
        }
    }

    /// Sets the alarms of the batches that have passed theirs.
    pub fn reset_alarms(&mut self, travel: &[f64]) {
        for (batch, travel) in travel.iter().enumerate() {
            if exceeds(*travel, self.alarms[batch]) {
                self.alarms[batch] =
                    self.of_batch[batch].iter().map(|at| self.limit(*at)).fold(f64::INFINITY, f64::min);
            }
        }
    }

    /// Returns the travel of a batch at which a set has used up what it is allowed, m.
    fn limit(&self, [set, at]: [u32; 2]) -> f64 {
        self.measured[at as usize] + self.allowed[set as usize]
    }

    /// Begins the travel of a measured set anew; it is allowed any travel until it is told otherwise.
    pub fn begin(&mut self, set: usize, travel: &[f64]) {
        for at in self.ranges[set].clone() {
            self.measured[at] = travel[self.batches[at] as usize];
        }
        self.allowed[set] = f64::INFINITY;
    }

    /// Returns the greatest travel of a node of a set since the set was measured, m.
    #[inline]
    pub fn since_measured(&self, set: usize, travel: &[f64]) -> f64 {
        let (range, mut most) = (self.ranges[set].clone(), 0.0_f64);
        for (batch, measured) in self.batches[range.clone()].iter().zip(&self.measured[range]) {
            most = most.max(travel[*batch as usize] - measured);
        }
        most
    }

    /// Limits the travel of a set since it was measured, m.
    #[inline]
    pub fn allow(&mut self, set: usize, travel: f64) {
        if travel < self.allowed[set] {
            self.allowed[set] = travel;
            for at in self.ranges[set].clone() {
                let alarm = &mut self.alarms[self.batches[at] as usize];
                *alarm = alarm.min(self.measured[at] + travel);
            }
        }
    }
}

/// Returns true if a travel exceeds a limit; what is not a number does.
#[inline]
fn exceeds(travel: f64, limit: f64) -> bool {
    let is_within = travel <= limit;
    !is_within
}
