//! Reduced model of a shot about an axis: a penetration law and a cavity of rings stand for the finite elements.
//!
//! - `coefficients`: the coefficients of a class of bodies in one gel, as they are identified from runs of the full model.
//! - `penetration`: the resistance of the gel to the nose.
//! - `rings`: the cavity behind the body.
//! - `target`: the gel in time, at ticks of its own; `state`: its dynamic state as a value.

mod coefficients;
mod penetration;
mod rings;
mod state;
mod target;

pub use coefficients::{BodyClass, IdentifiedClass, IdentifiedRange, ReducedCoefficients};
pub use penetration::PenetrationLaw;
pub use rings::{CavityRing, RingLaw};
pub use state::ReducedState;
pub use target::{CavityOpening, ReducedTarget, TargetBlock};
