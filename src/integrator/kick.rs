//! Kicks of a tick and their entries in the ledger (numerics 1.2, A6).

use super::DiscreteGel;
use super::blocks::ElementBlocks;
use super::damping::damping_impulse;
use super::energy_residual::update_clock;
use super::history_rows::reevaluate_group;
use super::kick_sums::{ConstraintReaction, KickSums};
use super::load::{apply_pressures, loaded_nodes, post_load_work};
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use super::workspace::{ImpulseNode, PassiveNode, StepChange};
use crate::contact::{ContactPoint, ContactProblem, ImpulseLaw, SelfContact};
use crate::fem::{ElementResponse, Potential};
use crate::math::{Vector, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Completes the kicks of the SIMD form, applies the pressures and solves contact; returns Σ p·(v⁻ + v⁺)/2 − Σ
/// ΔQ, J.
pub(super) fn complete_simd_kicks<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    tick: Tick,
    sums: &KickSums,
) -> f64 {
    sums.reaction.post(&mut system.state.ledger);
    let time = system.model.grid.time(tick);
    sums.damping.post(&mut system.state.ledger, &mut system.state.record.outside, time);
    note_speeds(system);
    let correction = if system.clock.phase == MeshPhase::First { 0.0 } else { correct_kicks(system) };
    find_impulse_nodes(system);
    apply_pressures(system, tick);
    if let ImpulseLaw::Moreau { restitution, friction, .. } = system.model.settings.law {
        solve(system, restitution, friction);
    }
    rebase_passive_nodes(system, tick);
    sums.work + correction + account_for_impulses(system, tick)
}

/// Corrects the kicks of groups whose step changed: the sweep took half of the planned step; adds half of the
/// difference to the chosen one.
fn correct_kicks<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) -> f64 {
    let mut responses = std::mem::take(&mut system.workspace.element_responses.elements);
    let mut work = 0.0;
    for i in 0..system.workspace.changed_steps.len() {
        let StepChange { group, planned, ahead } = system.workspace.changed_steps[i];
        let contributes = |blocks: &ElementBlocks<D>| blocks.monitors[group as usize / blocks.groups].contributes;
        if !system.blocks.as_ref().is_some_and(contributes) {
            continue;
        }
        let change = ahead as f64 - planned as f64;
        responses.clear();
        reevaluate_group(system, group as usize, &mut responses);
        separate_power(system, group as usize, &responses);
        for (element, response) in &responses {
            work += correct_element_kick(system, *element, response, 0.5 * change * system.model.grid.time(1));
        }
    }
    system.workspace.element_responses.elements = responses;
    work
}

/// Takes the power of a group out of the sum of its block, because its next step differs from that of the other
/// groups.
fn separate_power<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    group: usize,
    elements: &[(ElementId, ElementResponse<D>)],
) {
    let Some(mut blocks) = system.blocks.take() else { return };
    let block = group / blocks.groups;
    let end = blocks.groups_of(block).end;
    if let Some(power_accumulator) = &mut blocks.all[block].power_accumulator {
        let of_node = |(node, f): (&NodeId, &Vector<D>)| f.dot(&system.workspace.velocities_before[node.index()]);
        let element_power = |(element, response): &(ElementId, ElementResponse<D>)| -> f64 {
            system.model.gel.potential.nodes(*element).iter().zip(&response.forces).map(of_node).sum()
        };
        let power = elements.iter().map(element_power).sum();
        let rest = system.workspace.responses[*power_accumulator].power - power;
        // Groups come in ascending order: where the first one leaves, the next one accumulates the rest.
        *power_accumulator += usize::from(*power_accumulator == group);
        system.workspace.responses[group].power = power;
        system.workspace.responses[*power_accumulator..end]
            .iter_mut()
            .take(1)
            .for_each(|response| response.power = rest);
    }
    system.blocks = Some(blocks);
}

