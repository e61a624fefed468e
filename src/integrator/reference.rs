//! Reference form of a tick: one element after the other, each kick by itself.
//!
//! It handles the queue, the contact law of the paper and potentials without SIMD layout. Tests compare the SIMD
//! form with it.

use super::SteppingSchedule;
use super::contact_phase::{apply_reversal, correct_gel_contacts, solve};
use super::damping::{apply_damping, post_damping_work};
use super::kick_sums::{ConstraintReaction, KickSums, decay};
use super::load::apply_pressures;
use super::self_contact_phase::rebase_passive_nodes;
use super::stability::nodal_limit;
use super::substep::MeshPhase;
use super::system::DiscreteSystem;
use crate::contact::ImpulseLaw;
use crate::fem::{DEPTH, ElementResponse, GroupKick, GroupResponse, Potential};
use crate::math::embed;
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Drifts the nodes of the active groups.
pub(super) fn drift_group_nodes<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    system.workspace.active_nodes.clear();
    for group in &system.workspace.active_groups {
        for element in system.model.layout.elements(system.model.layout.slots(*group as usize)) {
            system
                .model
                .gel
                .potential
                .nodes(element)
                .iter()
                .for_each(|node| system.workspace.active_nodes.insert(node.index()));
        }
    }
    for a in system.workspace.active_nodes.reference_nodes().iter().map(|a| *a as usize) {
        let velocity = system.state.velocity[a];
        let passed = system.model.grid.time(tick - system.clock.last_ticks[a]);
        system.state.position[a] += velocity * passed;
        if system.model.settings.damping > 0.0 {
            system.workspace.decay[a] = decay(system.model.settings.damping, passed);
        }
        system.clock.last_ticks[a] = tick;
        system.workspace.velocities_before[a] = velocity;
    }
}

/// Evaluates the forces of the active groups.
pub(super) fn evaluate_forces<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let mut responses = std::mem::take(&mut system.workspace.element_responses);
    responses.elements.clear();
    responses.groups.clear();
    for i in 0..system.workspace.active_groups.len() {
        let (group, first) = (system.workspace.active_groups[i] as usize, responses.elements.len());
        system.workspace.responses[group] =
            evaluate_group(system, group, group_kick(system, i, tick), &mut responses.elements);
        responses.groups.push(first..responses.elements.len());
        for (element, response) in &responses.elements[first..] {
            system.state.stiffness[system.model.layout.slot(*element)] = response.stiffness;
        }
    }
    system.workspace.element_responses = responses;
}

/// Returns the kick of the i-th active group as far as it is known: without its leading half.
fn group_kick<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, i: usize, tick: Tick) -> GroupKick {
    let group = system.workspace.active_groups[i] as usize;
    let elapsed = match system.model.settings.schedule {
        SteppingSchedule::Queue if system.clock.phase == MeshPhase::First => 0,
        SteppingSchedule::Queue => tick - system.state.alarms[group].last,
        SteppingSchedule::Bins | SteppingSchedule::Global => {
            system.tick_context(tick).elapsed(system.state.clocks[group].step)
        }
    };
    GroupKick { length: system.workspace.kick_lengths[i], elapsed: system.model.grid.time(elapsed) }
}

/// Evaluates a group for a kick at the current positions. Appends the responses to `elements` and posts the dissipation
/// to the ledger.
pub(super) fn evaluate_group<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    group: usize,
    kick: GroupKick,
    elements: &mut Vec<(ElementId, ElementResponse<D>)>,
) -> GroupResponse {
    let mut sum = GroupResponse { least_jacobian: f64::INFINITY, ..GroupResponse::default() };
    for patch in system.model.layout.patches(group) {
        let mut responses = [ElementResponse::default(); DEPTH];
        let (x, memory) = (&system.state.position, &mut system.state.memory);
        let dissipation = system.model.gel.potential.advance(*patch as usize, x, kick, memory, &mut responses);
        sum.energy += dissipation.energy;
        system.state.ledger.energy.book_dissipation(&dissipation);
        for (element, response) in system.model.gel.potential.patches().of(*patch as usize).iter().zip(&responses) {
            let lane = system.model.layout.slot(*element) % system.model.layout.width();
            sum.least_jacobian = sum.least_jacobian.min(response.jacobian);
            sum.inverted |= u32::from(response.jacobian <= 0.0) << lane;
            sum.crushed += u32::from(system.model.gel.potential.is_crushed(response.jacobian));
            let nodes = system.model.gel.potential.nodes(*element).iter();
            let power = nodes.zip(&response.forces).map(|(node, f)| f.dot(&system.state.velocity[node.index()]));
            sum.power += power.sum::<f64>();
            let now = (system.state.position.as_slice(), system.state.velocity.as_slice());
            sum.closing = sum.closing.max(system.model.gel.potential.closing(*element, response.jacobian, now));
            elements.push((*element, *response));
        }
    }
    sum
}

