//! Impulses after the kicks of a tick: pressures, contact, and their work (A6).

use super::DiscreteGel;
use super::blocks::ElementBlocks;
use super::kick_sums::ConstraintReaction;
use super::kicked_nodes::KickedNodes;
use super::substep::GroupTicks;
use super::workspace::{FacetLoad, ImpulseNode, PassiveNode, PressureSource};
use crate::contact::{BodyState, ContactPoint, ContactProblem, ImpulseLaw, SelfContact, SymmetryContact};
use crate::fem::Potential;
use crate::ledger::Ledger;
use crate::math::{Vector, embed};
use crate::mesh::NodeId;
use crate::state::RunRecord;

/// Impulse phase: reads pressures and contacts, and writes the nodes and bodies that they push.
pub(super) struct ImpulsePhase<'a, const D: usize, P> {
    pub nodes: KickedNodes<'a, D, P>,
    pub ticks: GroupTicks<'a>,
    pub blocks: Option<&'a ElementBlocks<D>>,
    /// Bodies before the impulses, and with the impulses so far.
    pub bodies: &'a [BodyState],
    pub bodies_after: &'a mut [BodyState],
    pub facet_loads: &'a mut [FacetLoad<D>],
    pub points: &'a mut [ContactPoint<D>],
    pub symmetry: &'a mut [SymmetryContact],
    pub self_contacts: &'a mut [SelfContact<D>],
    pub passive_nodes: &'a [PassiveNode<D>],
    pub impulse_nodes: &'a mut Vec<ImpulseNode<D>>,
    pub ledger: &'a mut Ledger,
    pub record: &'a mut RunRecord,
}

impl<const D: usize, P: Potential<D>> ImpulsePhase<'_, D, P> {
    /// Applies pressures and contact in the SIMD form; returns their additional work less the change of Q, J.
    pub fn apply(mut self) -> f64 {
        self.find_impulse_nodes();
        self.apply_pressures();
        self.solve_contact();
        self.rebase_passive_nodes();
        self.account_for_impulses()
    }

    /// Finds the nodes with impulses of contact, symmetry planes or pressures, and their velocities before these. Nodes
    /// that self-contact strikes between their ticks are not among them.
    fn find_impulse_nodes(&mut self) {
        let KickedNodes { active, before, ref velocity, .. } = self.nodes;
        let touching = self.points.iter().flat_map(ContactPoint::nodes).copied();
        let symmetric = self.symmetry.iter().map(|contact| contact.node);
        let own = self.self_contacts.iter().flat_map(SelfContact::carriers).map(|(node, _)| node);
        let own = own.filter(|node| active.has(node.index()));
        let loaded = self.facet_loads.iter().flat_map(|load| load.nodes[..D].iter().copied());
        let mut nodes: Vec<NodeId> = touching.chain(symmetric).chain(own).chain(loaded).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let impulse_node = |node: NodeId| {
            let (a, kicked) = (node.index(), velocity[node.index()]);
            ImpulseNode { node, before: if active.has(a) { before[a] } else { kicked }, kicked }
        };
        self.impulse_nodes.clear();
        self.impulse_nodes.extend(nodes.into_iter().map(impulse_node));
    }

    /// Kicks the nodes of the loaded facets by their pressures; held directions take up the rest.
    pub fn apply_pressures(&mut self) {
        if self.facet_loads.is_empty() {
            return;
        }
        let Self { nodes, ticks, ledger, record, .. } = self;
        let (model, mut reaction) = (nodes.model, ConstraintReaction::default());
        let (freedom, time) = (model.freedom(), model.grid.time(ticks.moment.tick));
        for load in &mut *self.facet_loads {
            load.weight += 0.5 * model.grid.time(ticks.ahead(load.group));
            for (node, impulse) in load.impulses() {
                let (a, push) = (node.index(), embed(&impulse));
                nodes.push(a, &impulse);
                let at = embed(&nodes.position[a]);
                reaction.add(&model.gel.free(a), freedom, at, push);
                let (momentum, angular_momentum) = match load.source {
                    PressureSource::Face => (&mut ledger.momentum.load, &mut ledger.angular_momentum.load),
                    PressureSource::Cavity => (&mut ledger.momentum.air, &mut ledger.angular_momentum.air),
                };
                let free_push = freedom.translation(&push);
                *momentum += free_push;
                *angular_momentum += freedom.rotation(&at.cross(&push));
                record.outside.add(&free_push, time);
                record.pressed += push.norm();
            }
        }
        reaction.post(ledger);
    }

    /// Returns the contact problem of this tick.
    pub fn contact_problem(&mut self) -> ContactProblem<'_, D, DiscreteGel<D, P>> {
        ContactProblem {
            masses: &self.nodes.model.gel,
            velocity: self.nodes.velocity,
            bodies: &self.nodes.model.bodies,
            was: self.bodies,
            now: self.bodies_after,
            points: self.points,
            symmetry: self.symmetry,
            own: self.self_contacts,
        }
    }

    /// Solves Moreau's law with Coulomb friction at all contact points and contacts of the gel. By the law of the paper
    /// the kicks have met the bodies, and the contacts of the gel with its images and with itself are corrected once.
    pub fn solve_contact(&mut self) {
        let approaches = self.record.contacts.iter().map(|contact| contact.approach);
        let greatest_approach = approaches.fold(0.0, f64::max);
        let law = self.nodes.model.settings.law;
        let mut problem = self.contact_problem();
        match law {
            ImpulseLaw::Moreau { restitution, friction, .. } => {
                let has_converged = problem.solve(restitution, friction, greatest_approach);
                self.record.unconverged_solves += u64::from(!has_converged);
            }
            ImpulseLaw::Reversal => _ = problem.correct_gel_contacts(),
        }
    }

    /// Moves the passive nodes that the contacts have struck onto the paths that lead through their places at this tick
    /// with their new velocities: the state holds each node as it is at its last tick.
    pub fn rebase_passive_nodes(&mut self) {
        let (nodes, tick) = (&mut self.nodes, self.ticks.moment.tick);
        for PassiveNode { node, before, last } in self.passive_nodes {
            let (a, passed) = (node.index(), nodes.model.grid.time(tick - last));
            let change = nodes.velocity[a] - before;
            if change != Vector::<D>::zeros() {
                nodes.position[a] -= change * passed;
                nodes.last_ticks[a] = *last;
                nodes.note_speed(a, self.blocks);
            }
        }
    }

    /// Accounts for the change of velocity by pressures and contact after the kicks. Returns their additional work,
    /// Σ p·(v⁺ − v)/2 with p = m (v − v⁻) without the damping, less the change of Q, J.
    fn account_for_impulses(self) -> f64 {
        let (mut nodes, moment, mut work) = (self.nodes, self.ticks.moment, 0.0);
        for ImpulseNode { node, before, kicked } in &*self.impulse_nodes {
            let a = node.index();
            let (drag, change) = (nodes.damping_impulse(a), nodes.velocity[a] - kicked);
            let more = ((kicked - before) * nodes.model.gel.mass[a] - drag).dot(&change);
            self.ledger.energy.damping += 0.5 * drag.dot(&change);
            nodes.excess[a] += moment.leading_share() * more;
            work += (0.5 - moment.leading_share()) * more;
            nodes.last_ticks[a] = moment.tick;
            nodes.note_speed(a, self.blocks);
        }
        work
    }
}
