//! Accounts of contact: the impulses on the bodies, and the work of all contact impulses in the ledger (method A6).

use super::ExitRule;
use super::bodies::rebase_body;
use super::kick_sums::ConstraintReaction;
use super::surface_at_tick::SurfaceAtTick;
use crate::contact::{BodyMotion, BodyState, ContactPoint, ImpulseExchange, SelfContact, ShapeMotion, SymmetryContact};
use crate::fem::Potential;
use crate::ledger::Ledger;
use crate::math::{Vector, Vector3, embed};
use crate::state::RunRecord;

/// Accounts of the contact impulses of a tick: reads contacts and velocities, and writes ledger, record and bodies.
pub(super) struct ContactAccounts<'a, const D: usize, P> {
    pub surface: SurfaceAtTick<'a, D, P>,
    pub bodies_after: &'a [BodyState],
    pub points: &'a [ContactPoint<D>],
    pub symmetry: &'a [SymmetryContact],
    pub self_contacts: &'a [SelfContact<D>],
    pub exits: Option<ExitRule>,
    /// Bodies at their last events.
    pub bodies: &'a mut [BodyState],
    pub ledger: &'a mut Ledger,
    pub record: &'a mut RunRecord,
}

impl<const D: usize, P: Potential<D>> ContactAccounts<'_, D, P> {
    /// Makes the impulses events of the bodies, and adds them to the exchanges with the importer, which end at time
    /// `end`, s, and to the record.
    pub fn post_body_impulses(mut self, end: f64, exchanges: &mut [ImpulseExchange]) {
        for (body, exchange) in exchanges.iter_mut().enumerate() {
            let Some(impulse) = self.body_impulse(body, exchange) else { continue };
            let time = self.surface.time();
            exchange.impulse += impulse;
            exchange.impulse_moment += impulse * (end - time);
            rebase_body(&self.surface.model.bodies[body], &mut self.bodies[body], self.ledger, time);
            self.bodies[body] = self.bodies_after[body];
            self.record_impulse(body, impulse, time);
            self.open(body, time);
        }
    }

    /// Returns the impulse of this tick on a body, N·s, if there is one, and adds the sums over its contact points to
    /// the exchange and to the record.
    fn body_impulse(&mut self, body: usize, exchange: &mut ImpulseExchange) -> Option<Vector3> {
        let ((rigid, was), now) = (self.surface.bodies().get(body), &self.bodies_after[body]);
        let record = &mut self.record.contacts[body];
        let touches = self.points.iter().filter(|touch| touch.body == body && touch.impulse > 0.0);
        touches.fold(None, |sum: Option<Vector3>, touch| {
            let body_impulse = rigid.freedom.translation(&-touch.push());
            let arm = touch.point - was.position;
            let mean_velocity = (rigid.velocity_at(was, &touch.point) + rigid.velocity_at(now, &touch.point)) / 2.0;
            exchange.angular_impulse += rigid.freedom.rotation(&arm.cross(&body_impulse));
            // The whole normal impulse, with the part across the axis that a ring of an axisymmetric gel exerts.
            exchange.shape_impulse -= touch.growth * touch.impulse;
            exchange.energy_residual -= body_impulse.dot(&mean_velocity);
            record.work += body_impulse.dot(&mean_velocity);
            if touch.n_nodes == 1 {
                let depth = -touch.distance / touch.size;
                record.standing = (record.standing.0 + depth, record.standing.1 + 1);
                record.deepest = record.deepest.max(depth);
            }
            Some(sum.unwrap_or_else(Vector3::zeros) + body_impulse)
        })
    }

    /// Lets an expanding body open as the stagnation pressure at its velocity relative to the block demands.
    fn open(&mut self, body: usize, time: f64) {
        let (model, at) = (self.surface.model, &mut self.bodies[body]);
        let Some(law) = &model.bodies[body].expansion else { return };
        let block = model.frame.motion(&self.record.outside, time);
        if let Some(ShapeMotion::Expansion(motion)) = &mut at.shape_motion {
            *motion = law.opened_by_impulse(motion, &(at.velocity - block.velocity));
        }
    }

    /// Records an impulse on a body: its sum, direction and time, the depth and the window of the peak force.
    fn record_impulse(&mut self, body: usize, impulse: Vector3, time: f64) {
        let depth = self.depth_in_gel(body);
        let width = self.surface.model.settings.force_window;
        self.record.outside.add(&-impulse, time);
        self.record.contacts[body].add_impulse(&impulse, time, depth, width);
    }

    /// Returns the depth of a body at its last event below the undeformed entry surface, m, at most that of the back
    /// face.
    fn depth_in_gel(&self, body: usize) -> f64 {
        let (model, at) = (self.surface.model, &self.bodies[body]);
        let motion = model.frame.motion(&self.record.outside, at.time);
        let depth = model.bodies[body].depth(&motion.seen_from(at));
        self.exits.map_or(depth, |rule| depth.min(-rule.back_face))
    }

    /// Posts the work of the contact impulses, Σ J (u⁻ + u⁺)/2, without its part Σ J b that removes penetration;
    /// that part; and the work of friction, Σ Jₜ·(u⁻ + u⁺)/2. Also posts the work of the support of a body that is
    /// not free, of a growing dome and of an expanding body.
    pub fn post_work(mut self) {
        let (model, nodes, mut reaction) = (self.surface.model, self.surface.nodes, ConstraintReaction::default());
        for touch in self.points.iter().filter(|touch| touch.impulse > 0.0) {
            let j = touch.impulse;
            let (rigid, now) = (&model.bodies[touch.body], &self.bodies_after[touch.body]);
            let relative =
                touch.relative_velocity(&rigid.velocity_at(now, &touch.point), |node| nodes.velocity[node.index()]);
            let mean = 0.5 * (touch.before + relative);
            let removal = j * touch.bias;
            self.ledger.energy.contact += j * touch.normal.dot(&mean) - removal;
            self.ledger.energy.contact_bias += removal;
            self.ledger.energy.friction += touch.drag.dot(&mean);
            let energy = &mut self.ledger.energy;
            let surface_work = if rigid.is_expanding() { &mut energy.expansion } else { &mut energy.external };
            *surface_work += touch.push().dot(&touch.swell);
            for (node, w) in touch.carriers() {
                let (at, push) = (embed(&nodes.position[node.index()]), touch.push() * w);
                reaction.add(&model.gel.free(node.index()), model.freedom(), at, push);
            }
            if rigid.motion != BodyMotion::Free {
                self.post_support_reaction(touch);
            }
        }
        reaction.post(self.ledger);
        self.post_symmetry_work();
        self.post_self_contact_work();
    }

    /// Posts the momentum and work of the support that holds or moves a body.
    fn post_support_reaction(&mut self, touch: &ContactPoint<D>) {
        let (freedom, push) = (self.surface.model.freedom(), touch.push());
        let (rigid, was) = self.surface.bodies().get(touch.body);
        self.ledger.energy.external += push.dot(&rigid.velocity_at(was, &touch.point));
        self.ledger.momentum.external += freedom.translation(&push);
        self.ledger.angular_momentum.external += freedom.rotation(&touch.point.cross(&push));
    }

    /// Posts the work of the symmetry contacts, Σ J (u⁻ + u⁺)/2, and their momentum, which the plane's restraint
    /// gives.
    fn post_symmetry_work(&mut self) {
        let (nodes, mut taken) = (self.surface.nodes, ConstraintReaction::default());
        for SymmetryContact { node, axis, before, impulse, .. } in self.symmetry {
            let a = node.index();
            self.ledger.energy.contact += 0.5 * impulse * (before + nodes.velocity[a][*axis]);
            let push = embed(&Vector::<D>::from_fn(|i, _| if i == *axis { *impulse } else { 0.0 }));
            taken.add_reaction(self.surface.model.freedom(), embed(&nodes.position[a]), push);
        }
        taken.post(self.ledger);
    }

    /// Posts the work of the contacts of the gel with itself, Σ J (u⁻ + u⁺)/2, and the momentum that the restraints of
    /// their nodes give.
    fn post_self_contact_work(&mut self) {
        let SurfaceAtTick { model, nodes, .. } = self.surface;
        let (mut taken, time) = (ConstraintReaction::default(), self.surface.time());
        for contact in self.self_contacts.iter().filter(|contact| contact.impulse > 0.0) {
            let after = contact.separation_velocity(|node| nodes.velocity[node.index()]);
            self.ledger.energy.self_contact += 0.5 * contact.impulse * (contact.before + after);
            for (node, s) in contact.carriers() {
                let (at, push) = (nodes.position_at(node, time), contact.push() * s);
                taken.add(&model.gel.free(node.index()), model.freedom(), embed(&at), embed(&push));
            }
        }
        taken.post(self.ledger);
    }
}
