//! Admissible states: what a state must fulfil to belong to a system, and to have been reached at a time.

use super::SteppingSchedule;
use super::system::DiscreteSystem;
use crate::fem::Potential;
use crate::state::{DynamicState, GroupClock, MOST_TICKS, StateSizes, Tick};

/// Checks that a state can belong to this engine.
///
/// # Errors
/// The contradiction found.
pub(super) fn check<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    state: &DynamicState<D>,
) -> Result<(), &'static str> {
    state.check_invariants(&StateSizes {
        nodes: system.model.gel.mass.len(),
        slots: system.model.layout.n_slots(),
        groups: system.model.layout.n_groups(),
        alarms: system.model.settings.schedule.n_alarms(system.model.layout.n_groups()),
        memories: system.model.gel.n_memories(),
        bodies: system.model.bodies.len(),
        born: state.birth.as_ref().map_or(0, |birth| birth.mesh.elements.len()),
        references: state.birth.as_ref().map_or(0, |birth| birth.references.len()),
        layered: state.birth.as_ref().map_or(0, |birth| birth.parts.len()),
    })?;
    if state.birth != system.state.birth {
        return Err("it belongs to another mesh");
    }
    if !system.model.bodies.iter().zip(&state.bodies).all(|(body, its)| body.is_admissible(its)) {
        return Err(
            "a body is off its plane or axis, its quaternion is not of norm 1, or its shape is not one of the body",
        );
    }
    let begun = state.birth.as_ref().map_or(0, |birth| birth.tick);
    let now = state.now.unwrap_or(begun);
    if begun > now || begun >= MOST_TICKS || state.record.synchronous.1 > now {
        return Err("its ticks are in no order");
    }
    let fits = |clock: &GroupClock| {
        system.model.settings.schedule != SteppingSchedule::Bins || clock.step == 0 || clock.step.is_power_of_two()
    };
    if state.clocks.iter().all(fits) { Ok(()) } else { Err("a step is none of the bins") }
}

/// Checks that a state can have reached time `t`, s: at most its longest step after its last tick, and so its
/// bodies.
///
/// # Errors
/// The contradiction found.
pub(super) fn check_time<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    state: &DynamicState<D>,
    t: f64,
) -> Result<(), &'static str> {
    let longest = state.clocks.iter().map(|clock| clock.step).fold(0, Tick::max).min(MOST_TICKS);
    let begun = state.birth.as_ref().map_or(0, |birth| birth.tick);
    // A gel at rest has no further ticks, at any time.
    let last = if state.record.at_rest { MOST_TICKS } else { state.now.unwrap_or(begun).min(MOST_TICKS) };
    let latest = system.model.grid.time(last + longest);
    let past = |time: f64| (0.0..=latest).contains(&time);
    if !past(t) || !state.bodies.iter().all(|body| past(body.time)) {
        return Err("its times and ticks contradict each other");
    }
    let numbers = system.model.bodies.iter().zip(&state.bodies).all(|(rigid, body)| body.at(rigid, t).is_valid());
    if numbers { Ok(()) } else { Err("a body moves beyond all numbers") }
}
