//! Bodies between their events: their motion to a tick, and as an event of its own.

use super::workspace::Workspace;
use crate::contact::{BodyState, RigidBody};
use crate::ledger::Ledger;

/// Moves the bodies from their last events to a time, s, as they are before the impulses of the tick.
pub(super) fn place_bodies<const D: usize>(
    workspace: &mut Workspace<D>,
    bodies: &[RigidBody],
    last: &[BodyState],
    time: f64,
) {
    workspace.bodies_before.clear();
    workspace.bodies_before.extend(bodies.iter().zip(last).map(|(body, last)| last.at(body, time)));
    workspace.bodies_after.clone_from(&workspace.bodies_before);
}

/// Moves a body to time `t`, s, as an event and posts the work of its wrench.
pub(crate) fn rebase_body(rigid: &RigidBody, state: &mut BodyState, ledger: &mut Ledger, t: f64) {
    let next = state.at(rigid, t);
    state.passage(rigid, &next).post(ledger);
    *state = next;
}
