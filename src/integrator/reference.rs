//! Reference form of a tick: one element after the other, each kick by itself.
//!
//! It handles the queue, the contact law of the paper and potentials without SIMD layout. Tests compare the SIMD
//! form with it.

use super::SteppingSchedule;
use super::active_set::ActiveSet;
use super::impulse_phase::ImpulsePhase;
use super::kick_sums::{ConstraintReaction, DampingLoss, KickSums, decay};
use super::model::DiscreteModel;
use super::schedule::EventQueue;
use super::stability::nodal_limit;
use super::substep::GroupTicks;
use super::workspace::GroupResponses;
use crate::contact::ImpulseLaw;
use crate::fem::{DEPTH, ElementResponse, GroupKick, GroupResponse, HistoryVariables, Potential};
use crate::ledger::EnergyAccounts;
use crate::math::{Vector, embed};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

/// Element phase of the reference form: drifts the nodes of the active groups and evaluates their elements.
pub(super) struct ReferenceElements<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub ticks: GroupTicks<'a>,
    pub queue: &'a mut EventQueue,
    pub active_groups: &'a mut Vec<u32>,
    pub active_nodes: &'a mut ActiveSet,
    /// Kick lengths of the active groups, s.
    pub kick_lengths: &'a mut Vec<f64>,
    pub position: &'a mut [Vector<D>],
    pub velocity: &'a [Vector<D>],
    pub last_ticks: &'a mut [Tick],
    /// Velocities of the active nodes at the start of the tick, m/s, and their relative change by damping.
    pub before: &'a mut [Vector<D>],
    pub decay: &'a mut [f64],
    pub stiffness: &'a mut [f64],
    pub memory: &'a mut [HistoryVariables<D>],
    pub energy: &'a mut EnergyAccounts,
    pub responses: &'a mut [GroupResponse],
    pub element_responses: &'a mut GroupResponses<D>,
}

impl<const D: usize, P: Potential<D>> ReferenceElements<'_, D, P> {
    /// Evaluates the forces of the active elements at their drifted nodes.
    pub fn evaluate(mut self) {
        self.find_active_groups();
        self.drift_nodes();
        self.evaluate_groups();
    }

    /// Lists the active groups in ascending order, and the trailing halves of their last steps.
    fn find_active_groups(&mut self) {
        let Self { ticks, active_groups: due, kick_lengths, .. } = self;
        due.clear();
        if ticks.moment.kind == SteppingSchedule::Queue && ticks.moment.tick > 0 {
            self.queue.pop_at(ticks.moment.tick, due);
        } else {
            let active = ticks.clocks.iter().zip(0..).filter(|(clock, _)| ticks.moment.is_active(clock.step));
            due.extend(active.map(|(_, group)| group));
        }
        let grid = self.model.grid;
        kick_lengths.clear();
        kick_lengths.extend(due.iter().map(|group| grid.length(ticks.trailing_half(*group as usize))));
    }

    /// Drifts the nodes of the active groups.
    fn drift_nodes(&mut self) {
        let DiscreteModel { gel, layout, grid, settings, .. } = self.model;
        self.active_nodes.clear();
        for group in &*self.active_groups {
            for element in layout.elements(layout.slots(*group as usize)) {
                gel.potential.nodes(element).iter().for_each(|node| self.active_nodes.insert(node.index()));
            }
        }
        for a in self.active_nodes.reference_nodes().iter().map(|a| *a as usize) {
            let velocity = self.velocity[a];
            let passed = grid.time(self.ticks.moment.tick - self.last_ticks[a]);
            self.position[a] += velocity * passed;
            if settings.damping > 0.0 {
                self.decay[a] = decay(settings.damping, passed);
            }
            self.last_ticks[a] = self.ticks.moment.tick;
            self.before[a] = velocity;
        }
    }

    /// Evaluates the active groups, each for its kick as far as it is known: without its leading half.
    fn evaluate_groups(&mut self) {
        self.element_responses.elements.clear();
        self.element_responses.groups.clear();
        for i in 0..self.active_groups.len() {
            let (group, first) = (self.active_groups[i] as usize, self.element_responses.elements.len());
            let elapsed = self.model.grid.time(self.ticks.elapsed(group));
            self.responses[group] = self.evaluate_group(group, GroupKick { length: self.kick_lengths[i], elapsed });
            let GroupResponses { elements, groups } = &mut *self.element_responses;
            groups.push(first..elements.len());
            for (element, response) in &elements[first..] {
                self.stiffness[self.model.layout.slot(*element)] = response.stiffness;
            }
        }
    }

    /// Evaluates a group for a kick at the current positions. Appends the responses of its elements and posts the
    /// dissipation to the ledger.
    fn evaluate_group(&mut self, group: usize, kick: GroupKick) -> GroupResponse {
        let DiscreteModel { gel, layout, .. } = self.model;
        let mut sum = GroupResponse { least_jacobian: f64::INFINITY, ..GroupResponse::default() };
        for patch in layout.patches(group) {
            let mut responses = [ElementResponse::default(); DEPTH];
            let dissipation = gel.potential.advance(*patch as usize, self.position, kick, self.memory, &mut responses);
            sum.energy += dissipation.energy;
            self.energy.book_dissipation(&dissipation);
            for (element, response) in gel.potential.patches().of(*patch as usize).iter().zip(&responses) {
                let lane = layout.slot(*element) % layout.width();
                sum.least_jacobian = sum.least_jacobian.min(response.jacobian);
                sum.inverted |= u32::from(response.jacobian <= 0.0) << lane;
                sum.crushed += u32::from(gel.potential.is_crushed(response.jacobian));
                let nodes = gel.potential.nodes(*element).iter();
                let power = nodes.zip(&response.forces).map(|(node, f)| f.dot(&self.velocity[node.index()]));
                sum.power += power.sum::<f64>();
                let now = (&*self.position, self.velocity);
                sum.closing = sum.closing.max(gel.potential.closing(*element, response.jacobian, now));
                self.element_responses.elements.push((*element, *response));
            }
        }
        sum
    }
}

