//! Exit of bodies through the back face of the gel, and the end of the integration of the gel once they have left.
//!
//! Exits are found at ticks, never at communication points: a saved state, a thread or another communication step
//! changes no bit of them.

use crate::contact::{BodyMotion, BodyState, RigidBody};
use crate::state::{ContactRecord, ExitRecord};

/// Exit rule: the face through which bodies leave a gel, and how long it is integrated after that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExitRule {
    /// Height of the undisturbed back face, m; negative.
    pub back_face: f64,
    /// Half width of the back face along x and along y, m: a body that passes beside it has left at a side.
    pub half_width: [f64; 2],
    /// Time from the exit of the projectile until the gel is put to rest, s; infinite if it never is.
    pub rest_after: f64,
}

/// Fraction of its exit speed that a body must keep to be away from the gel. Gel drawn out behind the back face could
/// otherwise hold the body, slow it down and bring it back.
const KEPT_SPEED: f64 = 0.5;

impl ExitRule {
    /// Creates the exit record of a body whose rear end is at `height` ≤ 0 relative to the back face, m, and was
    /// higher at the last tick.
    fn exit_of(body: &RigidBody, at: &BodyState, height: f64, contact: &ContactRecord) -> ExitRecord {
        let first = contact.touched.map_or(at.time, |touched| touched.0);
        let elapsed = if at.velocity.z < 0.0 { height / at.velocity.z } else { 0.0 };
        ExitRecord {
            time: (at.time - elapsed).max(first),
            velocity: at.velocity,
            residual_energy: body.kinetic_energy(at),
            energy_deposited: -contact.work,
        }
    }

    /// Returns true if a body below the back face is not beside it.
    fn is_behind(&self, at: &BodyState) -> bool {
        at.position.x.abs() <= self.half_width[0] && at.position.y.abs() <= self.half_width[1]
    }

    /// Updates the exit record of a body; a body that comes back has not left.
    pub(super) fn update(&self, body: &RigidBody, at: &BodyState, contact: &mut ContactRecord) {
        let can_leave = body.motion != BodyMotion::Fixed && at.active && contact.touched.is_some();
        if !can_leave || (contact.exit.is_none() && at.position.z > self.back_face) {
            return;
        }
        let height = body.rear(at) - self.back_face;
        contact.exit = match contact.exit {
            None if height <= 0.0 && self.is_behind(at) => Some(Self::exit_of(body, at, height, contact)),
            exit => exit.filter(|_| height <= 0.0),
        };
    }
}

/// Returns true if a body no longer meets the gel: it is held, has left at the back and keeps its speed, or moves up
/// above the entry surface. An inactive body may be made active at any time.
pub(super) fn is_away(body: &RigidBody, at: &BodyState, contact: &ContactRecord) -> bool {
    let keeps = |exit: ExitRecord| exit.velocity.z < 0.0 && at.velocity.z <= KEPT_SPEED * exit.velocity.z;
    let is_above = || at.velocity.z > 0.0 && body.depth(at) < 0.0;
    body.motion == BodyMotion::Fixed || (at.active && contact.exit.map_or_else(is_above, keeps))
}
