//! Errors of a command and their exit statuses.

use crate::job::RunError;

/// Error that ends a command.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// Bad input: the user can correct the command line or the scene.
    #[error("{0}")]
    BadInput(String),
    /// The run ended before its end time.
    #[error("{0}")]
    Stopped(String),
    /// The run could not be carried out.
    #[error("{0}")]
    Run(RunError),
}

impl CommandError {
    /// Returns the exit status: 2 for bad input, 1 for every other error.
    pub fn code(&self) -> u8 {
        match self {
            Self::BadInput(_) => 2,
            Self::Run(_) | Self::Stopped(_) => 1,
        }
    }
}

impl From<RunError> for CommandError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Scene(error) => Self::BadInput(error.to_string()),
            RunError::Build(error) => Self::BadInput(error.to_string()),
            other => Self::Run(other),
        }
    }
}
