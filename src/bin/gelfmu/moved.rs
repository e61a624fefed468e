//! Answers to former commands.

use crate::failure::CommandError;

/// Returns the error of a command that the Python package has, with the command to use and what to install.
pub fn refuse(command: &str, present: &str) -> CommandError {
    CommandError::BadInput(format!(
        "gelfmu {command}: found a command of many runs, expected `python -m ballistic_gel {present}` of the Python \
         package, whose functions also run on Dask, SLURM or Ray: pip install \"ballistic-gel[sweep]\""
    ))
}

/// Returns the error of the command that drew the stages of a remeshing.
pub fn refuse_pictures() -> CommandError {
    CommandError::BadInput(
        "gelfmu remesh-demo: found a former command, expected `python docs/pictures/paper.py GELFMU FOLDER` in a clone of \
         the repository, with cargo, matplotlib and pyvista: it draws the stages of a remeshing of ball-square, figure 6"
            .to_owned(),
    )
}
