//! Forces of a tick: finds the active elements, evaluates them at their drifted nodes and finds those that fail.

use super::blocks::MIN_SHARED_ELEMENTS;
use super::element_loop::{ElementLoopInput, is_failure};
use super::node_loop::find_active_nodes;
use super::reference::{drift_group_nodes, evaluate_forces};
use super::system::DiscreteSystem;
use super::{StepError, SteppingSchedule};
use crate::fem::Potential;
use crate::mesh::ElementId;
use crate::state::Tick;

/// Evaluates the forces of the active elements at their drifted nodes, by blocks or by the reference form.
pub(super) fn evaluate_elements<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let moment = system.tick_context(tick);
    let Some(blocks) = &mut system.blocks else {
        find_active_groups(system, tick);
        set_trailing_weights(system, tick);
        drift_group_nodes(system, tick);
        return evaluate_forces(system, tick);
    };
    let input = ElementLoopInput {
        moment,
        grid: system.model.grid,
        position: &system.state.position,
        velocity: &system.state.velocity,
        rest: system.model.gel.potential.rest(),
        last: &system.clock.last_ticks,
        clocks: &system.state.clocks,
        order: &system.model.layout,
    };
    let n_elements = blocks.find_active(&input);
    let (stiffness, responses) = (system.state.stiffness.as_mut_slice(), system.workspace.responses.as_mut_slice());
    let pool = system.pool.as_deref().filter(|_| n_elements > MIN_SHARED_ELEMENTS);
    blocks.sweep(&input, stiffness, responses, pool);
    find_active_nodes(system);
}

/// Lists the active groups in ascending order (reference form).
fn find_active_groups<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let moment = system.tick_context(tick);
    let due = &mut system.workspace.active_groups;
    due.clear();
    if system.model.settings.schedule == SteppingSchedule::Queue && tick > 0 {
        system.clock.queue.pop_at(tick, due);
        return;
    }
    let active = system.state.clocks.iter().zip(0..).filter(|(clock, _)| moment.is_active(clock.step));
    due.extend(active.map(|(_, group)| group));
}

/// Sets the kick weight of each active group to the trailing half of its last step, s (reference form).
fn set_trailing_weights<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let trailing_half = system.workspace.active_groups.iter().map(|group| system.trailing_half(*group as usize, tick));
    let trailing_half: Vec<f64> = trailing_half.collect();
    system.workspace.kick_lengths.clear();
    system.workspace.kick_lengths.extend(trailing_half);
}

/// Fails if an element is inverted for the second tick in a row or its energy is not a number; only the drift has
/// taken place then. With remeshing an inverted element is tolerated: it ends its mesh as soon as the mesh may
/// end.
pub(super) fn check_elements<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    time: f64,
) -> Result<(), StepError> {
    match find_failure(system, time) {
        Some(StepError::Inverted { .. }) if system.can_be_distorted() => Ok(()),
        failure => failure.map_or(Ok(()), Err),
    }
}

/// Finds the failed element of this tick, if any.
pub(super) fn find_failure<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    time: f64,
) -> Option<StepError> {
    let fails = |group: &usize| is_failure(&system.state.clocks[*group], &system.workspace.responses[*group]);
    let failed = match &system.blocks {
        Some(blocks) => blocks.all.iter().filter_map(|block| block.report?.failed_group).max_by_key(|group| {
            // An energy that is not a number is reported before an inverted element.
            (!system.workspace.responses[*group].energy.is_finite(), std::cmp::Reverse(*group))
        }),
        None => system.workspace.active_groups.iter().map(|group| *group as usize).find(fails),
    };
    failed.map(|group| describe_failure(system, group, time))
}

/// Describes the failure of a group: which element, inverted or not finite.
fn describe_failure<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    group: usize,
    time: f64,
) -> StepError {
    let (response, clock) = (&system.workspace.responses[group], &system.state.clocks[group]);
    let first = system.model.layout.slots(group).start;
    let twice = response.inverted & clock.inverted;
    if response.energy.is_finite() {
        let slot = first + twice.trailing_zeros() as usize;
        let element = system.model.layout.element(slot).map_or(0, ElementId::index);
        return StepError::Inverted { element, time, jacobian: response.least_jacobian };
    }
    let element = system.model.layout.elements(system.model.layout.slots(group)).next().map_or(0, ElementId::index);
    StepError::NotFinite { element, time }
}

/// Adds the leading half of the next step to the kick weight of each active group, s (reference form).
pub(super) fn add_leading_weights<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    for i in 0..system.workspace.active_groups.len() {
        let ahead = system.model.grid.time(system.ahead(system.workspace.active_groups[i] as usize, tick));
        system.workspace.kick_lengths[i] += 0.5 * ahead;
    }
}
