//! Step size of a patch: the assembled nodal stability rule, hysteresis for longer steps, and limits by contact
//! (method 1.3, 1.4, A7, A8).

use super::step_limits::StepLimits;
use super::step_monitor::RAISE_MARGIN;
use super::substep::TickContext;
use super::workspace::{ContactLimit, StepChange};
use super::{StepError, SteppingSchedule};
use crate::contact::ContactDetection;
use crate::fem::{FORESEEN, GroupResponse, Potential};
use crate::state::{GroupAlarm, GroupClock, Tick};

/// Number of a group's own ticks in a row at which [`RAISE_MARGIN`] must hold. Raising sooner pumps energy:
/// per-update adaptation drifted by up to +18000 % in 400 wave transits, this rule by at most 1.2 % (method 1.4).
const RAISE_PATIENCE: u32 = 64;

/// Step phase: reads limits, responses and contact, and writes the clocks of the groups.
pub(super) struct StepPhase<'a, const D: usize, P> {
    pub limits: StepLimits<'a, D, P>,
    pub moment: TickContext,
    /// Active groups whose step may change, ascending.
    pub groups: &'a [u32],
    pub responses: &'a [GroupResponse],
    pub contact: &'a ContactDetection,
    pub contact_limits: &'a [ContactLimit],
    pub can_be_distorted: bool,
    /// Steps that the elements of a new mesh may not exceed at its first tick, s, if it is held to them.
    pub held_steps: Option<&'a [f64]>,
    pub clocks: &'a mut [GroupClock],
    pub alarms: &'a mut [GroupAlarm],
    pub changed_steps: &'a mut Vec<StepChange>,
}

impl<const D: usize, P: Potential<D>> StepPhase<'_, D, P> {
    /// Chooses the next tick of each of the groups, and lists the changed steps. Returns the first group whose stable
    /// step is less than a tick: that is a thousandth of the smallest at the start, and the mesh has failed (A11).
    pub fn set_clocks(self) -> Option<StepError> {
        let (mut collapsed, moment) = (None, self.moment);
        self.changed_steps.clear();
        for group in self.groups {
            let (i, was) = (*group as usize, self.clocks[*group as usize]);
            let limit = self.limits.of_group(i);
            if limit < 1.0 && collapsed.is_none() {
                collapsed = Some(self.limits.collapse_error(i, limit, &self.responses[i], moment.tick));
            }
            let limit = limit.min(self.time_to_inversion(i, &was)).min(self.held_step(i, &was));
            let (step, calm) = apply_hysteresis(limit.max(1.0), &was, &moment);
            let (step, is_near) = self.limit_by_contact(i, step);
            (self.clocks[i].step, self.clocks[i].calm) = (step, if is_near { 0 } else { calm });
            if step != was.step {
                let (planned, ahead) = (moment.ahead(was.step), moment.ahead(step));
                self.changed_steps.push(StepChange { group: *group, planned, ahead });
            }
            if moment.kind == SteppingSchedule::Queue {
                // In the queue, patches near contact wait for the common multiples of their steps, so that they are
                // active together.
                let next = if is_near { (moment.tick / step + 1) * step } else { moment.tick + step };
                self.alarms[i] = GroupAlarm { last: moment.tick, next };
            }
        }
        if moment.kind == SteppingSchedule::Global {
            self.equalise_steps();
        }
        collapsed
    }

    /// Returns the time until an element of a group inverts at its present rate, ticks; infinite beyond the
    /// look-ahead.
    fn time_to_inversion(&self, group: usize, clock: &GroupClock) -> f64 {
        let time = self.limits.model.grid.ticks(1.0 / self.responses[group].closing);
        let look_ahead = FORESEEN * self.moment.elapsed(clock.step) as f64;
        let is_foreseen = self.can_be_distorted && (clock.step == 0 || time < look_ahead);
        if is_foreseen { time } else { f64::INFINITY }
    }

    /// Returns the step that a group of a new mesh may not exceed at its first tick, ticks: where a mesh is remade often
    /// and a little at a time, steps that rose with each mesh would pump energy.
    fn held_step(&self, group: usize, clock: &GroupClock) -> f64 {
        let Some(steps) = self.held_steps.filter(|_| clock.step == 0) else { return f64::INFINITY };
        let (layout, grid) = (&self.limits.model.layout, self.limits.model.grid);
        let steps = layout.elements(layout.slots(group)).map(|element| steps[element.index()]);
        grid.ticks(steps.fold(f64::INFINITY, f64::min))
    }

    /// Limits a step by contact: no surface node may sink too deep into a body, and patches within an element's size of
    /// a body take the shortest step around. Also returns true if the patch is that near.
    fn limit_by_contact(&self, group: usize, step: Tick) -> (Tick, bool) {
        let (gel, layout, schedule) = (&self.limits.model.gel, &self.limits.model.layout, self.moment.kind);
        let mut limit = step as f64;
        let mut is_near = false;
        let elements = layout.elements(layout.slots(group));
        for node in elements.flat_map(|element| gel.potential.nodes(element)) {
            let Some(surface) = gel.surface.of[node.index()] else { continue };
            let Some(index) = self.contact.index_of(surface) else { continue };
            let nearness = &self.contact_limits[index];
            limit = limit.min(nearness.limit);
            is_near |= nearness.is_near;
        }
        let limit = limit.max(1.0);
        let kind = if is_near && schedule == SteppingSchedule::Queue { SteppingSchedule::Bins } else { schedule };
        (if is_near || limit < step as f64 { kind.step(limit) } else { step }, is_near)
    }

    /// Sets all steps to the least one, for the global schedule.
    fn equalise_steps(self) {
        let Self { moment: TickContext { tick, .. }, clocks, alarms, changed_steps, .. } = self;
        if let Some(StepChange { planned, .. }) = changed_steps.first().copied() {
            let ahead = clocks.iter().map(|clock| clock.step).filter(|step| *step > 0).min().unwrap_or(1);
            for clock in &mut *clocks {
                clock.step = ahead;
            }
            changed_steps.clear();
            let all = 0..clocks.len() as u32;
            changed_steps.extend(all.map(|group| StepChange { group, planned, ahead }));
        }
        alarms[0] = GroupAlarm { last: tick, next: tick + clocks[0].step };
    }
}

/// Returns the step and the hold count of a group: shortened at once, doubled only when aligned and after a long
/// hold.
fn apply_hysteresis(limit: f64, clock: &GroupClock, moment: &TickContext) -> (Tick, u32) {
    let allowed = moment.kind.step(limit);
    if clock.step == 0 || allowed < clock.step {
        return (allowed, 0);
    }
    if limit < RAISE_MARGIN * clock.step as f64 || moment.kind == SteppingSchedule::Global {
        return (clock.step, 0);
    }
    let calm = clock.calm.saturating_add(1);
    let is_aligned = moment.kind == SteppingSchedule::Queue || moment.tick.is_multiple_of(2 * clock.step);
    if calm >= RAISE_PATIENCE && is_aligned { (2 * clock.step, 0) } else { (clock.step, calm) }
}
