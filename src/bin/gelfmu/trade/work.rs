//! The runs themselves: processes side by side, and what is kept of them in the folder.

use super::curve::Run;
use super::ladder::Rung;
use super::row::Row;
use crate::failure::Failure;
use crate::interrupt;
use crate::job::RunError;
use crate::progress::Bar;
use crate::source::Source;
use ballistic_gel::scene::Levels;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// How often processes are looked after.
const LOOK: Duration = Duration::from_millis(50);

/// Where rows are kept, and how many are made at once.
pub struct Work<'a> {
    /// Folder of the rows.
    pub folder: PathBuf,
    /// Processes at once.
    pub jobs: usize,
    /// How often each run is made; the least CPU time counts.
    pub repeats: usize,
    /// Progress.
    pub bar: &'a Bar,
}

/// A run that is to be made: what it is, its scene, and the file that keeps its row.
struct Task {
    index: usize,
    rung: Rung,
    file: PathBuf,
    text: PathBuf,
    folder: PathBuf,
    repeats: usize,
}

impl Work<'_> {
    /// Makes the runs that are not there yet; those that an interruption leaves are not among what is given back.
    pub fn all(&self, rungs: Vec<(Rung, Result<Source, Failure>)>) -> Result<Vec<Run>, Failure> {
        fs::create_dir_all(&self.folder).map_err(named("create", &self.folder))?;
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
    fn kept(&self, rung: &Rung, source: &Source) -> Result<(Option<Result<Row, String>>, PathBuf), Failure> {
        let file = self.folder.join(format!("{:032x}.json", key(rung, source, self.repeats)));
        match fs::read_to_string(&file) {
            // A file that was cut off is made again.
            Ok(text) => Ok((serde_json::from_str::<Result<Row, String>>(&text).ok(), file)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok((None, file)),
            Err(error) => Err(named("read", &file)(error)),
        }
    }

    fn task(&self, index: usize, rung: Rung, file: PathBuf, source: &Source) -> Result<Task, Failure> {
        let text = file.with_extension("toml");
        fs::write(&text, &source.text).map_err(named("write", &text))?;
        Ok(Task { index, rung, file, text, folder: source.folder.clone(), repeats: self.repeats })
    }

    fn make(&self, tasks: Vec<Task>) -> Result<Vec<(usize, Run)>, Failure> {
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
                let row = task.end(&mut child)?;
                done += task.rung.guess;
                runs.push((task.index, Run { rung: task.rung, row }));
            }
        }
    }
}

/// Hash of what decides a row: the scene with every default, who moves the projectile, and the version.
fn key(rung: &Rung, source: &Source, repeats: usize) -> u128 {
    let mut scene = source.scene.clone();
    // What was measured before changes nothing.
    scene.fidelity = Levels::default();
    let scene = serde_json::to_string(&scene).expect("a scene consists of tables, numbers and text");
    let files: Vec<Vec<u8>> =
        source.scene.files().iter().filter_map(|(_, name)| fs::read(source.folder.join(name)).ok()).collect();
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

    /// What the process said; kept in the folder, so that it is not run again, unless it was ended from outside.
    fn end(&self, child: &mut Child) -> Result<Result<Row, String>, Failure> {
        let (mut out, mut complaint) = (String::new(), String::new());
        for (pipe, to) in [
            (child.stdout.as_mut().map(|p| p as &mut dyn Read), &mut out),
            (child.stderr.as_mut().map(|p| p as _), &mut complaint),
        ] {
            pipe.map_or(Ok(0), |pipe| pipe.read_to_string(to)).map_err(named("read from", &self.text))?;
        }
        let status = child.wait().map_err(named("wait for", &self.text))?;
        let row = match serde_json::from_str::<Row>(&out) {
            Ok(row) => Ok(row),
            Err(_) if status.code().is_none() => {
                return Ok(Err(format!("its process was ended from outside: {status}")));
            }
            Err(_) => Err(complaint.trim().trim_start_matches("error: ").to_owned()),
        };
        let text = serde_json::to_string_pretty(&row).expect("numbers and text can be written");
        fs::write(&self.file, text).map_err(named("write", &self.file))?;
        Ok(row)
    }
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
