//! Reference form of a tick: one element after the other, each kick by itself.
//!
//! It handles the queue, the contact law of the paper and potentials without SIMD layout. Tests compare the SIMD
//! form with it.

use super::damping::decay;
use super::engine::Engine;
use super::kick::ConstraintReaction;
use super::node_loop::KickSums;
use super::schedule::SteppingSchedule;
use super::step_size::nodal_limit;
use super::substep::MeshPhase;
use crate::contact::ImpulseLaw;
use crate::fem::{DEPTH, ElementResponse, GroupResponse, Potential};
use crate::math::embed;
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;
use std::ops::Range;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Drifts the nodes of the active groups.
    pub(super) fn drift_group_nodes(&mut self, tick: Tick) {
        self.scratch.active.clear();
        for group in &self.scratch.due {
            for element in self.order.elements(self.order.slots(*group as usize)) {
                self.gel.potential.nodes(element).iter().for_each(|node| self.scratch.active.insert(node.index()));
            }
        }
        for a in self.scratch.active.reference_nodes().iter().map(|a| *a as usize) {
            let velocity = self.state.velocity[a];
            let passed = self.grid.time(tick - self.last[a]);
            self.state.position[a] += velocity * passed;
            if self.rules.damping > 0.0 {
                self.scratch.decay[a] = decay(self.rules.damping, passed);
            }
            self.last[a] = tick;
            self.scratch.before[a] = velocity;
        }
    }

    /// Evaluates the forces of the active groups.
    pub(super) fn evaluate_forces(&mut self, tick: Tick) {
        let mut answers = std::mem::take(&mut self.scratch.reference);
        answers.elements.clear();
        answers.groups.clear();
        for i in 0..self.scratch.due.len() {
            let (group, first) = (self.scratch.due[i] as usize, answers.elements.len());
            self.scratch.answers[group] = self.evaluate_group(group, self.elapsed(group, tick), &mut answers.elements);
            answers.groups.push(first..answers.elements.len());
            for (element, answer) in &answers.elements[first..] {
                self.state.stiffness[self.order.slot(*element)] = answer.stiffness;
            }
        }
        self.scratch.reference = answers;
    }

    /// Returns the time since the last tick of an active group, s.
    fn elapsed(&self, group: usize, tick: Tick) -> f64 {
        let elapsed = match self.rules.schedule {
            SteppingSchedule::Queue if self.phase == MeshPhase::First => 0,
            SteppingSchedule::Queue => tick - self.state.alarms[group].last,
            SteppingSchedule::Bins | SteppingSchedule::Global => {
                self.tick_context(tick).elapsed(self.state.clocks[group].step)
            }
        };
        self.grid.time(elapsed)
    }

    /// Evaluates a group at the current positions, after the time since its last tick, s. Appends the responses to
    /// `elements` and posts the dissipation to the ledger.
    pub(super) fn evaluate_group(
        &mut self,
        group: usize,
        elapsed: f64,
        elements: &mut Vec<(ElementId, ElementResponse<D>)>,
    ) -> GroupResponse {
        let mut sum = GroupResponse { least_jacobian: f64::INFINITY, ..GroupResponse::default() };
        for patch in self.order.patches(group) {
            let mut answers = [ElementResponse::default(); DEPTH];
            let history = (elapsed, self.state.memory.as_mut_slice());
            let spent = self.gel.potential.advance(*patch as usize, &self.state.position, history, &mut answers);
            sum.energy += spent.energy;
            self.state.ledger.energy.book_dissipation(&spent);
            for (element, answer) in self.gel.potential.patches().of(*patch as usize).iter().zip(&answers) {
                let lane = self.order.slot(*element) % self.order.width();
                sum.least_jacobian = sum.least_jacobian.min(answer.jacobian);
                sum.inverted |= u32::from(answer.jacobian <= 0.0) << lane;
                sum.crushed += u32::from(self.gel.potential.is_crushed(answer.jacobian));
                let nodes = self.gel.potential.nodes(*element).iter();
                let power = nodes.zip(&answer.forces).map(|(node, f)| f.dot(&self.state.velocity[node.index()]));
                sum.power += power.sum::<f64>();
                let now = (self.state.position.as_slice(), self.state.velocity.as_slice());
                sum.closing = sum.closing.max(self.gel.potential.closing(*element, answer.jacobian, now));
                elements.push((*element, *answer));
            }
        }
        sum
    }

    /// Finds the stable limits of the active nodes and the least of them.
    pub(super) fn measure_limits(&mut self) -> KickSums {
        let known = (self.state.stiffness.as_slice(), &*self.order);
        let mut sums = KickSums::default();
        for a in self.scratch.active.reference_nodes() {
            let limit = self.rules.cfl * nodal_limit(&self.gel, known, NodeId(*a));
            self.scratch.limit[*a as usize] = limit;
            sums.limit = sums.limit.min(limit);
        }
        sums
    }

    /// Applies all kicks, then the contact solve; or, by the contact law of the paper, the reversal after each kick.
    pub(super) fn kick_and_solve_contact(&mut self, tick: Tick) {
        let answers = std::mem::take(&mut self.scratch.reference);
        for (i, elements) in answers.groups.iter().enumerate() {
            for (element, answer) in &answers.elements[elements.clone()] {
                self.kick_element(*element, answer, self.scratch.weights[i]);
                if self.rules.law == ImpulseLaw::Reversal {
                    self.apply_reversal(*element);
                }
            }
        }
        self.scratch.reference = answers;
        self.damp();
        self.press(tick);
        match self.rules.law {
            ImpulseLaw::Moreau { restitution, friction, .. } => self.solve(restitution, friction),
            ImpulseLaw::Reversal => _ = self.correct_symmetry_contacts(),
        }
    }

    /// Kicks the nodes of an element in the free directions, v_a += w f_a/m_a, and posts the reaction of the held
    /// ones.
    fn kick_element(&mut self, element: ElementId, answer: &ElementResponse<D>, weight: f64) {
        let (gel, freedom) = (&self.gel, self.freedom());
        let mut reaction = ConstraintReaction::default();
        for (node, force) in gel.potential.nodes(element).iter().zip(&answer.forces) {
            let (a, push) = (node.index(), force * weight);
            self.state.velocity[a] += push.component_mul(&gel.free(a)) / gel.mass[a];
            reaction.add(&gel.free(a), freedom, (embed(&self.state.position[a]), embed(&push)));
        }
        reaction.post(&mut self.state.ledger);
    }

    /// Returns Σ w f·(v⁻ + v⁺)/2 − Σ ΔQ with the velocities before and after the whole tick, J: the work of the
    /// kicks less the change of the carried kick work.
    pub(super) fn kick_work(&mut self) -> f64 {
        self.book_damping();
        let (answers, share) = (&self.scratch.reference, self.leading_share());
        let mut work: f64 = self.scratch.active.reference_nodes().iter().map(|a| self.state.excess[*a as usize]).sum();
        self.scratch.active.reference_nodes().iter().for_each(|a| self.state.excess[*a as usize] = 0.0);
        for (elements, weight) in answers.groups.iter().zip(&self.scratch.weights) {
            for (element, answer) in &answers.elements[elements.clone()] {
                for (node, force) in self.gel.potential.nodes(*element).iter().zip(&answer.forces) {
                    let (before, after) = (self.scratch.before[node.index()], self.state.velocity[node.index()]);
                    let excess = share * weight * force.dot(&(after - before));
                    self.state.excess[node.index()] += excess;
                    work += 0.5 * weight * force.dot(&(before + after)) - excess;
                }
            }
        }
        work
    }
}
