//! Sets of outputs of a packed FMU on the command line.

use ballistic_gel::fmi2::OutputSet;
use clap::ValueEnum;

/// Set of outputs of a packed FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum OutputChoice {
    /// State of each body at the end of the step, its depth, contact and perforation
    Integrated,
    /// Impulses on each body, its orientation at the end of the step, and its depth
    Corrected,
    /// All that can be an output
    Full,
}

impl From<OutputChoice> for OutputSet {
    fn from(choice: OutputChoice) -> Self {
        match choice {
            OutputChoice::Integrated => Self::Integrated,
            OutputChoice::Corrected => Self::Corrected,
            OutputChoice::Full => Self::Full,
        }
    }
}
