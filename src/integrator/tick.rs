//! One tick of the integrator: drift, forces, kick, step sizes, contact, energy balance (method 1.6).
//!
//! A group, patches of elements that share one step Δt, is active at its own ticks (AVI, Lew et al. 2003). With the
//! leapfrog (Störmer–Verlet) scheme a tick at time t moves each node a of an active group from its last tick t_a and
//! kicks it:
//!
//!   x_a ← x_a + v_a (t − t_a),   f = −∂V/∂x of the active elements,   v_a ← v_a + ½ (Δt_old + Δt_new) f_a/m_a.
//!
//! Velocities hold between ticks. The trailing half of the kick, with Δt_old, belongs to the step that ends, the leading
//! half, with Δt_new, to the step that begins: a step may change at a tick, because each half takes the forces there.
//! Elements of groups that are not active add no force; a node that they share with an active group moves with it.
//!
//! Elements are evaluated in blocks of SIMD batches. The reference form, which tests compare with the blocks, evaluates
//! one element after the other; it also runs the event queue and the contact law of the paper.

use super::bodies::place_bodies;
use super::derived::update_step_range;
use super::kick::KickCorrection;
use super::kick_sums::KickSums;
use super::mesh_end::finest_groups;
use super::orientation::check_spin;
use super::reference::measure_limits;
use super::report::synchronous_until;
use super::stretch_limit::SurfaceStretches;
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use super::{StepError, SteppingSchedule};
use crate::contact::ImpulseExchange;
use crate::fem::Potential;
use crate::state::Tick;

/// Processes one tick, phase by phase: drift and forces, kick, step sizes, contact, energy balance.
///
/// The step sizes follow the kick, because the stable limit of a node is summed in the same pass as its forces. The
/// leading half of the kick takes the planned step; where the step changes, the contact phase first corrects it.
///
/// Impulses on the bodies are added to their `exchanges` with the caller, whose interval ends at time `end`, s.
pub(super) fn process_tick<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    end: f64,
    exchanges: &mut [ImpulseExchange],
) -> Result<(), StepError> {
    drift_and_evaluate(system, tick)?;
    let sums = kick_by_planned_steps(system, tick);
    let collapsed = choose_steps(system, tick, &sums);
    let work = kick_and_resolve_contact(system, tick, &sums);
    balance_energy(system, tick, work);
    system.contact_accounts().post_body_impulses(end, exchanges);
    requeue_groups(system);
    check_tick(system, collapsed)
}

/// Drift and forces: evaluates the active elements with their nodes drifted to this tick; then finds the pressure loads
/// and the bodies at this time. The reference form stores the drifted positions at once. The blocks drift their copies of
/// the nodes, and the positions are stored with the kick, or here if an element has failed.
fn drift_and_evaluate<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
) -> Result<(), StepError> {
    let time = system.model.grid.time(tick);
    evaluate_elements(system, tick);
    match system.element_results().find_failure(time) {
        // An inverted element ends its mesh as soon as the mesh may end.
        Some(StepError::Inverted { .. }) if system.can_be_distorted() => {}
        Some(error) => {
            drift_active(system, tick);
            return Err(error);
        }
        None => {}
    }
    find_loads(system, tick);
    place_bodies(&mut system.workspace, &system.model.bodies, &system.state.bodies, time);
    Ok(())
}

/// Evaluates the forces of the active elements at their drifted nodes, by blocks or by the reference form.
fn evaluate_elements<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    match system.element_phase(tick) {
        Some(phase) => phase.evaluate(),
        None => system.reference_elements(tick).evaluate(),
    }
}

/// Finds the pressure loads and adds their stiffness to the elements behind them.
fn find_loads<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    system.load_phase(tick).find_loads();
    system.loaded_elements().add_load_stiffness();
}

/// Drifts the active nodes without a kick, where a tick ends with its forces.
fn drift_active<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let active = &system.workspace.active_nodes;
    for (node, last) in system.clock.last_ticks.iter_mut().enumerate().filter(|(node, _)| active.has(*node)) {
        let passed = system.model.grid.time(tick - *last);
        system.state.position[node] += system.state.velocity[node] * passed;
        *last = tick;
    }
}

/// Kick: trailing half of the step that ends and leading half of the planned next step, in the pass that also finds the
/// stable limits of the nodes. The reference form finds the limits alone and kicks when the steps are known.
fn kick_by_planned_steps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> KickSums {
    if system.model.gel.meets_itself {
        system.batch_travel.go_on(system.model.grid.time(tick));
    }
    update_nodes(system, tick)
}

/// Updates the active nodes by blocks; in the reference form it only finds their stable limits.
fn update_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> KickSums {
    if let Some(phase) = system.node_phase(tick) {
        return phase.update();
    }
    let (model, workspace) = (&system.model, &mut system.workspace);
    measure_limits(model, &system.state.stiffness, &workspace.active_nodes, &mut workspace.node_limits)
}

/// Step sizes: sets the next step of each active group from the stable limits and the contact gaps; returns the error of
/// the first group whose stable step is shorter than a tick. Also counts what one global step would have cost.
fn choose_steps<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    sums: &KickSums,
) -> Option<StepError> {
    count_global_steps(system, sums.limit, tick);
    system.gap_phase().query_gaps();
    if let Some(check) = system.step_check(tick) {
        check.find_groups();
    }
    system.step_phase(tick).set_clocks()
}

