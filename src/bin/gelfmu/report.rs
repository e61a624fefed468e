//! `gelfmu report`: the report of a finished run, made from the files in its folder, and a page that compares several.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::measured::{self, MeasuredTable};
use crate::report_options::ReportFolderOptions;
use crate::{results, source};
use ballistic_gel::output::{self, REPORT, ReportIdentity, ReportRun, ResultFolder, SCENE, SavedRunError, UnitSystem};
use ballistic_gel::scene::Scene;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Makes the report of a folder, or of several on one page, and prints its path.
pub fn report(options: &ReportFolderOptions, console: &Console) -> Result<(), CommandError> {
    match &options.folders[..] {
        [folder] => report_folder(folder, options, console),
        folders => compare_folders(folders, options, console),
    }
}

/// Makes the report of one run.
fn report_folder(folder: &Path, options: &ReportFolderOptions, console: &Console) -> Result<(), CommandError> {
    options.out.as_deref().map_or(Ok(()), |file| check_out(file, options.force))?;
    let identity = options.report.identity()?;
    let scene_file = check_scene_file(folder)?;
    let measured = options.report.measured.as_deref().map(measured::read).transpose()?;
    if let Some(table) = &measured {
        console.notes(&table.notes);
    }
    let scene = source::load(&scene_file.to_string_lossy(), &[])?.scene;
    let units = console.figure_units(options.units.system());
    let page_options = PageOptions { identity: &identity, measured: measured.as_ref(), units };
    let (file, residuals) = match &options.out {
        None => (folder.join(REPORT), write(folder, &scene, &page_options)?),
        Some(file) => {
            let page = page(folder, &scene, &page_options)?;
            write_out(file, &page.html)?;
            (file.clone(), page.residuals)
        }
    };
    console.notes(&residuals);
    console.path_result(&json!({ "file": file, "residuals": residuals }), &file);
    Ok(())
}

/// Makes the page that compares several runs.
fn compare_folders(folders: &[PathBuf], options: &ReportFolderOptions, console: &Console) -> Result<(), CommandError> {
    let refused =
        |found: &str, expected: &str| CommandError::BadInput(format!("report: found {found}, expected {expected}"));
    let several = format!("{} folders", folders.len());
    if folders.len() > ReportRun::MOST {
        return Err(refused(&several, &format!("at most {}: make several pages", ReportRun::MOST)));
    }
    let out = options.out.as_ref().ok_or_else(|| refused(&several, "one, or --out FILE.html for the page of all"))?;
    if options.report.measured.is_some() {
        let expected = "one folder: compare each run with its own measurement";
        return Err(refused(&format!("--measured with {several}"), expected));
    }
    check_out(out, options.force)?;
    let identity = options.report.identity()?;
    let load = |folder: &PathBuf| Ok(source::load(&check_scene_file(folder)?.to_string_lossy(), &[])?.scene);
    let scenes = folders.iter().map(load).collect::<Result<Vec<Scene>, CommandError>>()?;
    let names = run_names(folders);
    let runs = folders.iter().zip(&scenes).zip(&names);
    let runs: Vec<ReportRun> = runs.map(|((folder, scene), name)| ReportRun { name, folder, scene }).collect();
    let page = output::comparison_page(&runs, &identity).map_err(RunError::from)?;
    write_out(out, &page)?;
    console.result(&json!({ "file": out, "runs": names }), &out.display().to_string());
    Ok(())
}

/// Returns the names of folders, or their paths if two have the same name.
fn run_names(folders: &[PathBuf]) -> Vec<String> {
    let name = |folder: &PathBuf| folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let names: Option<Vec<String>> = folders.iter().map(name).collect();
    let is_unique = |names: &Vec<String>| names.iter().collect::<BTreeSet<_>>().len() == names.len();
    names.filter(is_unique).unwrap_or_else(|| folders.iter().map(|folder| folder.display().to_string()).collect())
}

/// Returns the scene file of a folder with results; a folder without one is refused.
fn check_scene_file(folder: &Path) -> Result<PathBuf, CommandError> {
    let scene_file = folder.join(SCENE);
    if scene_file.is_file() {
        return Ok(scene_file);
    }
    let found = format!("found no {SCENE} in {}", folder.display());
    Err(CommandError::BadInput(format!("report: {found}, expected a folder that gelfmu run or an FMU has written")))
}

/// Refuses a file of `--out` that exists, without `--force`.
fn check_out(file: &Path, is_forced: bool) -> Result<(), CommandError> {
    let refused = || {
        let expected = "a new name, or --force";
        CommandError::BadInput(format!("--out {}: found something of this name, expected {expected}", file.display()))
    };
    if file.exists() && !is_forced { Err(refused()) } else { Ok(()) }
}

/// Writes the page into the file of `--out`.
fn write_out(file: &Path, page: &str) -> Result<(), CommandError> {
    Ok(results::replace(file, page.as_bytes())?)
}

/// Options of a page: its identity, measured curves and units.
#[derive(Debug, Clone, Copy)]
pub struct PageOptions<'a> {
    /// Case, author, logo and date.
    pub identity: &'a ReportIdentity,
    /// Curves of a laboratory.
    pub measured: Option<&'a MeasuredTable>,
    /// Units of the residuals on the console.
    pub units: UnitSystem,
}

/// Report of a run with the residuals of measured curves, in sentences.
struct ReportPage {
    html: String,
    residuals: Vec<String>,
}

/// Writes the report of a run of this scene into its folder, with the curves of a laboratory. Returns their residuals in
/// sentences.
pub fn write(folder: &Path, scene: &Scene, options: &PageOptions<'_>) -> Result<Vec<String>, RunError> {
    let page = page(folder, scene, options)?;
    ResultFolder::reopen(folder, output::RUN)?.write(REPORT, page.html.as_bytes())?;
    Ok(page.residuals)
}

/// Makes the report of a run, with the curves of a laboratory, whose residuals are written into its `summary.json`.
fn page(folder: &Path, scene: &Scene, options: &PageOptions<'_>) -> Result<ReportPage, RunError> {
    let html = output::report_page(folder, scene, options.identity)?;
    let Some(table) = options.measured else { return Ok(ReportPage { html, residuals: vec![] }) };
    // Only the folder of a run is changed.
    ResultFolder::reopen(folder, output::RUN)?;
    let comparison = measured::compare(table, folder, options.units)?;
    Ok(ReportPage { html: comparison.insert_into(&html), residuals: comparison.residuals })
}

impl From<SavedRunError> for RunError {
    fn from(error: SavedRunError) -> Self {
        match error {
            SavedRunError::Read { path, source } => Self::File { verb: "read", path, source },
            other => Self::Results(other.to_string()),
        }
    }
}
