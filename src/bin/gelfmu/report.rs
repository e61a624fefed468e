//! `gelfmu report`: the report of a finished run, made from the files in its folder.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::measured::{self, MeasuredTable};
use crate::report_options::ReportFolderOptions;
use crate::source;
use ballistic_gel::output::{self, REPORT, ResultFolder, SCENE, SavedRunError, UnitSystem};
use ballistic_gel::scene::Scene;
use serde_json::json;
use std::path::Path;

/// Makes the report of a folder and prints its path.
pub fn report(options: &ReportFolderOptions, console: &Console) -> Result<(), CommandError> {
    let folder = &options.folder;
    let scene_file = folder.join(SCENE);
    if !scene_file.is_file() {
        let found = format!("found no {SCENE} in {}", folder.display());
        return Err(CommandError::BadInput(format!(
            "report: {found}, expected a folder that gelfmu run or an FMU has written"
        )));
    }
    let measured = options.report.measured.as_deref().map(measured::read).transpose()?;
    if let Some(table) = &measured {
        console.notes(&table.notes);
    }
    let source = source::load(&scene_file.to_string_lossy(), &[])?;
    let residuals = write(folder, &source.scene, measured.as_ref(), options.units.system())?;
    console.notes(&residuals);
    let page = folder.join(REPORT);
    console.result(&json!({ "file": page, "residuals": residuals }), &page.display().to_string());
    Ok(())
}

/// Writes the report of a run of this scene into its folder, with the curves of a laboratory. Returns their residuals in
/// sentences.
pub fn write(
    folder: &Path,
    scene: &Scene,
    measured: Option<&MeasuredTable>,
    units: UnitSystem,
) -> Result<Vec<String>, RunError> {
    let page = output::report_page(folder, scene).map_err(RunError::from)?;
    let mut results = ResultFolder::reopen(folder, output::RUN)?;
    let Some(table) = measured else {
        results.write(REPORT, page.as_bytes())?;
        return Ok(vec![]);
    };
    let comparison = measured::compare(table, folder, units)?;
    results.write(REPORT, comparison.insert_into(&page).as_bytes())?;
    Ok(comparison.residuals)
}

impl From<SavedRunError> for RunError {
    fn from(error: SavedRunError) -> Self {
        match error {
            SavedRunError::Read { path, source } => Self::File { verb: "read", path, source },
            other => Self::Results(other.to_string()),
        }
    }
}
