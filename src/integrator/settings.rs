//! Settings of the integrator, and the error of a stable step that cannot be used.

use super::SteppingSchedule;
use crate::contact::ImpulseLaw;
use crate::math::Vector3;

/// Settings of the integrator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegratorSettings {
    /// Schedule: the rule by which patches share ticks.
    pub schedule: SteppingSchedule,
    /// CFL number: fraction of the stable step that a patch takes.
    pub cfl: f64,
    /// Contact law for impulses.
    pub law: ImpulseLaw,
    /// Width of the averaging window of the peak force, s.
    pub force_window: f64,
    /// Damping coefficient α of nodal speeds, exp(−αt), 1/s.
    pub damping: f64,
}

/// Error: a stable step is unusable, because it is not a number, is shorter than a tick or exceeds [`MOST_TICKS`](crate::state::MOST_TICKS)
/// ticks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "the stable step of an element is {step:e} s: the ratio of stiffness to mass is out of range, or there is no \
     element"
)]
pub struct UnusableStep {
    /// Stable step, s.
    pub step: f64,
    /// Positions of the nodes of the stiffest element at a node whose step is shorter than a tick, m; empty for
    /// other causes.
    pub corners: Vec<Vector3>,
}
