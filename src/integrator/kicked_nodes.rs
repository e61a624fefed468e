//! Nodes after the kicks of a tick, whose velocities further impulses change.

use super::active_set::ActiveSet;
use super::blocks::ElementBlocks;
use super::model::DiscreteModel;
use crate::contact::{BatchTravel, NeighbourList};
use crate::fem::Potential;
use crate::math::Vector;
use crate::state::Tick;

/// Kicked nodes: their state, their velocities before the kicks, and the bounds of their speeds.
pub(super) struct KickedNodes<'a, const D: usize, P> {
    pub model: &'a DiscreteModel<D, P>,
    pub active: &'a ActiveSet,
    /// Velocities of the active nodes before the kicks, m/s, and their relative change by damping.
    pub before: &'a [Vector<D>],
    pub decay: &'a [f64],
    pub position: &'a mut [Vector<D>],
    pub velocity: &'a mut [Vector<D>],
    /// Carried kick work Q (A6), J.
    pub excess: &'a mut [f64],
    pub last_ticks: &'a mut [Tick],
    pub neighbours: &'a mut NeighbourList,
    pub batch_travel: &'a mut BatchTravel,
}

impl<const D: usize, P: Potential<D>> KickedNodes<'_, D, P> {
    /// Adds an impulse, N·s, to the velocity of a node in its free directions.
    pub fn push(&mut self, a: usize, impulse: &Vector<D>) {
        self.velocity[a] += impulse.component_mul(&self.model.gel.free(a)) / self.model.gel.mass[a];
    }

    /// Returns the damping impulse on a node at this tick, N·s: mass-proportional damping lets each node lose speed as
    /// exp(−αt) between its kicks.
    pub fn damping_impulse(&self, a: usize) -> Vector<D> {
        if self.model.settings.damping > 0.0 && self.active.has(a) {
            self.before[a] * (self.model.gel.mass[a] * self.decay[a])
        } else {
            Vector::<D>::zeros()
        }
    }

    /// Records the speeds of the active nodes: those of whole chunks, m/s, and those of the listed nodes.
    pub fn note_speeds(&mut self, chunks: impl Iterator<Item = f64>, listed: &[u32]) {
        self.neighbours.note_speeds(self.active.all, chunks);
        for node in listed.iter().map(|node| *node as usize) {
            let speed = self.velocity[node].norm();
            self.neighbours.note_speed(node, speed);
            self.batch_travel.note_speed(node, speed);
        }
    }

    /// Records the speed of a node and activates the blocks around it if it moves.
    pub fn note_speed(&mut self, node: usize, blocks: Option<&ElementBlocks<D>>) {
        let velocity = self.velocity[node];
        self.neighbours.note_speed(node, velocity.norm());
        self.batch_travel.note_speed(node, velocity.norm());
        if let Some(blocks) = blocks.filter(|_| velocity != Vector::<D>::zeros()) {
            blocks.activate_around(node);
        }
    }
}
