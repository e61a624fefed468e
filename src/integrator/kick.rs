//! Kicks of a tick and their entries in the ledger (numerics 1.2, A6).

use super::blocks::ElementBlocks;
use super::contact_solver::ContactPoint;
use super::energy_residual::{ClockInput, update_clock};
use super::engine::Engine;
use super::node_loop::KickSums;
use super::step_size::StepChange;
use super::substep::MeshPhase;
use crate::contact::{BodyMotion, FreeDirections, ImpulseLaw};
use crate::fem::{ElementResponse, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed, restrict};
use crate::mesh::{ElementId, NodeId};
use crate::state::Tick;

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Completes the kicks of the SIMD form, applies the pressures and solves contact; returns Σ p·(v⁻ + v⁺)/2 − Σ
    /// ΔQ, J.
    pub(super) fn kick_fast(&mut self, tick: Tick, sums: &KickSums) -> f64 {
        let begun = (self.phase == MeshPhase::First).then(|| self.take_first_kick(tick));
        let sums = begun.as_ref().unwrap_or(sums);
        sums.reaction.post(&mut self.state.ledger);
        sums.damping.post(&mut self.state.ledger);
        self.note_speeds();
        let correction = if begun.is_some() { 0.0 } else { self.correct_kicks() };
        self.find_impulse_nodes();
        self.press(tick);
        if let ImpulseLaw::Moreau { restitution, friction, .. } = self.rules.law {
            self.solve(restitution, friction);
        }
        sums.work + correction + self.account_for_impulses(tick)
    }

    /// Takes the first kick of a mesh: the first sweep has found the steps, a second one kicks by half of each.
    fn take_first_kick(&mut self, tick: Tick) -> KickSums {
        self.answer(tick);
        self.add_load_stiffness();
        self.update_nodes(tick)
    }

    /// Corrects the kicks of groups whose step changed: the sweep took half of the planned step; adds half of the
    /// difference to the chosen one.
    fn correct_kicks(&mut self) -> f64 {
        let mut answers = std::mem::take(&mut self.scratch.reference.elements);
        let mut work = 0.0;
        for i in 0..self.scratch.changed.len() {
            let StepChange { group, planned, ahead } = self.scratch.changed[i];
            let contributes = |blocks: &ElementBlocks<D>| blocks.fronts[group as usize / blocks.groups].gives;
            if !self.blocks.as_ref().is_some_and(contributes) {
                continue;
            }
            let change = ahead as f64 - planned as f64;
            answers.clear();
            self.reevaluate_group(group as usize, &mut answers);
            self.separate_power(group as usize, &answers);
            for (element, answer) in &answers {
                work += self.kick_more(*element, answer, 0.5 * change * self.grid.time(1));
            }
        }
        self.scratch.reference.elements = answers;
        work
    }

    /// Takes the power of a group out of the sum of its block, because its next step differs from that of the other
    /// groups.
    fn separate_power(&mut self, group: usize, elements: &[(ElementId, ElementResponse<D>)]) {
        let Some(mut blocks) = self.blocks.take() else { return };
        let block = group / blocks.groups;
        let end = blocks.groups_of(block).end;
        if let Some(power_accumulator) = &mut blocks.all[block].power_accumulator {
            let of_node = |(node, f): (&NodeId, &Vector<D>)| f.dot(&self.scratch.before[node.index()]);
            let element_power = |(element, answer): &(ElementId, ElementResponse<D>)| -> f64 {
                self.gel.potential.nodes(*element).iter().zip(&answer.forces).map(of_node).sum()
            };
            let power = elements.iter().map(element_power).sum();
            let rest = self.scratch.answers[*power_accumulator].power - power;
            // Groups come in ascending order: where the first one leaves, the next one accumulates the rest.
            *power_accumulator += usize::from(*power_accumulator == group);
            self.scratch.answers[group].power = power;
            self.scratch.answers[*power_accumulator..end].iter_mut().take(1).for_each(|answer| answer.power = rest);
        }
        self.blocks = Some(blocks);
    }

    /// Adds a kick of an element to those of the tick; returns the additional work less the change of the carried
    /// kick work, J.
    fn kick_more(&mut self, element: ElementId, answer: &ElementResponse<D>, weight: f64) -> f64 {
        let (gel, mut reaction, mut work) = (self.gel.clone(), ConstraintReaction::default(), 0.0);
        for (node, force) in gel.potential.nodes(element).iter().zip(&answer.forces) {
            let (a, push) = (node.index(), force * weight);
            let kicked = self.state.velocity[a];
            self.state.velocity[a] += push.component_mul(&gel.free(a)) / gel.mass[a];
            let (first, both) = (kicked - self.scratch.before[a], self.state.velocity[a] - self.scratch.before[a]);
            // The impulse p = m Δ does the work p·v⁻ + p·Δ/2, and Q is half of p·Δ, because no kick is corrected in
            // the first or last tick of a mesh. The work of damping in it is not the element's.
            let damped = self.damping_impulse(a).dot(&(both - first));
            self.state.ledger.energy.damping += 0.5 * damped;
            let more = gel.mass[a] * (both.norm_squared() - first.norm_squared()) - damped;
            self.state.excess[a] += 0.5 * more;
            work += gel.mass[a] * (both - first).dot(&self.scratch.before[a]);
            reaction.add(&gel.free(a), self.freedom(), (embed(&self.state.position[a]), embed(&push)));
            self.note_speed(a);
        }
        reaction.post(&mut self.state.ledger);
        work
    }

    /// Records the speeds of the active nodes in the neighbour list: by chunks where the SIMD form has gone through
    /// all of them.
    pub(super) fn note_speeds(&mut self) {
        let (active, speeds) =
            (&self.scratch.active, self.scratch.sums.iter().map(|sums| sums.max_speed_squared.sqrt()));
        self.watch.note_speeds(active.all, speeds);
        // The reference form has no chunks.
        let listed =
            if self.blocks.is_none() { active.reference_nodes() } else { active.listed_nodes().unwrap_or_default() };
        for node in listed.iter().map(|node| *node as usize) {
            self.watch.note_speed(node, self.state.velocity[node].norm());
        }
    }

    /// Records the speed of a node in the neighbour list and activates the blocks around it if it moves.
    fn note_speed(&mut self, node: usize) {
        let velocity = self.state.velocity[node];
        self.watch.note_speed(node, velocity.norm());
        if let Some(blocks) = self.blocks.as_ref().filter(|_| velocity != Vector::<D>::zeros()) {
            blocks.activate_around(node);
        }
    }

    /// Finds the nodes with impulses of contact, symmetry planes or pressures, and their velocities before these.
    fn find_impulse_nodes(&mut self) {
        let mut carriers = std::mem::take(&mut self.scratch.carriers);
        carriers.clear();
        let met = self.scratch.meetings.iter().map(|meeting| meeting.node);
        for node in self.scratch.touches.iter().flat_map(ContactPoint::nodes).copied().chain(met).chain(self.pressed())
        {
            let (before, kicked) = (self.velocity_before(node), self.state.velocity[node.index()]);
            carriers.push(ImpulseNode { node, before, kicked });
        }
        carriers.sort_unstable_by_key(|carrier| carrier.node);
        carriers.dedup_by_key(|carrier| carrier.node);
        self.scratch.carriers = carriers;
    }

    /// Accounts for the change of velocity by pressures and contact after the kicks. Returns their additional work,
    /// Σ p·(v⁺ − v)/2 with p = m (v − v⁻) without the damping, less the change of Q, J.
    fn account_for_impulses(&mut self, tick: Tick) -> f64 {
        let mut work = 0.0;
        for i in 0..self.scratch.carriers.len() {
            let ImpulseNode { node, before, kicked } = self.scratch.carriers[i];
            let a = node.index();
            let (drag, change) = (self.damping_impulse(a), self.state.velocity[a] - kicked);
            let more = ((kicked - before) * self.gel.mass[a] - drag).dot(&change);
            self.state.ledger.energy.damping += 0.5 * drag.dot(&change);
            self.state.excess[a] += self.leading_share() * more;
            work += (0.5 - self.leading_share()) * more;
            self.last[a] = tick;
            self.note_speed(a);
        }
        work
    }

    /// Posts the integration residual of the active groups, Σ ΔV + Σ A of the last tick + W − Σ A of this one,
    /// where A is the leading-half work. It is zero for the exact motion and of second order in the step.
    pub(super) fn post_residual(&mut self, tick: Tick, work: f64) {
        let residual =
            if self.blocks.is_some() { self.update_block_clocks(tick) } else { self.update_group_clocks(tick) };
        self.state.ledger.energy.integration += residual + work;
        self.book_loads();
    }

    /// Updates the clocks of the active groups (reference form); returns the residual, J.
    fn update_group_clocks(&mut self, tick: Tick) -> f64 {
        let mut residual = 0.0;
        for group in self.scratch.due.iter().map(|group| *group as usize) {
            let ahead = self.ahead(group, tick);
            let (clock, answer) = (&mut self.state.clocks[group], &self.scratch.answers[group]);
            residual += update_clock(clock, answer, self.grid.time(ahead));
            self.state.record.min_jacobian = self.state.record.min_jacobian.min(answer.least_jacobian);
            self.state.record.updates += self.order.elements(self.order.slots(group)).count() as u64;
        }
        residual
    }

    /// Updates the clocks and step ranges of the active blocks; returns the residual, J.
    fn update_block_clocks(&mut self, tick: Tick) -> f64 {
        let Some(mut blocks) = self.blocks.take() else { return 0.0 };
        let (moment, groups_per_block) = (self.tick_context(tick), blocks.groups);
        let input = ClockInput { grid: self.grid, moment, answers: &self.scratch.answers };
        let total = blocks.update_clocks(input, &mut self.state.clocks, self.pool.as_deref());
        self.state.ledger.energy.book_dissipation(&total.spent);
        let record = &mut self.state.record;
        for report in blocks.all.iter().filter_map(|block| block.report) {
            record.updates += report.updates;
            record.min_jacobian = record.min_jacobian.min(report.least_jacobian);
        }
        let block_of = |change: &StepChange| change.group as usize / groups_per_block;
        for changed in self.scratch.changed.chunk_by(|a, b| block_of(a) == block_of(b)) {
            let block = block_of(&changed[0]);
            blocks.update_steps(block, &self.state.clocks, self.grid);
            blocks.all[block].restless = true;
        }
        self.blocks = Some(blocks);
        total.residual
    }

    /// Posts the work of the contact impulses, Σ J (u⁻ + u⁺)/2, without its part Σ J b that removes penetration;
    /// that part; and the work of friction, Σ Jₜ·(u⁻ + u⁺)/2. Also posts the work of the support of a body that is
    /// not free and of a growing dome.
    pub(super) fn post_contact_work(&mut self) {
        let touches = std::mem::take(&mut self.scratch.touches);
        let mut reaction = ConstraintReaction::default();
        for touch in touches.iter().filter(|touch| touch.impulse > 0.0) {
            let j = touch.impulse;
            let mean = 0.5 * (touch.before + self.relative(touch));
            let removal = j * touch.bias;
            self.state.ledger.energy.contact += j * touch.normal.dot(&mean) - removal;
            self.state.ledger.energy.contact_bias += removal;
            self.state.ledger.energy.friction += touch.drag.dot(&mean);
            self.state.ledger.energy.external += touch.push().dot(&touch.swell);
            for (node, w) in touch.carriers() {
                let (at, push) = (embed(&self.state.position[node.index()]), touch.push() * w);
                reaction.add(&self.gel.free(node.index()), self.freedom(), (at, push));
            }
            if self.bodies[touch.body].motion != BodyMotion::Free {
                self.book_reaction(touch);
            }
        }
        reaction.post(&mut self.state.ledger);
        self.scratch.touches = touches;
        self.book_symmetry_contacts();
    }

    /// Posts the momentum and work of the support that holds or moves a body.
    fn book_reaction(&mut self, touch: &ContactPoint<D>) {
        let (freedom, push, body) = (self.freedom(), touch.push(), touch.body);
        let work = push.dot(&self.bodies[body].velocity_at(&self.scratch.was[body], &touch.point));
        let ledger = &mut self.state.ledger;
        ledger.energy.external += work;
        ledger.momentum.external += freedom.translation(&push);
        ledger.angular_momentum.external += freedom.rotation(&touch.point.cross(&push));
    }
}
