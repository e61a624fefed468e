//! Errors of a command and their exit statuses.

use ballistic_gel::fmi2::MemoryShortage;
use ballistic_gel::output::OutputError;
use ballistic_gel::scene::SceneError;
use ballistic_gel::simulation::BuildError;
use std::path::PathBuf;

/// Errors that prevent a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The memory is too small.
    #[error(transparent)]
    Memory(#[from] MemoryShortage),
    /// The results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A file cannot be used.
    #[error("cannot {verb} {}: {source}", path.display())]
    File {
        /// Attempted action, a verb.
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The results of a run cannot be used.
    #[error("{0}")]
    Results(String),
    /// The FMU answered a call with an error.
    #[error("the FMU failed in {call}: {reason}")]
    Component {
        /// Name of the FMI function.
        call: &'static str,
        /// Message that the FMU logged.
        reason: String,
    },
}

/// Error that ends a command.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// Bad input: the user can correct the command line or a file.
    #[error("{0}")]
    BadInput(String),
    /// Invalid scene: the user can correct it at the key of the error.
    #[error("{place}{error}")]
    Scene {
        /// Scene and overrides at fault, before the message.
        place: String,
        /// Key, value found and values expected.
        error: Box<SceneError>,
    },
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
            Self::BadInput(_) | Self::Scene { .. } => 2,
            Self::Run(_) | Self::Stopped(_) => 1,
        }
    }
}

impl From<RunError> for CommandError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Scene(error) => Self::Scene { place: String::new(), error: Box::new(error) },
            RunError::Build(error) => Self::BadInput(error.to_string()),
            other => Self::Run(other),
        }
    }
}
