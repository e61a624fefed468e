//! Run queue: concurrent processes, and the rows kept in the folder.

use super::curve::TradeRun;
use super::ladder::LadderRung;
use super::row::TradeRow;
use crate::failure::{CommandError, RunError};
use crate::interrupt;
use crate::progress::ProgressDisplay;
use crate::source::SceneSource;
use ballistic_gel::output::{self, ResultFolder};
use ballistic_gel::scene::FidelityLevels;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Size limit of a row file, bytes.
const MOST_ROW_BYTES: u64 = 1 << 20;
/// Polling interval of the processes.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Queue of runs: the folder of their rows and the number of processes.
pub struct RunQueue<'a> {
    /// Folder of the curve, which contains the folder of the rows.
    pub folder: &'a mut ResultFolder,
    /// Number of concurrent processes.
    pub jobs: usize,
    /// Repetitions of each run; the least CPU time counts.
    pub repeats: usize,
    /// Progress bar.
    pub bar: &'a ProgressDisplay,
}

/// Rung with its scene, or the reason why the scene cannot be run.
pub struct PreparedRung {
    /// Rung of the ladder.
    pub rung: LadderRung,
    /// Scene of the rung.
    pub source: Result<SceneSource, CommandError>,
}

/// Name of the rows' folder inside that of the curve.
pub const ROWS_FOLDER: &str = "rows";

/// Pending run with its rung, scene file and row file.
struct RowTask {
    index: usize,
    rung: LadderRung,
    file: String,
    text: PathBuf,
    folder: PathBuf,
    repeats: usize,
}

impl RunQueue<'_> {
    /// Runs every rung without a kept row; interrupted runs are not returned.
    pub fn run_all(&mut self, rungs: Vec<PreparedRung>) -> Result<Vec<TradeRun>, CommandError> {
        let (mut runs, mut tasks) = (vec![], vec![]);
        for (index, PreparedRung { rung, source }) in rungs.into_iter().enumerate() {
            match source {
                Err(refused) => runs.push((index, TradeRun { rung, row: Err(refused.to_string()) })),
                Ok(source) => {
                    let file = format!("{ROWS_FOLDER}/{:032x}.json", row_hash(&rung, &source, self.repeats));
                    match self.read_kept_row(&file)? {
                        Some(row) => runs.push((index, TradeRun { rung, row })),
                        None => tasks.push(self.prepare_task(index, rung, file, &source)?),
                    }
                }
            }
        }
        tasks.sort_by(|a, b| b.rung.expected_cost.total_cmp(&a.rung.expected_cost));
        runs.extend(self.run_tasks(tasks)?);
        runs.sort_by_key(|(index, _)| *index);
        Ok(runs.into_iter().map(|(_, run)| run).collect())
    }

    /// Reads the row of an earlier run from the folder; `None` without a valid row file.
    fn read_kept_row(&self, name: &str) -> Result<Option<Result<TradeRow, String>>, CommandError> {
        if !self.folder.owns(name) {
            return Ok(None);
        }
        let file = self.folder.place(name);
        match output::read_limited_text(&file, MOST_ROW_BYTES) {
            // A truncated file counts as absent.
            Ok(text) => Ok(serde_json::from_str::<Result<TradeRow, String>>(&text).ok()),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(file_failure("read", &file)(error)),
        }
    }

    /// Writes the scene file of a run.
    fn prepare_task(
        &mut self,
        index: usize,
        rung: LadderRung,
        file: String,
        source: &SceneSource,
    ) -> Result<RowTask, CommandError> {
        let name = file.replace(".json", ".toml");
        self.folder.write(&name, source.text.as_bytes()).map_err(RunError::from)?;
        let text = self.folder.place(&name);
        Ok(RowTask { index, rung, file, text, folder: source.folder.clone(), repeats: self.repeats })
    }

    /// Runs the tasks in concurrent processes, until all are done or the user interrupts them.
    fn run_tasks(&mut self, tasks: Vec<RowTask>) -> Result<Vec<(usize, TradeRun)>, CommandError> {
        let (total, mut done) = (tasks.iter().map(|task| task.rung.expected_cost).sum::<f64>(), 0.0);
        let (mut waiting, mut going, mut runs) = (tasks.into_iter(), Vec::<(RowTask, Child)>::new(), vec![]);
        loop {
            while going.len() < self.jobs && !interrupt::asked() {
                let Some(task) = waiting.next() else { break };
                let child = task.start_process()?;
                going.push((task, child));
            }
            if going.is_empty() {
                return Ok(runs);
            }
            std::thread::sleep(POLL_INTERVAL);
            if interrupt::asked() {
                for (_, child) in &mut going {
                    kill_process(child);
                }
                return Ok(runs);
            }
            let names: Vec<String> = going.iter().map(|(task, _)| task.rung.label()).collect();
            self.bar.show_task(&names.join(" | "), done / total);
            for (task, mut child) in std::mem::take(&mut going) {
                let ended = child.try_wait().map_err(file_failure("wait for", &task.text))?;
                if ended.is_none() {
                    going.push((task, child));
                    continue;
                }
                let row = self.collect_row(&task, &mut child)?;
                done += task.rung.expected_cost;
                runs.push((task.index, TradeRun { rung: task.rung, row }));
            }
        }
    }
}