/// Finds the stable limits of the active nodes, s, by the stiffness of the elements; returns the least of them.
pub(super) fn measure_limits<const D: usize, P: Potential<D>>(
    model: &DiscreteModel<D, P>,
    stiffness: &[f64],
    active: &ActiveSet,
    limits: &mut [f64],
) -> KickSums {
    let mut sums = KickSums::default();
    for a in active.reference_nodes() {
        let limit = model.settings.cfl * nodal_limit(&model.gel, stiffness, &model.layout, NodeId(*a));
        limits[*a as usize] = limit;
        sums.limit = sums.limit.min(limit);
    }
    sums
}

/// Kicks of the reference form: those of the elements one by one, then pressures and contact.
pub(super) struct ReferenceKicks<'a, const D: usize, P> {
    pub impulses: ImpulsePhase<'a, D, P>,
    pub active_groups: &'a [u32],
    /// Kick lengths of these groups, s: their trailing halves.
    pub kick_lengths: &'a mut [f64],
    pub responses: &'a GroupResponses<D>,
}

impl<const D: usize, P: Potential<D>> ReferenceKicks<'_, D, P> {
    /// Applies all kicks, then the contact solve; or, by the contact law of the paper, the reversal after each kick.
    /// Returns the work of the kicks less the change of the carried kick work, J.
    pub fn apply(mut self) -> f64 {
        let (ticks, model) = (self.impulses.ticks, self.impulses.nodes.model);
        for (group, length) in self.active_groups.iter().zip(&mut *self.kick_lengths) {
            *length += 0.5 * model.grid.time(ticks.ahead(*group as usize));
        }
        for (i, elements) in self.responses.groups.iter().enumerate() {
            for (element, response) in &self.responses.elements[elements.clone()] {
                self.kick_element(*element, response, self.kick_lengths[i]);
                if model.settings.law == ImpulseLaw::Reversal {
                    self.impulses.contact_problem().reverse(model.gel.potential.nodes(*element));
                }
            }
        }
        self.apply_damping();
        self.impulses.apply_pressures();
        self.impulses.solve_contact();
        self.impulses.rebase_passive_nodes();
        let active = self.impulses.nodes.active.reference_nodes();
        self.impulses.nodes.note_speeds(std::iter::empty(), active);
        self.post_damping_work();
        self.work()
    }

    /// Kicks the nodes of an element in the free directions, v_a += w f_a/m_a, and posts the reaction of the held
    /// ones.
    fn kick_element(&mut self, element: ElementId, response: &ElementResponse<D>, weight: f64) {
        let nodes = &mut self.impulses.nodes;
        let (gel, freedom) = (&nodes.model.gel, nodes.model.freedom());
        let mut reaction = ConstraintReaction::default();
        for (node, force) in gel.potential.nodes(element).iter().zip(&response.forces) {
            let (a, push) = (node.index(), force * weight);
            nodes.push(a, &push);
            reaction.add(&gel.free(a), freedom, embed(&nodes.position[a]), embed(&push));
        }
        reaction.post(self.impulses.ledger);
    }

    /// Damps the active nodes.
    fn apply_damping(&mut self) {
        let ImpulsePhase { nodes, bodies, ledger, record, .. } = &mut self.impulses;
        if nodes.model.settings.damping <= 0.0 {
            return;
        }
        let (freedom, mut loss) = (nodes.model.freedom(), DampingLoss::default());
        for a in nodes.active.reference_nodes().iter().map(|a| *a as usize) {
            nodes.velocity[a] += nodes.before[a] * nodes.decay[a];
            loss.add_impulse(freedom, &nodes.position[a], &nodes.damping_impulse(a));
        }
        loss.post(ledger, &mut record.outside, bodies[0].time);
    }

    /// Posts the work of damping, once all velocities of the tick are known.
    fn post_damping_work(&mut self) {
        let nodes = &self.impulses.nodes;
        let of = |a: usize| 0.5 * nodes.damping_impulse(a).dot(&(nodes.before[a] + nodes.velocity[a]));
        if nodes.model.settings.damping > 0.0 {
            let work: f64 = nodes.active.reference_nodes().iter().map(|a| of(*a as usize)).sum();
            self.impulses.ledger.energy.damping += work;
        }
    }

    /// Returns Σ w f·(v⁻ + v⁺)/2 − Σ ΔQ with the velocities before and after the whole tick, J.
    fn work(self) -> f64 {
        let ImpulsePhase { nodes, ticks, .. } = self.impulses;
        let (active, share) = (nodes.active.reference_nodes(), ticks.moment.leading_share());
        let mut work: f64 = active.iter().map(|a| nodes.excess[*a as usize]).sum();
        for a in active {
            nodes.excess[*a as usize] = 0.0;
        }
        for (elements, weight) in self.responses.groups.iter().zip(&*self.kick_lengths) {
            for (element, response) in &self.responses.elements[elements.clone()] {
                for (node, force) in nodes.model.gel.potential.nodes(*element).iter().zip(&response.forces) {
                    let (before, after) = (nodes.before[node.index()], nodes.velocity[node.index()]);
                    let excess = share * weight * force.dot(&(after - before));
                    nodes.excess[node.index()] += excess;
                    work += 0.5 * weight * force.dot(&(before + after)) - excess;
                }
            }
        }
        work
    }
}