/// Updates the cost of one global stable step up to `tick`: its length is the smallest nodal limit, s, so far.
fn count_global_steps<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, limit: f64, tick: Tick) {
    let (limit, reference) = (system.model.grid.ticks(limit), &mut system.state.record.synchronous);
    if limit < reference.0 {
        *reference = (limit, tick, synchronous_until(*reference, tick as f64, system.model.gel.potential.len()));
    }
}

/// Contact: finds the contact points, completes the kick for the chosen steps and applies the contact impulses;
/// returns the work of the kicks less the change of the carried kick work Q (method A6), in joules.
fn kick_and_resolve_contact<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    sums: &KickSums,
) -> f64 {
    system.contact_phase(tick).find_contact_points();
    system.self_contact_phase(tick).find_self_contacts();
    complete_kicks(system, tick, sums)
}

/// Energy balance: posts the integration residual of the active groups and the work of loads and contact to the
/// ledger.
fn balance_energy<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick, work: f64) {
    system.balance_phase(tick).post(work);
    system.contact_accounts().post_work();
}

/// Checks the result of a tick: collapsed steps, bodies that spin too fast, and contact surfaces stretched so far that a
/// body leaks through. A leak ends the mesh at the next tick, or the run at once if there is no remeshing.
fn check_tick<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    collapsed: Option<StepError>,
) -> Result<(), StepError> {
    match collapsed {
        // The mesh ends at the next tick, and a remesh resolves it, as it does inverted elements.
        Some(StepError::StepCollapsed { .. }) if system.can_be_distorted() => {}
        Some(error) => return Err(error),
        None => {}
    }
    let mut bodies = system.workspace.bodies_after.iter().enumerate();
    bodies.try_for_each(|(body, at)| check_spin(&system.model, body, at))?;
    let SurfaceStretches { stretch, leak } = system.stretch_check().find_stretch();
    system.state.record.stretch = stretch;
    leak.filter(|_| !system.can_be_distorted()).map_or(Ok(()), Err)
}

/// Completes the kicks of a tick and solves contact, by blocks or by the reference form; returns the work of the kicks
/// less the change of Q, the part of a kick's work that belongs to the step ahead, in joules.
fn complete_kicks<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    sums: &KickSums,
) -> f64 {
    if system.blocks.is_none() {
        return system.reference_kicks(tick).apply();
    }
    let is_first = system.clock.phase == MeshPhase::First;
    let sums = if is_first { take_first_kick(system, tick) } else { *sums };
    let (time, state) = (system.model.grid.time(tick), &mut system.state);
    sums.post(&mut state.ledger, &mut state.record.outside, time);
    let correction = system.kick_correction().map_or(0.0, KickCorrection::correct);
    sums.work + correction + system.impulse_phase(tick).apply()
}

/// Takes the first kick of a mesh: the first sweep has found the steps, a second one kicks by half of each.
fn take_first_kick<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> KickSums {
    evaluate_elements(system, tick);
    system.loaded_elements().add_load_stiffness();
    update_nodes(system, tick)
}

/// Returns the active groups to the event queue and updates the range of steps if steps changed.
fn requeue_groups<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    if system.model.settings.schedule == SteppingSchedule::Queue {
        for group in &system.workspace.active_groups {
            system.clock.queue.push(*group, system.state.alarms[*group as usize].next);
        }
    }
    if !system.workspace.changed_steps.is_empty() {
        update_step_range(system);
    }
}

/// Processes the last tick of this mesh, at which every group ends its step with the trailing half of its kick, so that
/// positions and velocities hold at one instant. No step is chosen.
///
/// Contact at [`MeshPhase::Last`] stops the nodes on a body: with half a kick they would enter it, gain that energy, and
/// lose it in contact at the next tick. Failures that another mesh can resolve are kept for the remeshing.
pub(super) fn process_last_tick<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    end: f64,
    exchanges: &mut [ImpulseExchange],
) -> Result<(), StepError> {
    let time = system.model.grid.time(tick);
    system.clock.phase = MeshPhase::Last;
    evaluate_elements(system, tick);
    system.clock.failure = system.element_results().find_failure(time);
    if let Some(error @ StepError::NotFinite { .. }) = &system.clock.failure {
        let error = error.clone();
        drift_active(system, tick);
        system.state.now = Some(tick);
        return Err(error);
    }
    find_loads(system, tick);
    place_bodies(&mut system.workspace, &system.model.bodies, &system.state.bodies, time);
    system.workspace.changed_steps.clear();
    let sums = kick_by_planned_steps(system, tick);
    count_global_steps(system, sums.limit, tick);
    system.clock.failure = system.clock.failure.take().or_else(|| find_collapse(system, tick));
    system.gap_phase().query_gaps();
    let work = kick_and_resolve_contact(system, tick, &sums);
    balance_energy(system, tick, work);
    system.contact_accounts().post_body_impulses(end, exchanges);
    system.clock.failure = system.clock.failure.take().or_else(|| system.stretch_check().find_stretch().leak);
    let (reference, n_elements) = (system.state.record.synchronous, system.model.gel.potential.len());
    system.state.record.synchronous.1 = tick;
    system.state.record.synchronous.2 = synchronous_until(reference, tick as f64, n_elements);
    system.state.now = Some(tick);
    Ok(())
}

/// Finds the first group whose stable step is shorter than a tick, if another mesh can follow.
fn find_collapse<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, tick: Tick) -> Option<StepError> {
    let groups = finest_groups(system.clock.step_range.0, &system.state.clocks);
    let collapsed = system.step_limits().find_collapse(groups, &system.workspace.responses, tick);
    collapsed.filter(|_| system.can_be_distorted())
}
