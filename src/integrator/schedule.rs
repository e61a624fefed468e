//! Schedules of the groups: derived from the clocks of the state, never stored with it.

use crate::state::{GroupAlarm, Tick};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Schedule: the steps that groups may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SteppingSchedule {
    /// Power-of-two bins: steps of 2ⁿ ticks at multiples of themselves, so that patches of one step are active
    /// together.
    Bins,
    /// Priority queue of the AVI paper: each patch has its own step of whole ticks. Equal ticks form one event.
    Queue,
    /// One global step for all patches, that of the assembled system; the reference for the gain of asynchrony.
    Global,
}

impl SteppingSchedule {
    /// Returns the longest allowed step, ticks, that does not exceed `limit` ≥ 1.
    #[must_use]
    pub fn step(self, limit: f64) -> Tick {
        match self {
            Self::Bins => super::grid::floor_power_of_two(limit) as Tick,
            Self::Queue | Self::Global => limit as Tick,
        }
    }

    /// Returns the number of alarms for a number of groups: one each in a queue, one for a global step.
    #[must_use]
    pub(super) fn n_alarms(self, n_groups: usize) -> usize {
        match self {
            Self::Bins => 0,
            Self::Queue => n_groups,
            Self::Global => 1,
        }
    }

    /// Returns true if a group with this step is active at a tick of the schedule; a queue uses its alarms instead.
    /// A group without a step is active.
    #[must_use]
    #[inline]
    pub fn is_active(self, step: Tick, tick: Tick) -> bool {
        match self {
            Self::Bins => step == 0 || tick & (step - 1) == 0,
            Self::Queue | Self::Global => true,
        }
    }
}

/// Event queue, ordered by tick, then by group.
#[derive(Debug, Clone, Default)]
pub(super) struct EventQueue(BinaryHeap<Reverse<(Tick, u32)>>);

impl EventQueue {
    /// Builds the queue of these alarms.
    pub fn new(alarms: &[GroupAlarm]) -> Self {
        Self(alarms.iter().zip(0..).map(|(alarm, group)| Reverse((alarm.next, group))).collect())
    }

    /// Returns the first tick.
    pub fn next_tick(&self) -> Option<Tick> {
        self.0.peek().map(|Reverse((tick, _))| *tick)
    }

    /// Removes the groups that are active at `tick`, ascending.
    pub fn pop_at(&mut self, tick: Tick, due: &mut Vec<u32>) {
        while self.next_tick() == Some(tick) {
            due.extend(self.0.pop().map(|Reverse((_, group))| group));
        }
    }

    /// Inserts a group.
    pub fn push(&mut self, group: u32, next: Tick) {
        self.0.push(Reverse((next, group)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_active_at_the_multiples_of_their_step() {
        let active = |step| (1..=8).filter(|tick| SteppingSchedule::Bins.is_active(step, *tick)).collect::<Vec<Tick>>();
        assert_eq!((active(1).len(), active(2), active(4)), (8, vec![2, 4, 6, 8], vec![4, 8]));
    }

    #[test]
    fn equal_ticks_of_the_queue_are_one_event_in_ascending_order() {
        let mut queue = EventQueue::new(&[5, 3, 5].map(|next| GroupAlarm { last: 0, next }));
        let mut due = vec![];
        assert_eq!(queue.next_tick(), Some(3));
        queue.pop_at(3, &mut due);
        assert_eq!((due.as_slice(), queue.next_tick()), (&[1][..], Some(5)));
        due.clear();
        queue.push(1, 5);
        queue.pop_at(5, &mut due);
        assert_eq!((due.as_slice(), queue.next_tick()), (&[0, 1, 2][..], None));
    }

    #[test]
    fn steps_are_the_longest_allowed_ones() {
        assert_eq!(
            (
                SteppingSchedule::Bins.step(13.7),
                SteppingSchedule::Queue.step(13.7),
                SteppingSchedule::Global.step(13.7)
            ),
            (8, 13, 13)
        );
        assert_eq!((SteppingSchedule::Bins.step(1.0), SteppingSchedule::Queue.step(1.0)), (1, 1));
    }
}
