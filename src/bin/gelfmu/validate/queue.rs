//! Queue of cases: concurrent runs of `gelfmu run`, and the rows kept in the folder.

use super::case::ShotCase;
use super::row::CaseRow;
use crate::failure::{CommandError, RunError};
use crate::interrupt;
use crate::progress::ProgressDisplay;
use crate::trade::file_failure;
use ballistic_gel::fmi2::SOURCE_STAMP;
use ballistic_gel::output::{MOST_TABLE_BYTES, ResultFolder, read_limited_text};
use ballistic_gel::scene;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// Name of the folder of the rows inside that of the validation.
pub const ROWS_FOLDER: &str = "rows";
/// Polling interval of the processes.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Case with its row, or the reason why there is none.
pub struct FinishedCase {
    /// Case.
    pub case: ShotCase,
    /// Figures of the run.
    pub row: Result<CaseRow, String>,
}

/// Run in progress.
struct RunningCase {
    case: ShotCase,
    file: String,
    folder: TempDir,
    child: Child,
}

/// Runs all cases without a kept row, `jobs` at a time; interrupted runs are not returned.
pub fn run_cases(
    cases: Vec<ShotCase>,
    jobs: usize,
    folder: &mut ResultFolder,
    bar: &ProgressDisplay,
) -> Result<Vec<FinishedCase>, CommandError> {
    let (mut finished, mut waiting) = (vec![], vec![]);
    for case in cases {
        let text = case.scene_text()?;
        let file = format!("{ROWS_FOLDER}/{:032x}.json", row_hash(&text)?);
        match kept_row(folder, &file) {
            Some(row) => finished.push(FinishedCase { case, row: Ok(row) }),
            None => waiting.push((case, text, file)),
        }
    }
    let (total, mut waiting, mut running) = (waiting.len(), waiting.into_iter(), Vec::<RunningCase>::new());
    let mut done = 0;
    loop {
        while running.len() < jobs && !interrupt::asked() {
            let Some((case, text, file)) = waiting.next() else { break };
            running.push(start(case, file, &text)?);
        }
        if running.is_empty() {
            return Ok(finished);
        }
        std::thread::sleep(POLL_INTERVAL);
        if interrupt::asked() {
            return Ok(finished);
        }
        let labels: Vec<String> = running.iter().map(|run| run.case.label()).collect();
        bar.show_task(&labels.join(" | "), f64::from(done) / total as f64);
        for mut run in std::mem::take(&mut running) {
            match run.child.try_wait().map_err(file_failure("wait for", run.folder.path()))? {
                None => running.push(run),
                Some(status) => {
                    done += 1;
                    finished.push(collect(&run, status, folder)?);
                }
            }
        }
    }
}

/// Hashes what decides a row: the scene without its comments, and the sources of the solver.
fn row_hash(text: &str) -> Result<u128, CommandError> {
    let scene = scene::read(text).map_err(RunError::from)?;
    let scene = serde_json::to_string(&scene).expect("a scene consists of tables, numbers and text");
    Ok(xxhash_rust::xxh3::xxh3_128(format!("{SOURCE_STAMP} {scene}").as_bytes()))
}

fn kept_row(folder: &ResultFolder, file: &str) -> Option<CaseRow> {
    let text = folder.owns(file).then(|| read_limited_text(&folder.place(file), MOST_TABLE_BYTES).ok()).flatten()?;
    serde_json::from_str(&text).ok()
}

/// Starts `gelfmu run` of a case in a temporary folder.
fn start(case: ShotCase, file: String, text: &str) -> Result<RunningCase, CommandError> {
    let folder = tempfile::tempdir().map_err(file_failure("make", &std::env::temp_dir()))?;
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, text).map_err(file_failure("write", &scene))?;
    let program = std::env::current_exe().map_err(file_failure("find", Path::new("gelfmu")))?;
    let mut command = Command::new(program);
    command.args(["run", "--quiet", "--direct", "--no-frames", "--no-report", "--threads", "1", "--out"]);
    command.arg(results(&folder)).arg(&scene);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let child = command.spawn().map_err(file_failure("start a run of", &scene))?;
    Ok(RunningCase { case, file, folder, child })
}

fn results(folder: &TempDir) -> PathBuf {
    folder.path().join("results")
}

/// Reads the figures of a finished run and keeps its row, unless the run was ended from outside.
fn collect(run: &RunningCase, status: ExitStatus, folder: &mut ResultFolder) -> Result<FinishedCase, CommandError> {
    let text = read_limited_text(&results(&run.folder).join("summary.json"), MOST_TABLE_BYTES);
    let summary = text.map_err(|error| format!("the run wrote no summary: {error}"));
    let row = summary.and_then(|text| {
        let summary = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        CaseRow::of(&run.case, &summary).ok_or_else(|| "a figure is missing in the summary".to_owned())
    });
    if let Ok(row) = &row
        && status.code().is_some_and(|code| code != i32::from(interrupt::INTERRUPTED))
    {
        let text = serde_json::to_string_pretty(row).expect("numbers and text can be written");
        let kept = folder.write(&run.file, text.as_bytes()).and_then(|()| folder.begin());
        kept.map_err(RunError::from)?;
    }
    Ok(FinishedCase { case: run.case.clone(), row })
}

impl Drop for RunningCase {
    /// Ends the process, unless it has ended already, before its folder is removed.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
