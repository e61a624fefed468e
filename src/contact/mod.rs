//! Contact bodies: rigid bodies, and the impulse between a body and a surface node.

mod body;
mod bulge;
mod exchange;
mod law;
mod motion;

pub use body::{Body, Freedom, Motion};
pub use bulge::Bulge;
pub use exchange::Exchange;
pub use law::{Law, impulse, reversal};
pub use motion::{BodyState, Wrench, WrenchWork};
