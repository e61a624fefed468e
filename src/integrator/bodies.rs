//! Bodies between their events: their motion to a tick, changes from outside, and the depth that counts in the gel.

use super::system::DiscreteSystem;
use crate::contact::BodyState;
use crate::fem::Potential;

/// Moves the bodies to a time, s, as they are before the impulses of the tick.
pub(super) fn place_bodies<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, time: f64) {
    let workspace = &mut system.workspace;
    workspace.bodies_before.clear();
    workspace
        .bodies_before
        .extend(system.model.bodies.iter().zip(&system.state.bodies).map(|(body, last)| last.at(body, time)));
    workspace.bodies_after.clone_from(&workspace.bodies_before);
}

/// Moves a body to time `t`, s, as an event and posts the work of its wrench.
pub(super) fn rebase_body<const D: usize, P: Potential<D>>(system: &mut DiscreteSystem<D, P>, body: usize, t: f64) {
    let (fixed, state) = (&system.model.bodies[body], &mut system.state.bodies[body]);
    let next = state.at(fixed, t);
    state.passage(fixed, &next).post(&mut system.state.ledger);
    *state = next;
}

/// Replaces a body's state or wrench at its own time, as an event; the caller posts the change to the ledger.
pub(super) fn set_body<const D: usize, P: Potential<D>>(
    system: &mut DiscreteSystem<D, P>,
    body: usize,
    state: &BodyState,
) {
    system.state.bodies[body] = *state;
    (system.clock.quiet_until, system.contact.knows_bodies) = (None, false);
}

/// Returns the depth of a body at its last event below the undeformed entry surface, m, at most that of the back face.
pub(super) fn depth_in_gel<const D: usize, P: Potential<D>>(system: &DiscreteSystem<D, P>, body: usize) -> f64 {
    let at = &system.state.bodies[body];
    let depth = system.model.bodies[body].depth(&system.block_motion(at.time).seen_from(at));
    system.clock.ends.exits.map_or(depth, |rule| depth.min(-rule.back_face))
}
