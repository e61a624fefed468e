//! Accounts of contact: the impulses on the bodies, and the work of all contact impulses in the ledger (method A6).

use super::bodies::{depth_in_gel, rebase_body};
use super::kick_sums::ConstraintReaction;
use super::system::DiscreteSystem;
use crate::contact::{BodyMotion, ContactPoint, ImpulseExchange, SymmetryContact};
use crate::fem::Potential;
use crate::math::{Vector, Vector3, embed};

/// Makes the impulses events of the bodies, and adds them to the exchanges with the importer and to the record.
pub(super) fn post_body_impulses<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    time: f64,
    end: f64,
    exchanges: &mut [ImpulseExchange],
) {
    for (body, exchange) in exchanges.iter_mut().enumerate() {
        let Some(impulse) = body_impulse(system, body, exchange) else { continue };
        exchange.impulse += impulse;
        exchange.impulse_moment += impulse * (end - time);
        rebase_body(system, body, time);
        system.state.bodies[body] = system.workspace.bodies_after[body];
        record_impulse(system, body, impulse, time);
    }
}

/// Returns the impulse of this tick on a body, N·s, if there is one, and adds the sums over its contact points to
/// the exchange and to the record.
fn body_impulse<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    body: usize,
    exchange: &mut ImpulseExchange,
) -> Option<Vector3> {
    let (rigid, was, now) =
        (&system.model.bodies[body], &system.workspace.bodies_before[body], &system.workspace.bodies_after[body]);
    let record = &mut system.state.record.contacts[body];
    let touches = system.workspace.contact_points.iter().filter(|touch| touch.body == body && touch.impulse > 0.0);
    touches.fold(None, |sum: Option<Vector3>, touch| {
        let body_impulse = rigid.freedom.translation(&-touch.push());
        let arm = touch.point - was.position;
        let mean_velocity = (rigid.velocity_at(was, &touch.point) + rigid.velocity_at(now, &touch.point)) / 2.0;
        exchange.angular_impulse += rigid.freedom.rotation(&arm.cross(&body_impulse));
        // The whole normal impulse, with the part across the axis that a ring of an axisymmetric gel exerts.
        exchange.bulge_impulse -= touch.growth * touch.impulse;
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

/// Records an impulse on a body: its sum, direction and time, the depth and the window of the peak force.
fn record_impulse<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    body: usize,
    impulse: Vector3,
    time: f64,
) {
    let depth = depth_in_gel(system, body);
    let width = system.model.settings.force_window;
    system.state.record.outside.add(&-impulse, time);
    let record = &mut system.state.record.contacts[body];
    record.impulse += impulse;
    record.direction = impulse.try_normalize(0.0).unwrap_or(record.direction);
    record.touched = Some((record.touched.map_or(time, |touched| touched.0), time));
    if depth > record.peak_depth.0 {
        record.peak_depth = (depth, time);
    }
    let window = (time / width) as u64;
    let (number, sum, greatest) = record.window;
    let sum = if window == number { sum + impulse } else { impulse };
    record.window = (window, sum, greatest.max(sum.norm()));
}

/// Posts the work of the contact impulses, Σ J (u⁻ + u⁺)/2, without its part Σ J b that removes penetration;
/// that part; and the work of friction, Σ Jₜ·(u⁻ + u⁺)/2. Also posts the work of the support of a body that is
/// not free and of a growing dome.
pub(super) fn post_contact_work<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let touches = std::mem::take(&mut system.workspace.contact_points);
    let mut reaction = ConstraintReaction::default();
    for touch in touches.iter().filter(|touch| touch.impulse > 0.0) {
        let j = touch.impulse;
        let (rigid, now) = (&system.model.bodies[touch.body], &system.workspace.bodies_after[touch.body]);
        let relative =
            touch.relative_velocity(&rigid.velocity_at(now, &touch.point), |node| system.state.velocity[node.index()]);
        let mean = 0.5 * (touch.before + relative);
        let removal = j * touch.bias;
        system.state.ledger.energy.contact += j * touch.normal.dot(&mean) - removal;
        system.state.ledger.energy.contact_bias += removal;
        system.state.ledger.energy.friction += touch.drag.dot(&mean);
        system.state.ledger.energy.external += touch.push().dot(&touch.swell);
        for (node, w) in touch.carriers() {
            let (at, push) = (embed(&system.state.position[node.index()]), touch.push() * w);
            reaction.add(&system.model.gel.free(node.index()), system.freedom(), at, push);
        }
        if system.model.bodies[touch.body].motion != BodyMotion::Free {
            post_support_reaction(system, touch);
        }
    }
    reaction.post(&mut system.state.ledger);
    system.workspace.contact_points = touches;
    post_symmetry_work(system);
    post_self_contact_work(system);
}

/// Posts the momentum and work of the support that holds or moves a body.
fn post_support_reaction<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, touch: &ContactPoint<D>) {
    let (freedom, push, body) = (system.freedom(), touch.push(), touch.body);
    let work = push.dot(&system.model.bodies[body].velocity_at(&system.workspace.bodies_before[body], &touch.point));
    let ledger = &mut system.state.ledger;
    ledger.energy.external += work;
    ledger.momentum.external += freedom.translation(&push);
    ledger.angular_momentum.external += freedom.rotation(&touch.point.cross(&push));
}

/// Posts the work of the symmetry contacts, Σ J (u⁻ + u⁺)/2, and their momentum, which the plane's restraint
/// gives.
fn post_symmetry_work<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let mut taken = ConstraintReaction::default();
    for SymmetryContact { node, axis, before, impulse, .. } in &system.workspace.symmetry_contacts {
        let a = node.index();
        system.state.ledger.energy.contact += 0.5 * impulse * (before + system.state.velocity[a][*axis]);
        let push = embed(&Vector::<D>::from_fn(|i, _| if i == *axis { *impulse } else { 0.0 }));
        taken.add_reaction(system.freedom(), embed(&system.state.position[a]), push);
    }
    taken.post(&mut system.state.ledger);
}

/// Posts the work of the contacts of the gel with itself, Σ J (u⁻ + u⁺)/2, and the momentum that the restraints of their
/// nodes give.
fn post_self_contact_work<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>) {
    let (mut taken, time) = (ConstraintReaction::default(), system.workspace.bodies_before[0].time);
    for contact in system.workspace.self_contacts.iter().filter(|contact| contact.impulse > 0.0) {
        let after = contact.separation_velocity(|node| system.state.velocity[node.index()]);
        system.state.ledger.energy.self_contact += 0.5 * contact.impulse * (contact.before + after);
        for (node, s) in contact.carriers() {
            let (at, push) = (system.position_at(node, time), contact.push() * s);
            taken.add(&system.model.gel.free(node.index()), system.freedom(), embed(&at), embed(&push));
        }
    }
    taken.post(&mut system.state.ledger);
}
