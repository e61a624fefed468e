//! Exit of bodies through the back face of the gel, and the end of the integration of the gel once they have left.
//!
//! Exits are found at ticks, never at communication points: a saved state, a thread or another communication step
//! changes no bit of them.
//!
//! The back face moves with the block. Velocities and energies are those in the inertial frame in which the block was
//! at rest at the start: a chronograph behind the block stands there.

use super::{ExitRule, GelFrame};
use crate::contact::{BodyMotion, BodyState, RigidBody};
use crate::state::{ContactRecord, ExitRecord, OutsideImpulse};

/// Fraction of its exit speed that a body must keep to be away from the gel. Gel drawn out behind the back face could
/// otherwise hold the body, slow it down and bring it back.
const KEPT_SPEED: f64 = 0.5;

/// Body at a time, with what has happened to it: from this its exit is found.
#[derive(Debug, Clone, Copy)]
pub struct BodyExit<'a> {
    /// Body.
    pub rigid: &'a RigidBody,
    /// State of the body.
    pub at: &'a BodyState,
    /// Frame of the block.
    pub frame: &'a GelFrame,
    /// Impulse on the gel from outside, by which the block has moved.
    pub outside: &'a OutsideImpulse,
    /// Contact of the body so far.
    pub contact: &'a ContactRecord,
}

impl BodyExit<'_> {
    /// Returns the body as it is seen from the block.
    fn seen(&self) -> BodyState {
        self.frame.motion(self.outside, self.at.time).seen_from(self.at)
    }

    /// Returns the exit record of the body after a tick, if it has left; a body that comes back has not.
    #[must_use]
    pub fn after_tick(&self, rule: &ExitRule) -> Option<ExitRecord> {
        let Self { rigid, at, contact, .. } = self;
        let (seen, exit) = (self.seen(), contact.exit);
        let can_leave = rigid.motion != BodyMotion::Fixed && at.active && contact.touched.is_some();
        if !can_leave || (exit.is_none() && seen.position.z > rule.back_face) {
            return exit;
        }
        let height = rigid.rear(&seen) - rule.back_face;
        match exit {
            None if height <= 0.0 && rule.is_behind(&seen) => {
                let elapsed = if seen.velocity.z < 0.0 { height / seen.velocity.z } else { 0.0 };
                Some(self.exit_record(at.time - elapsed))
            }
            exit => exit.filter(|_| height <= 0.0),
        }
    }

    /// Creates the exit record of a body that has passed the back face at a time, s, since the last tick.
    fn exit_record(&self, time: f64) -> ExitRecord {
        let Self { rigid, at, contact, .. } = self;
        let start = &self.frame.initial_velocity;
        let seen = BodyState { velocity: at.velocity - start, ..**at };
        ExitRecord {
            time: time.max(contact.touched.map_or(at.time, |touched| touched.0)),
            velocity: seen.velocity,
            residual_energy: rigid.kinetic_energy(&seen),
            energy_deposited: contact.energy_given(start),
        }
    }

    /// Returns true if the body no longer meets the gel: it is held, has left at the back and keeps its speed, or moves
    /// up above the entry surface. An inactive body may be made active at any time.
    #[must_use]
    pub fn is_away(&self) -> bool {
        let Self { rigid, at, .. } = self;
        let seen = self.seen();
        let speed = at.velocity.z - self.frame.initial_velocity.z;
        let keeps = |exit: ExitRecord| exit.velocity.z < 0.0 && speed <= KEPT_SPEED * exit.velocity.z;
        let is_above = || seen.velocity.z > 0.0 && rigid.depth(&seen) < 0.0;
        rigid.motion == BodyMotion::Fixed || (at.active && self.contact.exit.map_or_else(is_above, keeps))
    }
}
