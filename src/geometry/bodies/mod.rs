//! Signed distances of analytic bodies.

mod dome;
mod expanding;
mod half_space;
mod outline;
mod piece;
mod plate;
mod profile;
mod sphere;

pub use dome::Dome;
pub use expanding::ExpandingProfile;
pub use half_space::HalfSpace;
pub use outline::ProfileOutline;
pub use plate::RoundedCuboid;
pub use profile::{ProfileBody, ProfileSweep};
pub use sphere::Sphere;
