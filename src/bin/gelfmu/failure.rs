//! Why the command ends without doing what it was asked to.

use crate::job::RunError;

/// A failure with its exit status.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The user can put it right in the command line or the scene.
    #[error("{0}")]
    BadInput(String),
    /// The run ended before what was asked for.
    #[error("{0}")]
    Stopped(String),
    /// The run could not be carried out.
    #[error("{0}")]
    Run(RunError),
}

impl Failure {
    /// Exit status: 2 for bad input, 1 for what else went wrong.
    pub fn code(&self) -> u8 {
        match self {
            Self::BadInput(_) => 2,
            Self::Run(_) | Self::Stopped(_) => 1,
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Scene(error) => Self::BadInput(error.to_string()),
            RunError::Build(error) => Self::BadInput(error.to_string()),
            other => Self::Run(other),
        }
    }
}
