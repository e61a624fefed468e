//! Monitor of travel: it tells when the nodes of a set have travelled as far as the set is allowed since it was measured.

use crate::math::SUM_BLOCK;
use crate::mesh::NodeId;
use std::ops::Range;

/// Monitor of the travel of sets of nodes. The travel of a node is bounded by that of its run.
#[derive(Debug)]
pub(super) struct TravelMonitor {
    /// Range of each set in the lists of its runs.
    ranges: Vec<Range<usize>>,
    /// Runs of each set.
    runs: Vec<u32>,
    /// Travel of each run of each set when the set was measured, m.
    measured: Vec<f64>,
    /// Travel since that each set is allowed, m.
    allowed: Vec<f64>,
    /// Travel of each run at which a set has used up what it is allowed, m.
    alarms: Vec<f64>,
    /// Sets with nodes of each run, with the place of the run in their lists.
    of_run: Vec<Vec<[u32; 2]>>,
}

impl TravelMonitor {
    /// Creates the monitor of sets of nodes that have travelled this far, m; they are allowed any travel.
    pub fn new<I: Iterator<Item = NodeId>>(sets: impl Iterator<Item = I>, travel: &[f64]) -> Self {
        let (mut ranges, mut runs, mut of_run) = (vec![], vec![], vec![vec![]; travel.len()]);
        for (set, nodes) in (0..).zip(sets) {
            let first = runs.len();
            let mut own: Vec<u32> = nodes.map(|node| (node.index() / SUM_BLOCK) as u32).collect();
            own.sort_unstable();
            own.dedup();
            runs.append(&mut own);
            (first..runs.len()).for_each(|at| of_run[runs[at] as usize].push([set, at as u32]));
            ranges.push(first..runs.len());
        }
        Self {
            measured: runs.iter().map(|run| travel[*run as usize]).collect(),
            allowed: vec![f64::INFINITY; ranges.len()],
            alarms: vec![f64::INFINITY; travel.len()],
            ranges,
            runs,
            of_run,
        }
    }

    /// Returns true if a set has used up its travel.
    #[inline]
    pub fn has_alarm(&self, travel: &[f64]) -> bool {
        self.alarms.iter().zip(travel).any(|(alarm, travel)| exceeds(*travel, *alarm))
    }

    /// Appends the sets that have used up their travel.
    pub fn append_due(&self, travel: &[f64], due: &mut Vec<u32>) {
        for (run, travel) in travel.iter().enumerate().filter(|(run, travel)| exceeds(**travel, self.alarms[*run])) {
            let is_due = |at: &&[u32; 2]| exceeds(*travel, self.limit(**at));
            due.extend(self.of_run[run].iter().filter(is_due).map(|[set, _]| *set));
        }
    }

    /// Sets the alarms of the runs that have passed theirs.
    pub fn reset_alarms(&mut self, travel: &[f64]) {
        for (run, travel) in travel.iter().enumerate() {
            if exceeds(*travel, self.alarms[run]) {
                self.alarms[run] = self.of_run[run].iter().map(|at| self.limit(*at)).fold(f64::INFINITY, f64::min);
            }
        }
    }

    /// Returns the travel of a run at which a set has used up what it is allowed, m.
    fn limit(&self, [set, at]: [u32; 2]) -> f64 {
        self.measured[at as usize] + self.allowed[set as usize]
    }

    /// Begins the travel of a measured set anew; it is allowed any travel until it is told otherwise.
    pub fn begin(&mut self, set: usize, travel: &[f64]) {
        for at in self.ranges[set].clone() {
            self.measured[at] = travel[self.runs[at] as usize];
        }
        self.allowed[set] = f64::INFINITY;
    }

    /// Returns the greatest travel of a node of a set since the set was measured, m.
    #[inline]
    pub fn since_measured(&self, set: usize, travel: &[f64]) -> f64 {
        let range = self.ranges[set].clone();
        let since = |(run, measured): (&u32, &f64)| travel[*run as usize] - measured;
        self.runs[range.clone()].iter().zip(&self.measured[range]).map(since).fold(0.0, f64::max)
    }

    /// Limits the travel of a set since it was measured, m.
    #[inline]
    pub fn allow(&mut self, set: usize, travel: f64) {
        if travel < self.allowed[set] {
            self.allowed[set] = travel;
            for at in self.ranges[set].clone() {
                let alarm = &mut self.alarms[self.runs[at] as usize];
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
