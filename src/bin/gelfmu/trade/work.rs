//! The runs themselves: processes side by side, and what is kept of them in the folder.

use super::curve::Run;
use super::ladder::Rung;
use super::row::Row;
use crate::failure::Failure;
use crate::interrupt;
use crate::job::RunError;
use crate::progress::Bar;
use crate::source::Source;
use ballistic_gel::fmi2;
use ballistic_gel::output::ResultFolder;
use ballistic_gel::scene::Levels;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Bytes of the longest row that is read.
const MOST_ROW_BYTES: u64 = 1 << 20;
/// How often processes are looked after.
const LOOK: Duration = Duration::from_millis(50);

/// Where rows are kept, and how many are made at once.
pub struct Work<'a> {
    /// Folder of the curve, which has that of the rows.
    pub folder: &'a mut ResultFolder,
    /// Processes at once.
    pub jobs: usize,
    /// How often each run is made; the least CPU time counts.
    pub repeats: usize,
    /// Progress.
    pub bar: &'a Bar,
}

/// Folder of the rows in that of the curve.
pub const ROWS: &str = "rows";

/// A run that is to be made: what it is, its scene, and the file that keeps its row.
struct Task {
    index: usize,
    rung: Rung,
    file: String,
    text: PathBuf,
    folder: PathBuf,
    repeats: usize,
}

impl Work<'_> {
    /// Makes the runs that are not there yet; those that an interruption leaves are not among what is given back.
    pub fn all(&mut self, rungs: Vec<(Rung, Result<Source, Failure>)>) -> Result<Vec<Run>, Failure> {
        let (mut runs, mut tasks) = (vec![], vec![]);
        for (index, (rung, source)) in rungs.into_iter().enumerate() {
            match source {
                Err(refused) => runs.push((index, Run { rung, row: Err(refused.to_string()) })),
                Ok(source) => match self.kept(&rung, &source)? {
                    (Some(row), _) => runs.push((index, Run { rung, row })),
                    (None, file) => tasks.push(self.task(index, rung, file, &source)?),
                },
            }
        }
        tasks.sort_by(|a, b| b.rung.guess.total_cmp(&a.rung.guess));
        runs.extend(self.make(tasks)?);
        runs.sort_by_key(|(index, _)| *index);
        Ok(runs.into_iter().map(|(_, run)| run).collect())
    }

    /// The row of a run that was made before, and the file for it.
    fn kept(&self, rung: &Rung, source: &Source) -> Result<(Option<Result<Row, String>>, String), Failure> {
        let name = format!("{ROWS}/{:032x}.json", key(rung, source, self.repeats));
        let file = self.folder.place(&name);
        if !self.folder.owns(&name) {
            return Ok((None, name));
        }
        match fmi2::read_limited_text(&file, MOST_ROW_BYTES) {
            // A file that was cut off is made again.
            Ok(text) => Ok((serde_json::from_str::<Result<Row, String>>(&text).ok(), name)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok((None, name)),
            Err(error) => Err(named("read", &file)(error)),
        }
    }

    fn task(&mut self, index: usize, rung: Rung, file: String, source: &Source) -> Result<Task, Failure> {
        let name = file.replace(".json", ".toml");
        self.folder.write(&name, source.text.as_bytes()).map_err(RunError::from)?;
        let text = self.folder.place(&name);
        Ok(Task { index, rung, file, text, folder: source.folder.clone(), repeats: self.repeats })
    }

    fn make(&mut self, tasks: Vec<Task>) -> Result<Vec<(usize, Run)>, Failure> {
        let (total, mut done) = (tasks.iter().map(|task| task.rung.guess).sum::<f64>(), 0.0);
        let (mut waiting, mut going, mut runs) = (tasks.into_iter(), Vec::<(Task, Child)>::new(), vec![]);
        loop {
            while going.len() < self.jobs && !interrupt::asked() {
                let Some(task) = waiting.next() else { break };
                let child = task.begin()?;
                going.push((task, child));
            }
            if going.is_empty() {
                return Ok(runs);
            }
            std::thread::sleep(LOOK);
            if interrupt::asked() {
                for (_, child) in &mut going {
                    stop(child);
                }
                return Ok(runs);
            }
            let names: Vec<String> = going.iter().map(|(task, _)| task.rung.label()).collect();
            self.bar.show_part(&names.join(" | "), done / total);
            for (task, mut child) in std::mem::take(&mut going) {
                let ended = child.try_wait().map_err(named("wait for", &task.text))?;
                if ended.is_none() {
                    going.push((task, child));
                    continue;
                }
                let row = self.end(&task, &mut child)?;
                done += task.rung.guess;
                runs.push((task.index, Run { rung: task.rung, row }));
            }
        }
    }
}

