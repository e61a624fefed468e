//! Which groups fire when: derived from the clocks of the state, never stored with it.

use crate::state::{Alarm, Tick};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Steps that a schedule allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Powers of two of the tick, on multiples of themselves: patches of a step fire together.
    Bins,
    /// The paper's priority queue: whole ticks, each patch its own step. Equal ticks form one event.
    Queue,
    /// One stable step for all, that of the assembled system: what asynchrony is measured against.
    Global,
}

impl Kind {
    /// The longest allowed step, ticks, that is no longer than `limit` ≥ 1.
    #[must_use]
    pub fn step(self, limit: f64) -> Tick {
        match self {
            Self::Bins => super::grid::floor_power_of_two(limit) as Tick,
            Self::Queue | Self::Global => limit as Tick,
        }
    }

    /// How many alarms so many groups have: each its own in a queue, one for all of one step.
    #[must_use]
    pub(super) fn n_alarms(self, n_groups: usize) -> usize {
        match self {
            Self::Bins => 0,
            Self::Queue => n_groups,
            Self::Global => 1,
        }
    }

    /// Whether a group of this step fires at this tick, which is one of the schedule's; a queue looks at its alarms. One that has
    /// no step yet fires.
    #[must_use]
    #[inline]
    pub fn fires(self, step: Tick, tick: Tick) -> bool {
        match self {
            Self::Bins => step == 0 || tick & (step - 1) == 0,
            Self::Queue | Self::Global => true,
        }
    }
}

/// The events of a queue, by tick, then by group.
#[derive(Debug, Clone, Default)]
pub(super) struct EventQueue(BinaryHeap<Reverse<(Tick, u32)>>);

impl EventQueue {
    /// The events of these alarms.
    pub fn new(alarms: &[Alarm]) -> Self {
        Self(alarms.iter().zip(0..).map(|(alarm, group)| Reverse((alarm.next, group))).collect())
    }

    /// The first tick.
    pub fn next_tick(&self) -> Option<Tick> {
        self.0.peek().map(|Reverse((tick, _))| *tick)
    }

    /// Takes out the groups that fire at `tick`, ascending.
    pub fn pop_at(&mut self, tick: Tick, due: &mut Vec<u32>) {
        while self.next_tick() == Some(tick) {
            due.extend(self.0.pop().map(|Reverse((_, group))| group));
        }
    }

    /// Puts a group in.
    pub fn push(&mut self, group: u32, next: Tick) {
        self.0.push(Reverse((next, group)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_fire_on_the_multiples_of_their_step() {
        let fire = |step| (1..=8).filter(|tick| Kind::Bins.fires(step, *tick)).collect::<Vec<Tick>>();
        assert_eq!((fire(1).len(), fire(2), fire(4)), (8, vec![2, 4, 6, 8], vec![4, 8]));
    }

    #[test]
    fn equal_ticks_of_the_queue_are_one_event_in_ascending_order() {
        let mut queue = EventQueue::new(&[5, 3, 5].map(|next| Alarm { last: 0, next }));
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
        assert_eq!((Kind::Bins.step(13.7), Kind::Queue.step(13.7), Kind::Global.step(13.7)), (8, 13, 13));
        assert_eq!((Kind::Bins.step(1.0), Kind::Queue.step(1.0)), (1, 1));
    }
}
