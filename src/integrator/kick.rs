//! Correction of the kicks of a tick whose steps have changed (method 1.2, A6).

use super::blocks::ElementBlocks;
use super::kick_sums::{ConstraintReaction, KickSums};
use super::kicked_nodes::KickedNodes;
use super::model::DiscreteModel;
use super::workspace::StepChange;
use crate::fem::{DEPTH, ElementResponse, GroupResponse, HistoryVariables, Potential};
use crate::ledger::Ledger;
use crate::math::{Vector, embed};
use crate::mesh::{ElementId, NodeId};

/// Kick correction: the sweep took half of the planned step; half of the difference to the chosen one is added.
pub(super) struct KickCorrection<'a, const D: usize, P> {
    pub nodes: KickedNodes<'a, D, P>,
    /// Sums over the chunks of nodes, with their greatest speeds.
    pub chunk_sums: &'a [KickSums],
    pub changed_steps: &'a [StepChange],
    pub blocks: &'a mut ElementBlocks<D>,
    pub memory: &'a mut [HistoryVariables<D>],
    pub responses: &'a mut [GroupResponse],
    /// Responses of the elements of one group.
    pub elements: &'a mut Vec<(ElementId, ElementResponse<D>)>,
    pub ledger: &'a mut Ledger,
}

impl<const D: usize, P: Potential<D>> KickCorrection<'_, D, P> {
    /// Records the speeds after the kicks and corrects the kicks of the groups whose step changed; returns the
    /// additional work less the change of the carried kick work, J.
    pub fn correct(mut self) -> f64 {
        let speeds = self.chunk_sums.iter().map(|sums| sums.max_speed_squared.sqrt());
        self.nodes.note_speeds(speeds, self.nodes.active.listed_nodes().unwrap_or_default());
        let (mut work, grid) = (0.0, self.nodes.model.grid);
        for StepChange { group, planned, ahead } in self.changed_steps {
            let group = *group as usize;
            if !self.blocks.monitors[group / self.blocks.groups].contributes {
                continue;
            }
            let change = *ahead as f64 - *planned as f64;
            self.reevaluate_group(group);
            self.separate_power(group);
            for i in 0..self.elements.len() {
                let (element, response) = self.elements[i];
                work += self.correct_element(element, &response, 0.5 * change * grid.time(1));
            }
        }
        work
    }

    /// Evaluates the elements of a group again that was swept at this tick.
    fn reevaluate_group(&mut self, group: usize) {
        let DiscreteModel { gel, layout, .. } = self.nodes.model;
        self.blocks.store_history(layout.slots(group), layout, self.memory);
        self.elements.clear();
        for patch in layout.patches(group) {
            let own = gel.potential.patches().of(*patch as usize);
            let (mut responses, viscous) = ([ElementResponse::default(); DEPTH], self.blocks.viscous(layout, own));
            gel.potential.again(*patch as usize, self.nodes.position, self.memory, &viscous, &mut responses);
            self.elements.extend(own.iter().copied().zip(responses));
        }
    }

    /// Takes the power of a group out of the sum of its block, because its next step differs from that of the other
    /// groups.
    fn separate_power(&mut self, group: usize) {
        let block = group / self.blocks.groups;
        let end = self.blocks.groups_of(block).end;
        let Some(power_accumulator) = &mut self.blocks.all[block].power_accumulator else { return };
        let (gel, before) = (&self.nodes.model.gel, self.nodes.before);
        let of_node = |(node, f): (&NodeId, &Vector<D>)| f.dot(&before[node.index()]);
        let element_power = |(element, response): &(ElementId, ElementResponse<D>)| -> f64 {
            gel.potential.nodes(*element).iter().zip(&response.forces).map(of_node).sum()
        };
        let power = self.elements.iter().map(element_power).sum();
        let rest = self.responses[*power_accumulator].power - power;
        // Groups come in ascending order: where the first one leaves, the next one accumulates the rest.
        *power_accumulator += usize::from(*power_accumulator == group);
        self.responses[group].power = power;
        self.responses[*power_accumulator..end].iter_mut().take(1).for_each(|response| response.power = rest);
    }

    /// Adds a kick of an element to those of the tick; returns the additional work less the change of the carried
    /// kick work, J.
    fn correct_element(&mut self, element: ElementId, response: &ElementResponse<D>, weight: f64) -> f64 {
        let (nodes, mut reaction, mut work) = (&mut self.nodes, ConstraintReaction::default(), 0.0);
        let (gel, freedom) = (&nodes.model.gel, nodes.model.freedom());
        for (node, force) in gel.potential.nodes(element).iter().zip(&response.forces) {
            let (a, push) = (node.index(), force * weight);
            let kicked = nodes.velocity[a];
            nodes.push(a, &push);
            let (first, both) = (kicked - nodes.before[a], nodes.velocity[a] - nodes.before[a]);
            // The impulse p = m Δ does the work p·v⁻ + p·Δ/2, and Q is half of p·Δ, because no kick is corrected in
            // the first or last tick of a mesh. The work of damping in it is not the element's.
            let damped = nodes.damping_impulse(a).dot(&(both - first));
            self.ledger.energy.damping += 0.5 * damped;
            let more = gel.mass[a] * (both.norm_squared() - first.norm_squared()) - damped;
            nodes.excess[a] += 0.5 * more;
            work += gel.mass[a] * (both - first).dot(&nodes.before[a]);
            reaction.add(&gel.free(a), freedom, embed(&nodes.position[a]), embed(&push));
            nodes.note_speed(a, Some(self.blocks));
        }
        reaction.post(self.ledger);
        work
    }
}
