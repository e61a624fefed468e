//! The rigid projectile, and the impulse between it and a surface node.

mod body;
mod exchange;
mod law;
mod motion;

pub use body::{Body, Freedom, Motion};
pub use exchange::Exchange;
pub use law::{Law, impulse, reversal};
pub use motion::{BodyState, Passage, Wrench};
