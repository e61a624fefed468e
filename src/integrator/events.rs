//! Events in their order: ticks of elements, steps of orientations, the end of a mesh, the exit of bodies.

use super::blocks::ElementBlocks;
use super::bodies::place_bodies;
use super::mesh_end::{is_over, next_remesh_tick};
use super::orientation::{check_spin, next_orientation_step};
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use super::tick::{process_last_tick, process_tick};
use super::{StepError, SteppingSchedule};
use crate::contact::{ImpulseExchange, STRETCH};
use crate::fem::Potential;
use crate::state::Tick;

/// Reason why the engine has stopped advancing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdvanceOutcome {
    /// The requested end time is reached.
    End,
    /// The mesh was distorted or due and has ended at a tick: positions and velocities are those of this instant.
    MeshEnded,
}

/// Returns true if a group is active at some tick up to time `t`, s.
pub(super) fn has_tick_until<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, t: f64) -> bool {
    let next = system.state.now.map_or(Some(system.clock.origin), |now| next_tick(system, now));
    next.is_some_and(|next| next <= system.model.grid.last_tick(t))
}

/// Processes all events up to time `until`, s, or until the mesh ends. The exchanges end at time `t`, s.
pub(super) fn process_ticks<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    until: f64,
    t: f64,
    exchanges: &mut [ImpulseExchange],
) -> Result<AdvanceOutcome, StepError> {
    let end = system.model.grid.last_tick(until);
    if system.is_at_rest() {
        return advance_bodies(system, end);
    }
    while let Some(tick) = next_event(system, end).filter(|tick| *tick <= end) {
        step_orientations(system, tick)?;
        let due = is_due(system, tick);
        if due && is_over(system, tick) {
            process_last_tick(system, tick, t, exchanges)?;
            return Ok(AdvanceOutcome::MeshEnded);
        }
        system.clock.phase = if system.state.now.is_none() { MeshPhase::First } else { MeshPhase::Between };
        let done = if due { process_tick(system, tick, t, exchanges) } else { Ok(()) };
        system.state.now = Some(tick);
        done?;
        if due && find_exits(system) {
            return advance_bodies(system, end);
        }
    }
    // Skipped ticks count as processed.
    if let (Some(now), SteppingSchedule::Bins) = (system.state.now, system.model.settings.schedule) {
        system.state.now = Some(now.max(end / system.clock.step_range.0 * system.clock.step_range.0));
    }
    Ok(AdvanceOutcome::End)
}

/// Advances the orientation of every body whose orientation step ends at this tick.
fn step_orientations<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
) -> Result<(), StepError> {
    for body in 0..system.model.bodies.len() {
        if next_orientation_step(&system.model, &system.state, body) == Some(tick) {
            system.rebase_body(body, system.model.grid.time(tick));
            check_spin(&system.model, body, &system.state.bodies[body])?;
        }
    }
    Ok(())
}

/// Returns the next tick at which a group is active or an orientation is stepped.
fn next_event<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, end: Tick) -> Option<Tick> {
    let elements = match system.state.now {
        None => Some(system.clock.origin),
        Some(now) => {
            let from = skip_quiet_ticks(system, now, end);
            next_tick(system, from)
        }
    };
    let turns =
        (0..system.model.bodies.len()).filter_map(|body| next_orientation_step(&system.model, &system.state, body));
    elements.into_iter().chain(turns).min()
}

/// Returns the next tick at which a group is active.
fn next_tick<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, now: Tick) -> Option<Tick> {
    match system.model.settings.schedule {
        SteppingSchedule::Bins => Some((now / system.clock.step_range.0 + 1) * system.clock.step_range.0),
        SteppingSchedule::Global => system.state.alarms.first().map(|alarm| alarm.next),
        SteppingSchedule::Queue => system.clock.queue.next_tick(),
    }
}

/// Returns true if groups are active at an event; the other events are orientation steps of bodies.
fn is_due<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, tick: Tick) -> bool {
    match system.model.settings.schedule {
        _ if system.state.now.is_none() => true,
        SteppingSchedule::Bins => tick.is_multiple_of(system.clock.step_range.0),
        SteppingSchedule::Queue | SteppingSchedule::Global => next_tick(system, tick) == Some(tick),
    }
}

/// Returns the tick after which the next one is searched: `now`, or later while the gel is at rest and no body can
/// come near. Ticks in between change nothing and are skipped.
fn skip_quiet_ticks<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, now: Tick, end: Tick) -> Tick {
    if system.model.settings.schedule != SteppingSchedule::Bins
        || system.is_loaded()
        || !system.blocks.as_ref().is_some_and(ElementBlocks::are_still)
    {
        system.clock.quiet_until = None;
        return now;
    }
    if !system.contact.knows_bodies {
        place_bodies_in_list(system);
    }
    let quiet_until = system.clock.quiet_until.unwrap_or_else(|| {
        let reach = system.contact.neighbours.reach(&system.model.bodies, system.horizon() * system.model.grid.time(1));
        let within = |i: usize| STRETCH * system.model.gel.surface.nodes[i].size + reach;
        system.model.grid.last_tick(
            system.contact.neighbours.time() + system.contact.neighbours.quiet_time(&system.model.bodies, within),
        )
    });
    system.clock.quiet_until = Some(quiet_until);
    if quiet_until <= now {
        system.clock.quiet_until = None;
    }
    // A scheduled remesh takes place also while the gel is at rest.
    let last = next_remesh_tick(system).map_or(end, |due| end.min(due.saturating_sub(1)));
    now.max(quiet_until.min(last))
}

/// Moves the bodies of the neighbour list to their last event.
fn place_bodies_in_list<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let events = system.state.bodies.iter().map(|body| body.time);
    let time = events.fold(system.contact.neighbours.time(), f64::max);
    place_bodies(&mut system.workspace, &system.model.bodies, &system.state.bodies, time);
    system.contact.follow_bodies(time, &system.workspace.bodies_before);
}

/// Finds the bodies that have left at this tick; returns true if the gel is put to rest with it.
fn find_exits<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) -> bool {
    let Some(rule) = system.clock.ends.exits else { return false };
    for body in 0..system.model.bodies.len() {
        let exit = system.body_exit(body, &system.workspace.bodies_after[body]).after_tick(&rule);
        system.state.record.contacts[body].exit = exit;
    }
    let (exit, after) = (system.state.record.contacts[0].exit, &system.workspace.bodies_after);
    let is_over = exit.is_some_and(|exit| after[0].time - exit.time >= rule.rest_after);
    let all_away = || after.iter().enumerate().all(|(body, at)| system.body_exit(body, at).is_away());
    system.state.record.at_rest = is_over && all_away();
    system.state.record.at_rest
}

/// Moves the bodies beside a gel at rest up to a tick: only the orientation steps of tumbling bodies remain.
fn advance_bodies<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    end: Tick,
) -> Result<AdvanceOutcome, StepError> {
    let next = |system: &DiscreteSystem<D, P>| {
        let turns = (0..system.model.bodies.len())
            .filter_map(|body| Some((next_orientation_step(&system.model, &system.state, body)?, body)));
        turns.min().filter(|(tick, _)| *tick <= end)
    };
    while let Some((tick, body)) = next(system) {
        system.rebase_body(body, system.model.grid.time(tick));
        check_spin(&system.model, body, &system.state.bodies[body])?;
    }
    Ok(AdvanceOutcome::End)
}
