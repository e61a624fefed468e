//! Contact bodies: rigid bodies, and the impulse between a body and a surface node.

mod body;
mod bulge;
mod exchange;
mod law;
mod motion;

pub use body::{BodyMotion, FreeDirections, RigidBody};
pub use bulge::DomeMotion;
pub use exchange::ImpulseExchange;
pub use law::{ImpulseLaw, impulse, reversal};
pub use motion::{BodyState, Wrench, WrenchWork};