impl Work<'_> {
    /// Reads the answer of a process and keeps it in the folder, so that it is not run again, unless it was ended from outside.
    fn end(&mut self, task: &Task, child: &mut Child) -> Result<Result<Row, String>, Failure> {
        let row = match task.said(child)? {
            RowOutcome::Made(row) => row,
            RowOutcome::Lost(how) => return Ok(Err(how)),
        };
        let text = serde_json::to_string_pretty(&row).expect("numbers and text can be written");
        let kept = self.folder.write(&task.file, text.as_bytes()).and_then(|()| self.folder.begin());
        kept.map_err(RunError::from)?;
        Ok(row)
    }
}

/// Hash of what decides a row: the scene with every default, who moves the projectile, and the version.
fn key(rung: &Rung, source: &Source, repeats: usize) -> u128 {
    let mut scene = source.scene.clone();
    // What was measured before changes nothing.
    scene.fidelity = Levels::default();
    let scene = serde_json::to_string(&scene).expect("a scene consists of tables, numbers and text");
    let read = fmi2::files_in(&source.folder);
    let files: Vec<Vec<u8>> = source.scene.files().iter().filter_map(|(_, name)| read(name).ok()).collect();
    let again = if repeats == 1 { String::new() } else { repeats.to_string() };
    let all = format!("{}{again} {} {scene} {files:?}", env!("CARGO_PKG_VERSION"), rung.importer.as_str());
    xxhash_rust::xxh3::xxh3_128(all.as_bytes())
}

impl Task {
    fn begin(&self) -> Result<Child, Failure> {
        let program = std::env::current_exe().map_err(named("find", Path::new("gelfmu")))?;
        let mut command = Command::new(program);
        command.arg("trade-row").arg(&self.text).arg("--folder").arg(self.folder.join("."));
        command.args(["--importer", self.rung.importer.as_str(), "--repeat", &self.repeats.to_string()]);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().map_err(named("start a run of", &self.text))
    }

    /// Reads the answer of the process, or how it was ended from outside.
    fn said(&self, child: &mut Child) -> Result<RowOutcome, Failure> {
        let (mut out, mut complaint) = (String::new(), String::new());
        for (pipe, to) in [
            (child.stdout.as_mut().map(|p| p as &mut dyn Read), &mut out),
            (child.stderr.as_mut().map(|p| p as _), &mut complaint),
        ] {
            pipe.map_or(Ok(0), |pipe| pipe.read_to_string(to)).map_err(named("read from", &self.text))?;
        }
        let status = child.wait().map_err(named("wait for", &self.text))?;
        Ok(match serde_json::from_str::<Row>(&out) {
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
    /// A row, or why there is none: the same again.
    Made(Result<Row, String>),
    /// It was ended from outside: how.
    Lost(String),
}

/// Ends a process of ours; it may have ended by itself.
fn stop(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}

/// Names the file that an error is about.
pub fn named(verb: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Failure {
    let path = path.to_path_buf();
    move |source| Failure::Run(RunError::File { verb, path, source })
}
