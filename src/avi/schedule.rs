//! Which patches fire when: derived from the clocks of the state, never stored with it.

use crate::mesh::ElementId;
use crate::state::{Clock, Tick};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Steps that a schedule allows, and how a clock keeps them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Powers of two of the tick, on multiples of themselves: patches of a step fire together.
    Bins,
    /// The paper's priority queue: whole ticks, each patch its own step. Equal ticks form one event.
    Queue,
}

impl Kind {
    /// The longest allowed step, ticks, that is no longer than `limit` ≥ 1.
    #[must_use]
    pub fn step(self, limit: f64) -> Tick {
        match self {
            Self::Bins => super::grid::floor_power_of_two(limit) as Tick,
            Self::Queue => limit as Tick,
        }
    }
}

/// The events to come.
#[derive(Debug, Clone)]
pub enum Calendar {
    /// Per level m the patches of level ≤ m, ascending: at tick T those of level trailing_zeros(T) fire.
    Bins(Vec<Vec<ElementId>>),
    /// By tick, then by patch.
    Queue(BinaryHeap<Reverse<(Tick, ElementId)>>, Vec<ElementId>),
}

/// Levels of the bins: steps up to 2⁴⁷ ticks.
const LEVELS: usize = 48;

fn level(clock: &Clock) -> usize {
    (clock.step.trailing_zeros() as usize).min(LEVELS - 1)
}

impl Calendar {
    /// The events of these clocks.
    #[must_use]
    pub fn new(kind: Kind, clocks: &[Clock]) -> Self {
        let patches = (0..clocks.len()).map(|i| ElementId(i as u32));
        match kind {
            Kind::Bins => {
                let mut levels = vec![vec![]; LEVELS];
                for patch in patches {
                    levels[level(&clocks[patch.index()])..].iter_mut().for_each(|list| list.push(patch));
                }
                Self::Bins(levels)
            }
            Kind::Queue => {
                let events = patches.map(|patch| Reverse((clocks[patch.index()].next, patch))).collect();
                Self::Queue(events, vec![])
            }
        }
    }

    /// The first tick after `now` at which a patch fires.
    #[must_use]
    pub fn next(&self, now: Tick) -> Option<Tick> {
        match self {
            Self::Bins(levels) => {
                let finest = levels.iter().position(|list| !list.is_empty())?;
                Some(((now >> finest) + 1) << finest)
            }
            Self::Queue(events, _) => events.peek().map(|Reverse((tick, _))| *tick),
        }
    }

    /// Takes out the patches that fire at `tick`, ascending.
    pub fn take(&mut self, tick: Tick) -> &[ElementId] {
        match self {
            Self::Bins(levels) => &levels[(tick.trailing_zeros() as usize).min(LEVELS - 1)],
            Self::Queue(events, due) => {
                due.clear();
                while events.peek().is_some_and(|Reverse((at, _))| *at == tick) {
                    due.extend(events.pop().map(|Reverse((_, patch))| patch));
                }
                due
            }
        }
    }

    /// Puts a patch that has fired back in, after its clock was set.
    pub fn put_back(&mut self, patch: ElementId, was: &Clock, now: &Clock) {
        match self {
            Self::Bins(levels) => {
                let (from, to) = (level(was), level(now));
                for list in levels.iter_mut().take(from).skip(to) {
                    let at = list.partition_point(|other| *other < patch);
                    list.insert(at, patch);
                }
                for list in levels.iter_mut().take(to).skip(from) {
                    list.remove(list.partition_point(|other| *other < patch));
                }
            }
            Self::Queue(events, _) => events.push(Reverse((now.next, patch))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(step: Tick, next: Tick) -> Clock {
        Clock { next, step, ..Clock::default() }
    }

    #[test]
    fn bins_fire_each_patch_on_the_multiples_of_its_step() {
        let mut clocks = [clock(4, 4), clock(1, 1), clock(2, 2)];
        let mut calendar = Calendar::new(Kind::Bins, &clocks);
        let ids = |list: &[ElementId]| list.iter().map(|p| p.0).collect::<Vec<_>>();
        assert_eq!(calendar.next(0), Some(1));
        assert_eq!(ids(calendar.take(1)), [1]);
        assert_eq!(ids(calendar.take(2)), [1, 2]);
        assert_eq!(ids(calendar.take(4)), [0, 1, 2]);
        let was = clocks[1];
        clocks[1] = clock(4, 8);
        calendar.put_back(ElementId(1), &was, &clocks[1]);
        assert_eq!(calendar.next(4), Some(6));
        assert_eq!(ids(calendar.take(6)), [2]);
        let rebuilt = Calendar::new(Kind::Bins, &clocks);
        assert_eq!(format!("{calendar:?}"), format!("{rebuilt:?}"));
    }

    #[test]
    fn equal_ticks_of_the_queue_are_one_event_in_ascending_order() {
        let clocks = [clock(5, 5), clock(3, 3), clock(5, 5)];
        let mut calendar = Calendar::new(Kind::Queue, &clocks);
        assert_eq!(calendar.next(0), Some(3));
        assert_eq!(calendar.take(3).to_vec(), [ElementId(1)]);
        assert_eq!(calendar.next(3), Some(5));
        assert_eq!(calendar.take(5).to_vec(), [ElementId(0), ElementId(2)]);
    }

    #[test]
    fn steps_are_the_longest_allowed_ones() {
        assert_eq!((Kind::Bins.step(13.7), Kind::Queue.step(13.7)), (8, 13));
        assert_eq!((Kind::Bins.step(1.0), Kind::Queue.step(1.0)), (1, 1));
    }
}
