//! The asynchronous variational integrator.
mod error;
pub use error::StepError;
