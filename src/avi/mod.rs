//! The asynchronous variational integrator: every patch of elements at its own time step (numerics 1).

mod blocks;
mod damping;
mod engine;
mod error;
mod facet;
mod gel;
mod grid;
mod impact;
mod kick;
mod load;
mod near;
mod nodes;
mod order;
mod pace;
mod phase;
mod pierce;
mod pool;
mod reference;
mod renew;
mod report;
mod schedule;
mod scratch;
mod sweep;
mod tick;
mod watch;
mod work;

pub use engine::{Engine, NoStep, Rules};
pub use error::StepError;
pub use gel::{Gel, Measured, Surface, SurfaceNode};
pub use grid::TickGrid;
pub use load::{Loaded, Loads, Pressure};
pub use pool::Pool;
pub use renew::{Reached, Wear};
pub use report::{Energies, Totals};
pub use schedule::Kind;
pub use work::Run;
