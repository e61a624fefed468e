//! The kicks of one tick, and the books of what they did (numerics 1.2, A6).

use super::engine::Engine;
use super::impact::Touch;
use crate::algebra::{Vector, Vector3, embed, restrict};
use crate::contact::{Freedom, Law, Motion};
use crate::element::Potential;
use crate::ledger::Ledger;
use crate::mesh::ElementId;
use crate::state::{Clock, Tick};

impl<const D: usize, P: Potential<D>> Engine<D, P> {
    /// All kicks, then the contact solve; or, by the paper's law, the reversal after each kick.
    pub(super) fn kick_and_strike(&mut self, due: &[ElementId]) {
        match self.rules.law {
            Law::Moreau { restitution, friction, .. } => {
                for (i, patch) in due.iter().enumerate() {
                    self.kick(i, *patch);
                }
                self.solve(restitution, friction);
            }
            Law::Reversal => {
                for (i, patch) in due.iter().enumerate() {
                    self.kick(i, *patch);
                    self.reverse(*patch);
                }
            }
        }
    }

    /// v_a += w f_a/m_a in the free directions; the held ones take up the rest.
    fn kick(&mut self, i: usize, patch: ElementId) {
        let (weight, stride) = (self.scratch.weights[i], self.gel.potential.stride());
        let forces = &self.scratch.forces[i * stride..(i + 1) * stride];
        for (node, force) in self.gel.potential.nodes(patch).iter().zip(forces) {
            let (a, push) = (node.index(), force * weight);
            self.state.velocity[a] += push.component_mul(&self.gel.free[a]) / self.gel.mass[a];
            let at = embed(&self.state.position[a]);
            book_restraint(&self.gel.free[a], self.freedom(), (at, embed(&push)), &mut self.state.ledger);
        }
    }

    /// Posts the integration residual of each firing patch, r = ΔV + (W ahead of the last tick) + (W behind this one),
    /// with W = Σ w f_a·(v_a⁻ + v_a⁺)/2: zero for the exact motion, second order in the step.
    pub(super) fn book(&mut self, due: &[ElementId], was: &[Clock], tick: Tick) {
        let stride = self.gel.potential.stride();
        let mut residual = 0.0;
        for (i, patch) in due.iter().enumerate() {
            let mut work = 0.0;
            for (node, force) in self.gel.potential.nodes(*patch).iter().zip(&self.scratch.forces[i * stride..]) {
                let sum = self.scratch.before[node.index()] + self.state.velocity[node.index()];
                work += 0.5 * self.scratch.weights[i] * force.dot(&sum);
            }
            let (answer, was) = (&self.scratch.answers[i], &was[i]);
            let clock = &mut self.state.clocks[patch.index()];
            let ahead = (clock.next - tick) as f64 / (clock.next - was.last) as f64;
            residual += answer.energy - was.energy + was.ahead + (1.0 - ahead) * work;
            clock.ahead = ahead * work;
            clock.energy = answer.energy;
            clock.jacobian = answer.jacobian;
            clock.inverted = answer.jacobian <= 0.0;
            self.state.record.min_jacobian = self.state.record.min_jacobian.min(answer.jacobian);
        }
        self.state.ledger.energy.integration += residual;
        self.state.record.updates += due.len() as u64;
    }

    /// Posts the work of the contact impulses, Σ J (u⁻ + u⁺)/2, the part Σ J b of it that removes penetration, that of
    /// friction, Σ Jₜ·(u⁻ + u⁺)/2, and what the holder of a body that is not free, or of a growing dome, gives.
    pub(super) fn book_contact(&mut self) {
        let touches = std::mem::take(&mut self.scratch.touches);
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
                let free = &self.gel.free[node.index()];
                book_restraint(free, self.freedom(), (at, push), &mut self.state.ledger);
            }
            if self.bodies[touch.body].motion != Motion::Free {
                self.book_reaction(touch);
            }
        }
        self.scratch.touches = touches;
    }

    /// Momentum and work that come from whoever holds or moves a body.
    fn book_reaction(&mut self, touch: &Touch<D>) {
        let (freedom, push, body) = (self.freedom(), touch.push(), touch.body);
        let work = push.dot(&self.bodies[body].velocity_at(&self.scratch.was[body], &touch.point));
        let ledger = &mut self.state.ledger;
        ledger.energy.external += work;
        ledger.momentum.external += freedom.translation(&push);
        ledger.angular_momentum.external += freedom.rotation(&touch.point.cross(&push));
    }
}

/// What the held directions of a node at `at` take up of a push.
fn book_restraint<const D: usize>(
    free: &Vector<D>,
    freedom: Freedom,
    (at, push): (Vector3, Vector3),
    ledger: &mut Ledger,
) {
    if free.min() == 0.0 {
        let taken = embed(&restrict::<D>(&push).component_mul(free)) - push;
        ledger.momentum.restraint += freedom.translation(&taken);
        ledger.angular_momentum.restraint += freedom.rotation(&at.cross(&taken));
    }
}
