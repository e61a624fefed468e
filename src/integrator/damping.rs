//! Mass-proportional damping: each node loses speed as exp(−αt) between its kicks, for equilibrium solutions.

use super::engine::Engine;
use crate::contact::FreeDirections;
use crate::fem::Potential;
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed};

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// Returns the damping impulse on a node at this tick, N·s.
    pub(super) fn damping_impulse(&self, a: usize) -> Vector<D> {
        if self.rules.damping > 0.0 && self.scratch.active.has(a) {
            self.scratch.before[a] * (self.gel.mass[a] * self.scratch.decay[a])
        } else {
            Vector::<D>::zeros()
        }
    }

    /// Damps the active nodes of the reference form.
    pub(super) fn damp(&mut self) {
        if self.rules.damping <= 0.0 {
            return;
        }
        let (freedom, mut loss) = (self.freedom(), DampingLoss::default());
        for a in self.scratch.active.reference_nodes().iter().map(|a| *a as usize) {
            self.state.velocity[a] += self.scratch.before[a] * self.scratch.decay[a];
            loss.add_impulse(freedom, &self.state.position[a], &self.damping_impulse(a));
        }
        loss.post(&mut self.state.ledger);
    }

    /// Posts the work of damping of the reference form, once all velocities of the tick are known.
    pub(super) fn book_damping(&mut self) {
        let both = |a: usize| self.scratch.before[a] + self.state.velocity[a];
        let of = |a: usize| 0.5 * self.damping_impulse(a).dot(&both(a));
        if self.rules.damping > 0.0 {
            let work: f64 = self.scratch.active.reference_nodes().iter().map(|a| of(*a as usize)).sum();
            self.state.ledger.energy.damping += work;
        }
    }
}
