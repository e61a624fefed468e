//! Substep of a mesh: the place of a tick in the life of the mesh and in the steps of its groups. Each mesh begins
//! with half a kick and ends with half a kick (method A12).

use super::SteppingSchedule;
use crate::state::{GroupAlarm, GroupClock, Tick};

/// Phase of a mesh at a tick: first, last or between.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MeshPhase {
    /// Every group begins: its kick is the leading half of the next step.
    First,
    /// Each kick is the trailing half of the last step plus the leading half of the next one.
    Between,
    /// Every group ends: positions and velocities hold at one instant.
    Last,
}

/// Context of a tick of a mesh; it tells the last and next ticks of active groups. Valid for bins; a queue uses its
/// alarms.
#[derive(Debug, Clone, Copy)]
pub(super) struct TickContext {
    pub tick: Tick,
    /// First tick of the mesh.
    pub origin: Tick,
    pub kind: SteppingSchedule,
    pub phase: MeshPhase,
}

impl TickContext {
    /// Returns true if a group with this step is active; every group is at the first and last tick of the mesh.
    #[inline]
    pub fn is_active(&self, step: Tick) -> bool {
        self.phase != MeshPhase::Between || self.kind.is_active(step, self.tick)
    }

    /// Returns the ticks since the group's last own tick: its step, or less where the mesh began in between.
    #[inline]
    pub fn ticks_since_last(&self, step: Tick) -> Tick {
        match self.kind {
            SteppingSchedule::Bins if step > 0 => self.tick - self.last_own_tick(step),
            _ => step,
        }
    }

    /// Returns the ticks that the group has advanced since its last tick: 0 at the first tick of the mesh.
    #[inline]
    pub fn elapsed(&self, step: Tick) -> Tick {
        if self.phase == MeshPhase::First { 0 } else { self.ticks_since_last(step) }
    }

    /// Returns the ticks until the group's next own tick: its step, less where the mesh begins in between, 0 where
    /// it ends.
    #[inline]
    pub fn ahead(&self, step: Tick) -> Tick {
        match (self.phase, self.kind) {
            (MeshPhase::Last, _) => 0,
            (_, SteppingSchedule::Bins) if step > 0 => step - (self.tick & (step - 1)),
            _ => step,
        }
    }

    /// Returns the length of the kick of a sweep, ticks: the trailing half and the leading half of the planned next
    /// step. The kick is corrected where the step changes. A group without a step takes no kick yet.
    #[inline]
    pub fn planned_kick(&self, step: Tick) -> f64 {
        if step == 0 { 0.0 } else { self.trailing_half(step) + 0.5 * self.ahead(step) as f64 }
    }

    /// Returns the trailing half of a kick, ticks: half of the last step. A group at the last tick of its mesh has
    /// taken half of its planned step already.
    #[inline]
    pub fn trailing_half(&self, step: Tick) -> f64 {
        match self.phase {
            MeshPhase::First => 0.0,
            MeshPhase::Between => 0.5 * self.ticks_since_last(step) as f64,
            MeshPhase::Last => self.ticks_since_last(step) as f64 - 0.5 * self.planned_step(step) as f64,
        }
    }

    /// Returns the fraction of a kick that belongs to the next step.
    pub fn leading_share(&self) -> f64 {
        match self.phase {
            MeshPhase::First => 1.0,
            MeshPhase::Between => 0.5,
            MeshPhase::Last => 0.0,
        }
    }

    /// Returns the group's last own tick before this one.
    fn last_own_tick(&self, step: Tick) -> Tick {
        ((self.tick - 1) & !(step - 1)).max(self.origin)
    }

    /// Returns the step that was planned at the last own tick.
    fn planned_step(&self, step: Tick) -> Tick {
        match self.kind {
            SteppingSchedule::Bins => step - (self.last_own_tick(step) & (step - 1)),
            _ => step,
        }
    }
}

