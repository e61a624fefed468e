//! A run through the packed FMU, as an importer does it.

use crate::job::{Ending, Job, Progress, RunError};

/// Runs the job through the packed FMU.
pub fn run(_job: &Job, _progress: &mut Progress<'_>) -> Result<Ending, RunError> {
    Err(RunError::Component { call: "fmi2Instantiate", reason: "this build holds no packed library".to_owned() })
}