/// Adds a kick of an element to those of the tick; returns the additional work less the change of the carried
/// kick work, J.
fn correct_element_kick<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    element: ElementId,
    response: &ElementResponse<D>,
    weight: f64,
) -> f64 {
    let (gel, mut reaction, mut work) = (system.model.gel.clone(), ConstraintReaction::default(), 0.0);
    for (node, force) in gel.potential.nodes(element).iter().zip(&response.forces) {
        let (a, push) = (node.index(), force * weight);
        let kicked = system.state.velocity[a];
        system.state.velocity[a] += push.component_mul(&gel.free(a)) / gel.mass[a];
        let (first, both) = (
            kicked - system.workspace.velocities_before[a],
            system.state.velocity[a] - system.workspace.velocities_before[a],
        );
        // The impulse p = m Δ does the work p·v⁻ + p·Δ/2, and Q is half of p·Δ, because no kick is corrected in
        // the first or last tick of a mesh. The work of damping in it is not the element's.
        let damped = damping_impulse(system, a).dot(&(both - first));
        system.state.ledger.energy.damping += 0.5 * damped;
        let more = gel.mass[a] * (both.norm_squared() - first.norm_squared()) - damped;
        system.state.excess[a] += 0.5 * more;
        work += gel.mass[a] * (both - first).dot(&system.workspace.velocities_before[a]);
        reaction.add(&gel.free(a), system.freedom(), embed(&system.state.position[a]), embed(&push));
        system.note_speed(a);
    }
    reaction.post(&mut system.state.ledger);
    work
}

/// Records the speeds of the active nodes in the neighbour list: by chunks where the SIMD form has gone through
/// all of them.
pub(super) fn note_speeds<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (active, speeds) =
        (&system.workspace.active_nodes, system.workspace.chunk_sums.iter().map(|sums| sums.max_speed_squared.sqrt()));
    system.contact.neighbours.note_speeds(active.all, speeds);
    // The reference form has no chunks.
    let listed =
        if system.blocks.is_none() { active.reference_nodes() } else { active.listed_nodes().unwrap_or_default() };
    for node in listed.iter().map(|node| *node as usize) {
        let speed = system.state.velocity[node].norm();
        system.contact.neighbours.note_speed(node, speed);
        system.batch_travel.note_speed(node, speed);
    }
}

/// Finds the nodes with impulses of contact, symmetry planes or pressures, and their velocities before these. Nodes that
/// self-contact strikes between their ticks are not among them.
fn find_impulse_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let mut impulse_nodes = std::mem::take(&mut system.workspace.impulse_nodes);
    impulse_nodes.clear();
    let symmetric = system.workspace.symmetry_contacts.iter().map(|contact| contact.node);
    let active = &system.workspace.active_nodes;
    let own = system.workspace.self_contacts.iter().flat_map(SelfContact::carriers).map(|(node, _)| node);
    let own = own.filter(|node| active.has(node.index()));
    for node in system
        .workspace
        .contact_points
        .iter()
        .flat_map(ContactPoint::nodes)
        .copied()
        .chain(symmetric)
        .chain(own)
        .chain(loaded_nodes(system))
    {
        let (before, kicked) = (system.velocity_before(node), system.state.velocity[node.index()]);
        impulse_nodes.push(ImpulseNode { node, before, kicked });
    }
    impulse_nodes.sort_unstable_by_key(|impulse_node| impulse_node.node);
    impulse_nodes.dedup_by_key(|impulse_node| impulse_node.node);
    system.workspace.impulse_nodes = impulse_nodes;
}

/// Accounts for the change of velocity by pressures and contact after the kicks. Returns their additional work,
/// Σ p·(v⁺ − v)/2 with p = m (v − v⁻) without the damping, less the change of Q, J.
fn account_for_impulses<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> f64 {
    let mut work = 0.0;
    for i in 0..system.workspace.impulse_nodes.len() {
        let ImpulseNode { node, before, kicked } = system.workspace.impulse_nodes[i];
        let a = node.index();
        let (drag, change) = (damping_impulse(system, a), system.state.velocity[a] - kicked);
        let more = ((kicked - before) * system.model.gel.mass[a] - drag).dot(&change);
        system.state.ledger.energy.damping += 0.5 * drag.dot(&change);
        system.state.excess[a] += system.leading_share() * more;
        work += (0.5 - system.leading_share()) * more;
        system.clock.last_ticks[a] = tick;
        system.note_speed(a);
    }
    work
}

