//! Exit of bodies through the back face of the gel, and the end of the integration of the gel once they have left.
//!
//! Exits are found at ticks, never at communication points: a saved state, a thread or another communication step
//! changes no bit of them.
//!
//! The back face moves with the block. Velocities and energies are those in the inertial frame in which the block was
//! at rest at the start: a chronograph behind the block stands there.

use super::end_conditions::ExitRule;
use super::system::DiscreteSystem;
use crate::contact::{BodyMotion, BodyState};
use crate::fem::Potential;
use crate::state::ExitRecord;

/// Fraction of its exit speed that a body must keep to be away from the gel. Gel drawn out behind the back face could
/// otherwise hold the body, slow it down and bring it back.
const KEPT_SPEED: f64 = 0.5;

/// Updates the exit record of a body at a tick; a body that comes back has not left.
pub(super) fn update_exit<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    rule: &ExitRule,
    body: usize,
) {
    let (rigid, at) = (&system.model.bodies[body], &system.workspace.bodies_after[body]);
    let (seen, exit) = (system.block_motion(at.time).seen_from(at), system.state.record.contacts[body].exit);
    let can_leave =
        rigid.motion != BodyMotion::Fixed && at.active && system.state.record.contacts[body].touched.is_some();
    if !can_leave || (exit.is_none() && seen.position.z > rule.back_face) {
        return;
    }
    let height = rigid.rear(&seen) - rule.back_face;
    let exit = match exit {
        None if height <= 0.0 && rule.is_behind(&seen) => {
            let elapsed = if seen.velocity.z < 0.0 { height / seen.velocity.z } else { 0.0 };
            Some(exit_record(system, body, at.time - elapsed))
        }
        exit => exit.filter(|_| height <= 0.0),
    };
    system.state.record.contacts[body].exit = exit;
}

/// Creates the exit record of a body that has passed the back face at a time, s, since the last tick.
fn exit_record<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, body: usize, time: f64) -> ExitRecord {
    let (at, contact) = (&system.workspace.bodies_after[body], &system.state.record.contacts[body]);
    let start = &system.model.frame.initial_velocity;
    let seen = BodyState { velocity: at.velocity - start, ..*at };
    ExitRecord {
        time: time.max(contact.touched.map_or(at.time, |touched| touched.0)),
        velocity: seen.velocity,
        residual_energy: system.model.bodies[body].kinetic_energy(&seen),
        energy_deposited: contact.energy_given(start),
    }
}

/// Returns true if a body no longer meets the gel: it is held, has left at the back and keeps its speed, or moves up
/// above the entry surface. An inactive body may be made active at any time.
pub(super) fn is_away<const D: usize, P: Potential<D>>(
    system: &DiscreteSystem<D, P>,
    body: usize,
    at: &BodyState,
) -> bool {
    let (rigid, start) = (&system.model.bodies[body], &system.model.frame.initial_velocity);
    let seen = system.block_motion(at.time).seen_from(at);
    let speed = at.velocity.z - start.z;
    let keeps = |exit: ExitRecord| exit.velocity.z < 0.0 && speed <= KEPT_SPEED * exit.velocity.z;
    let is_above = || seen.velocity.z > 0.0 && rigid.depth(&seen) < 0.0;
    let exit = system.state.record.contacts[body].exit;
    rigid.motion == BodyMotion::Fixed || (at.active && exit.map_or_else(is_above, keeps))
}
