//! Orientation steps of tumbling bodies: their period, and the spin that a gel cannot follow.

use super::StepError;
use super::grid::floor_power_of_two;
use super::model::DiscreteModel;
use crate::contact::BodyState;
use crate::state::{DynamicState, Tick};

/// Largest angle that a tumbling body turns by in one step of its orientation, rad. At 0.05 the axis of a rod that
/// spins at 20 000 rad/s and nods by 25° is off by 0.005° after a millisecond; at the steps of a coarse gel (1.2) by
/// 2.5°.
const MAX_TURN: f64 = 0.05;

/// Longest step of the orientation, ticks: a body under torque keeps its angular velocity for no longer.
const MAX_ORIENTATION_STEP: f64 = 4096.0;

/// Returns the next tick at which the orientation of a tumbling body is stepped; `None` for other bodies.
///
/// It is the first multiple of the period after both the body's last event and the present tick. The period is the
/// longest power of two of ticks in which the body turns by at most [`MAX_TURN`].
pub(super) fn next_orientation_step<const D: usize, P>(
    model: &DiscreteModel<D, P>,
    state: &DynamicState<D>,
    body: usize,
) -> Option<Tick> {
    let now = state.now?;
    let (rigid, body) = (&model.bodies[body], &state.bodies[body]);
    if !rigid.needs_orientation_steps(body) {
        return None;
    }
    let rate = rigid.angular_velocity(body).norm();
    let longest = model.grid.ticks(MAX_TURN / rate).clamp(1.0, MAX_ORIENTATION_STEP);
    let period = floor_power_of_two(longest) as Tick;
    let last = (model.grid.ticks(body.time).floor() as Tick).max(now);
    Some((last / period + 1) * period)
}

/// Fails if an active body turns by more than [`MAX_TURN`] in one tick: the surface near it would have to be stepped at every
/// tick, about a thousand times in the step of an element, and would still not follow the body.
pub(super) fn check_spin<const D: usize, P>(
    model: &DiscreteModel<D, P>,
    body: usize,
    at: &BodyState,
) -> Result<(), StepError> {
    let rate = model.bodies[body].angular_velocity(at).norm();
    let turn = rate * model.grid.time(1);
    let follows = turn <= MAX_TURN || !at.active;
    if follows { Ok(()) } else { Err(StepError::Spun { body, time: at.time, rate, turn, most: MAX_TURN }) }
}
