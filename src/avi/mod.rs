//! The asynchronous variational integrator: every patch of elements at its own time step (numerics 1).

mod engine;
mod error;
mod facet;
mod forces;
mod gel;
mod grid;
mod impact;
mod kick;
mod pace;
mod pierce;
mod pool;
mod report;
mod schedule;

pub use engine::{Engine, Rules};
pub use error::StepError;
pub use gel::{Gel, Surface, SurfaceNode};
pub use grid::TickGrid;
pub use pool::Pool;
pub use report::{Energies, Totals};
pub use schedule::Kind;