/// Finds the stable limits of the active nodes and the least of them.
pub(super) fn measure_limits<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) -> KickSums {
    let mut sums = KickSums::default();
    for a in system.workspace.active_nodes.reference_nodes() {
        let limit = system.model.settings.cfl
            * nodal_limit(&system.model.gel, &system.state.stiffness, &system.model.layout, NodeId(*a));
        system.workspace.node_limits[*a as usize] = limit;
        sums.limit = sums.limit.min(limit);
    }
    sums
}

/// Applies all kicks, then the contact solve; or, by the contact law of the paper, the reversal after each kick.
pub(super) fn kick_and_solve_contact<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, tick: Tick) {
    let responses = std::mem::take(&mut system.workspace.element_responses);
    for (i, elements) in responses.groups.iter().enumerate() {
        for (element, response) in &responses.elements[elements.clone()] {
            kick_element(system, *element, response, system.workspace.kick_lengths[i]);
            if system.model.settings.law == ImpulseLaw::Reversal {
                apply_reversal(system, *element);
            }
        }
    }
    system.workspace.element_responses = responses;
    apply_damping(system);
    apply_pressures(system, tick);
    match system.model.settings.law {
        ImpulseLaw::Moreau { restitution, friction, .. } => solve(system, restitution, friction),
        ImpulseLaw::Reversal => correct_gel_contacts(system),
    }
    rebase_passive_nodes(system, tick);
}

/// Kicks the nodes of an element in the free directions, v_a += w f_a/m_a, and posts the reaction of the held
/// ones.
fn kick_element<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    element: ElementId,
    response: &ElementResponse<D>,
    weight: f64,
) {
    let (gel, freedom) = (&system.model.gel, system.freedom());
    let mut reaction = ConstraintReaction::default();
    for (node, force) in gel.potential.nodes(element).iter().zip(&response.forces) {
        let (a, push) = (node.index(), force * weight);
        system.state.velocity[a] += push.component_mul(&gel.free(a)) / gel.mass[a];
        reaction.add(&gel.free(a), freedom, embed(&system.state.position[a]), embed(&push));
    }
    reaction.post(&mut system.state.ledger);
}

/// Returns Σ w f·(v⁻ + v⁺)/2 − Σ ΔQ with the velocities before and after the whole tick, J: the work of the
/// kicks less the change of the carried kick work.
pub(super) fn kick_work<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) -> f64 {
    post_damping_work(system);
    let (responses, share) = (&system.workspace.element_responses, system.leading_share());
    let mut work: f64 =
        system.workspace.active_nodes.reference_nodes().iter().map(|a| system.state.excess[*a as usize]).sum();
    system.workspace.active_nodes.reference_nodes().iter().for_each(|a| system.state.excess[*a as usize] = 0.0);
    for (elements, weight) in responses.groups.iter().zip(&system.workspace.kick_lengths) {
        for (element, response) in &responses.elements[elements.clone()] {
            for (node, force) in system.model.gel.potential.nodes(*element).iter().zip(&response.forces) {
                let (before, after) =
                    (system.workspace.velocities_before[node.index()], system.state.velocity[node.index()]);
                let excess = share * weight * force.dot(&(after - before));
                system.state.excess[node.index()] += excess;
                work += 0.5 * weight * force.dot(&(before + after)) - excess;
            }
        }
    }
    work
}