/// Ticks of the groups around a tick: by the steps of their clocks, in the queue by their alarms.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroupTicks<'a> {
    pub moment: TickContext,
    pub clocks: &'a [GroupClock],
    pub alarms: &'a [GroupAlarm],
}

impl GroupTicks<'_> {
    /// Returns the ticks that an active group has advanced since its last tick; called before the clocks are set.
    pub fn elapsed(&self, group: usize) -> Tick {
        match self.moment.kind {
            SteppingSchedule::Queue if self.moment.phase == MeshPhase::First => 0,
            SteppingSchedule::Queue => self.moment.tick - self.alarms[group].last,
            SteppingSchedule::Bins | SteppingSchedule::Global => self.moment.elapsed(self.clocks[group].step),
        }
    }

    /// Returns the trailing half of the kick of an active group, which belongs to the step behind, ticks; called before
    /// the clocks are set.
    pub fn trailing_half(&self, group: usize) -> f64 {
        match self.moment.kind {
            SteppingSchedule::Queue => 0.5 * (self.moment.tick - self.alarms[group].last) as f64,
            SteppingSchedule::Bins | SteppingSchedule::Global => self.moment.trailing_half(self.clocks[group].step),
        }
    }

    /// Returns the ticks from this tick until a group that is active now is active again.
    pub fn ahead(&self, group: usize) -> Tick {
        match self.moment.kind {
            SteppingSchedule::Queue => self.alarms[group].next - self.moment.tick,
            SteppingSchedule::Bins | SteppingSchedule::Global => self.moment.ahead(self.clocks[group].step),
        }
    }

    /// Returns true if a group was active at this tick; valid after the clocks were set.
    pub fn was_active(&self, group: usize) -> bool {
        match self.moment.kind {
            SteppingSchedule::Queue => self.alarms[group].last == self.moment.tick,
            _ => self.moment.is_active(self.clocks[group].step),
        }
    }

    /// Returns the last tick of a group, up to this one; valid after the clocks were set.
    pub fn last(&self, group: usize) -> Tick {
        match self.moment.kind {
            SteppingSchedule::Bins => self.moment.tick & !self.clocks[group].step.saturating_sub(1),
            SteppingSchedule::Queue => self.alarms[group].last,
            SteppingSchedule::Global => self.moment.tick,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(tick: Tick, phase: MeshPhase) -> TickContext {
        TickContext { tick, origin: 12, kind: SteppingSchedule::Bins, phase }
    }

    #[test]
    fn kicks_of_shortened_steps_add_up_to_the_elapsed_time() {
        // A mesh from 12 to 27; a group of 8 is active at 12, 16, 24 and 27.
        let first = at(12, MeshPhase::First);
        assert_eq!((first.is_active(8), first.ticks_since_last(0), first.ahead(8)), (true, 0, 4));
        assert_eq!((first.planned_kick(0), first.planned_kick(8)), (0.0, 2.0));
        let second = at(16, MeshPhase::Between);
        assert_eq!((second.is_active(8), second.ticks_since_last(8), second.ahead(8)), (true, 4, 8));
        let third = at(24, MeshPhase::Between);
        assert_eq!((third.ticks_since_last(8), third.ahead(8)), (8, 8));
        let end = at(27, MeshPhase::Last);
        assert!(end.is_active(8) && !at(27, MeshPhase::Between).is_active(8));
        assert_eq!((end.ticks_since_last(8), end.ahead(8)), (3, 0));
        assert_eq!([&first, &second, &third, &end].map(|moment| moment.planned_kick(8)), [2.0, 6.0, 8.0, -1.0]);
        assert_eq!([&first, &second, &third, &end].map(|moment| moment.trailing_half(8)), [0.0, 2.0, 4.0, -1.0]);
    }

    #[test]
    fn kicks_of_a_mesh_that_ends_in_its_first_step_add_up_to_the_elapsed_time() {
        let (first, end) = (at(12, MeshPhase::First), at(14, MeshPhase::Last));
        assert_eq!(first.planned_kick(8) + end.planned_kick(8), 2.0);
    }
}
