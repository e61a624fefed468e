//! Answers to commands that are ones of the Python package.

use crate::failure::CommandError;

/// Returns the error of a command that the Python package has, with the command to use and what to install.
pub fn refuse(command: &str, present: &str) -> CommandError {
    CommandError::BadInput(format!(
        "gelfmu {command}: found a command of many runs, expected `python -m ballistic_gel {present}` of the Python \
         package, whose functions also run on Dask, SLURM or Ray: pip install \"ballistic-gel[sweep]\""
    ))
}
