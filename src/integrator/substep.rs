//! Where a tick is in the life of a mesh and of the steps on it: each mesh begins with half a kick and ends with one
//! (numerics A12).

use super::Kind;
use crate::state::Tick;

/// First tick of a mesh, last, or between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// Every group begins: its kick is that of half of the step ahead.
    First,
    /// Half of the step behind and half of that ahead.
    Between,
    /// Every group ends: positions and velocities are those of one instant then.
    Last,
}

/// A tick of a mesh; what lies behind and ahead of the groups that fire there. Of the bins: in a queue alarms say it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub tick: Tick,
    /// The first tick of the mesh.
    pub origin: Tick,
    pub kind: Kind,
    pub phase: Phase,
}

impl Moment {
    /// Whether a group of this step fires: where the mesh begins or ends, whatever its step is.
    #[inline]
    pub fn fires(&self, step: Tick) -> bool {
        self.phase != Phase::Between || self.kind.fires(step, self.tick)
    }

    /// From its own last tick until now, ticks: its step, or less where the mesh has begun in between.
    #[inline]
    pub fn ticks_since_last(&self, step: Tick) -> Tick {
        match self.kind {
            Kind::Bins if step > 0 => self.tick - self.last_own_tick(step),
            _ => step,
        }
    }

    /// The same, but nothing where it begins.
    #[inline]
    pub fn elapsed(&self, step: Tick) -> Tick {
        if self.phase == Phase::First { 0 } else { self.ticks_since_last(step) }
    }

    /// From now until its next own tick, ticks: its step, or less where it begins in between; nothing where it ends.
    #[inline]
    pub fn ahead(&self, step: Tick) -> Tick {
        match (self.phase, self.kind) {
            (Phase::Last, _) => 0,
            (_, Kind::Bins) if step > 0 => step - (self.tick & (step - 1)),
            _ => step,
        }
    }

    /// The length of the kick that a sweep takes, ticks: what is owed and half of the step ahead as it is planned; mended where it
    /// comes to be another one. A group that begins takes nothing before it has a step.
    #[inline]
    pub fn planned_kick(&self, step: Tick) -> f64 {
        if step == 0 { 0.0 } else { self.owed(step) + 0.5 * self.ahead(step) as f64 }
    }

    /// The part of a kick that belongs to the step behind, ticks: half of it. A group that ends had half of its planned step already.
    #[inline]
    pub fn owed(&self, step: Tick) -> f64 {
        match self.phase {
            Phase::First => 0.0,
            Phase::Between => 0.5 * self.ticks_since_last(step) as f64,
            Phase::Last => self.ticks_since_last(step) as f64 - 0.5 * self.planned_step(step) as f64,
        }
    }

    /// The part of a kick that belongs to the step ahead.
    pub fn leading_share(&self) -> f64 {
        match self.phase {
            Phase::First => 1.0,
            Phase::Between => 0.5,
            Phase::Last => 0.0,
        }
    }

    /// The last own tick before this one.
    fn last_own_tick(&self, step: Tick) -> Tick {
        ((self.tick - 1) & !(step - 1)).max(self.origin)
    }

    /// The step that was ahead then.
    fn planned_step(&self, step: Tick) -> Tick {
        match self.kind {
            Kind::Bins => step - (self.last_own_tick(step) & (step - 1)),
            _ => step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(tick: Tick, phase: Phase) -> Moment {
        Moment { tick, origin: 12, kind: Kind::Bins, phase }
    }

    #[test]
    fn steps_that_begin_and_end_in_between_are_short_and_kicks_add_up_to_the_time_that_passes() {
        // A mesh from 12 to 27; a group of 8 fires at 12, 16, 24 and 27.
        let first = at(12, Phase::First);
        assert_eq!((first.fires(8), first.ticks_since_last(0), first.ahead(8)), (true, 0, 4));
        assert_eq!((first.planned_kick(0), first.planned_kick(8)), (0.0, 2.0));
        let second = at(16, Phase::Between);
        assert_eq!((second.fires(8), second.ticks_since_last(8), second.ahead(8)), (true, 4, 8));
        let third = at(24, Phase::Between);
        assert_eq!((third.ticks_since_last(8), third.ahead(8)), (8, 8));
        let end = at(27, Phase::Last);
        assert!(end.fires(8) && !at(27, Phase::Between).fires(8));
        assert_eq!((end.ticks_since_last(8), end.ahead(8)), (3, 0));
        assert_eq!([&first, &second, &third, &end].map(|moment| moment.planned_kick(8)), [2.0, 6.0, 8.0, -1.0]);
        assert_eq!([&first, &second, &third, &end].map(|moment| moment.owed(8)), [0.0, 2.0, 4.0, -1.0]);
    }

    #[test]
    fn a_mesh_that_ends_in_its_first_steps_has_what_has_passed() {
        let (first, end) = (at(12, Phase::First), at(14, Phase::Last));
        assert_eq!(first.planned_kick(8) + end.planned_kick(8), 2.0);
    }
}