/// Posts the integration residual of the active groups, Σ ΔV + Σ A of the last tick + W − Σ A of this one,
/// where A is the leading-half work. It is zero for the exact motion and of second order in the step.
pub(super) fn post_residual<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick, work: f64) {
    let residual =
        if system.blocks.is_some() { update_block_clocks(system, tick) } else { update_group_clocks(system, tick) };
    system.state.ledger.energy.integration += residual + work;
    post_load_work(system);
}

/// Updates the clocks of the active groups (reference form); returns the residual, J.
fn update_group_clocks<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> f64 {
    let mut residual = 0.0;
    for group in system.workspace.active_groups.iter().map(|group| *group as usize) {
        let ahead = system.ahead(group, tick);
        let (clock, response) = (&mut system.state.clocks[group], &system.workspace.responses[group]);
        residual += update_clock(clock, response, system.model.grid.time(ahead));
        system.state.record.min_jacobian = system.state.record.min_jacobian.min(response.least_jacobian);
        system.state.record.updates += system.model.layout.elements(system.model.layout.slots(group)).count() as u64;
    }
    residual
}

/// Updates the clocks and step ranges of the active blocks; returns the residual, J.
fn update_block_clocks<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) -> f64 {
    let Some(mut blocks) = system.blocks.take() else { return 0.0 };
    let (moment, groups_per_block) = (system.tick_context(tick), blocks.groups);
    let (clocks, responses) = (&mut system.state.clocks, &system.workspace.responses);
    let (residual, dissipation) = blocks.update_clocks(system.model.grid, moment, clocks, responses);
    system.state.ledger.energy.book_dissipation(&dissipation);
    let record = &mut system.state.record;
    for report in blocks.all.iter().filter_map(|block| block.report) {
        record.updates += report.updates;
        record.min_jacobian = record.min_jacobian.min(report.least_jacobian);
    }
    let block_of = |change: &StepChange| change.group as usize / groups_per_block;
    for changed in system.workspace.changed_steps.chunk_by(|a, b| block_of(a) == block_of(b)) {
        let block = block_of(&changed[0]);
        blocks.update_steps(block, &system.state.clocks, system.model.grid);
        blocks.all[block].may_raise_step = true;
    }
    system.blocks = Some(blocks);
    residual
}

/// Moves the passive nodes that the contacts have struck onto the paths that lead through their places at this tick with
/// their new velocities: the state holds each node as it is at its last tick.
pub(super) fn rebase_passive_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    for i in 0..system.workspace.passive_nodes.len() {
        let PassiveNode { node, before, last } = system.workspace.passive_nodes[i];
        let (a, passed) = (node.index(), system.model.grid.time(tick - last));
        let change = system.state.velocity[a] - before;
        if change != Vector::<D>::zeros() {
            system.state.position[a] -= change * passed;
            system.clock.last_ticks[a] = last;
            system.note_speed(a);
        }
    }
}

/// Returns the contact problem of this tick.
fn contact_problem<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
) -> ContactProblem<'_, D, DiscreteGel<D, P>> {
    let DiscreteSystem { model, state, workspace, .. } = system;
    ContactProblem {
        masses: &*model.gel,
        velocity: &mut state.velocity,
        bodies: &model.bodies,
        was: &workspace.bodies_before,
        now: &mut workspace.bodies_after,
        points: &mut workspace.contact_points,
        symmetry: &mut workspace.symmetry_contacts,
        own: &mut workspace.self_contacts,
    }
}

/// Solves Moreau's law with Coulomb friction at all contact points and symmetry contacts.
pub(super) fn solve<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    restitution: f64,
    friction: f64,
) {
    let approaches = system.state.record.contacts.iter().map(|contact| contact.approach);
    let greatest_approach = approaches.fold(0.0, f64::max);
    contact_problem(system).solve(restitution, friction, greatest_approach);
}

/// Applies the paper's reversal law to the nodes of one element after its kick.
pub(super) fn apply_reversal<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, element: ElementId) {
    let gel = system.model.gel.clone();
    contact_problem(system).reverse(gel.potential.nodes(element));
}

/// Corrects the impulses of the gel with its images and with itself once.
pub(super) fn correct_gel_contacts<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    contact_problem(system).correct_gel_contacts();
}