impl RunQueue<'_> {
    /// Reads the outcome of a process and keeps its row in the folder, unless the process was killed.
    fn collect_row(&mut self, task: &RowTask, child: &mut Child) -> Result<Result<TradeRow, String>, CommandError> {
        let row = match task.read_outcome(child)? {
            RowOutcome::Made(row) => row,
            RowOutcome::Lost(how) => return Ok(Err(how)),
        };
        let text = serde_json::to_string_pretty(&row).expect("numbers and text can be written");
        let kept = self.folder.write(&task.file, text.as_bytes()).and_then(|()| self.folder.begin());
        kept.map_err(RunError::from)?;
        Ok(row)
    }
}

/// Hashes everything that decides a row: the scene with every default, the coupling variant and the version.
fn row_hash(rung: &LadderRung, source: &SceneSource, repeats: usize) -> u128 {
    let mut scene = source.scene.clone();
    // Measured accuracy levels do not change a run.
    scene.fidelity = FidelityLevels::default();
    let scene = serde_json::to_string(&scene).expect("a scene consists of tables, numbers and text");
    let read = output::scene_file_reader(&source.folder);
    let files: Vec<Vec<u8>> = source.scene.files().iter().filter_map(|(_, name)| read(name).ok()).collect();
    let again = if repeats == 1 { String::new() } else { repeats.to_string() };
    let all = format!("{}{again} {} {scene} {files:?}", env!("CARGO_PKG_VERSION"), rung.importer.as_str());
    xxhash_rust::xxh3::xxh3_128(all.as_bytes())
}

impl RowTask {
    /// Starts `gelfmu trade-row` for the scene file.
    fn start_process(&self) -> Result<Child, CommandError> {
        let program = std::env::current_exe().map_err(file_failure("find", Path::new("gelfmu")))?;
        let mut command = Command::new(program);
        command.arg("trade-row").arg(&self.text).arg("--folder").arg(self.folder.join("."));
        command.args(["--importer", self.rung.importer.as_str(), "--repeat", &self.repeats.to_string()]);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().map_err(file_failure("start a run of", &self.text))
    }

    /// Reads the output of the process.
    fn read_outcome(&self, child: &mut Child) -> Result<RowOutcome, CommandError> {
        let (mut out, mut complaint) = (String::new(), String::new());
        for (pipe, to) in [
            (child.stdout.as_mut().map(|p| p as &mut dyn Read), &mut out),
            (child.stderr.as_mut().map(|p| p as _), &mut complaint),
        ] {
            pipe.map_or(Ok(0), |pipe| pipe.read_to_string(to)).map_err(file_failure("read from", &self.text))?;
        }
        let status = child.wait().map_err(file_failure("wait for", &self.text))?;
        Ok(match serde_json::from_str::<TradeRow>(&out) {
            Ok(row) => RowOutcome::Made(Ok(row)),
            Err(_) if status.code().is_none() => {
                RowOutcome::Lost(format!("its process was ended from outside: {status}"))
            }
            Err(_) => RowOutcome::Made(Err(complaint.trim().trim_start_matches("error: ").to_owned())),
        })
    }
}

/// Outcome of the process of a row.
enum RowOutcome {
    /// Row or failure; a repetition would give the same.
    Made(Result<TradeRow, String>),
    /// The process was killed; the exit status.
    Lost(String),
}

/// Kills a child process, unless it has ended already.
fn kill_process(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}

/// Converts an I/O error into a failure that names the file.
pub fn file_failure(verb: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> CommandError {
    let path = path.to_path_buf();
    move |source| CommandError::Run(RunError::File { verb, path, source })
}
