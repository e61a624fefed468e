//! `gelfmu batch`: many shots in one process, each a line of standard input, without a folder of results.

use crate::direct;
use crate::failure::{CommandError, RunError};
use crate::job;
use crate::options::BatchOptions;
use crate::scratch::ScratchFolder;
use crate::source::{self, SceneSource};
use ballistic_gel::output::{DriverInterface, RunRecorder, RunSummary};
use ballistic_gel::scene::{Override, Scene, SceneError};
use ballistic_gel::simulation::CouplingMode;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::io::{self, Write};
use std::num::NonZero;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Greatest number of records of a shot: its communication steps are made longer.
const MOST_RECORDS: f64 = 100.0;

/// Shot, a line of JSON on standard input.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BatchShot {
    /// Built-in scene or scene file.
    scene: String,
    /// Text of the scene, in the place of that file.
    #[serde(default)]
    text: Option<String>,
    /// Overrides, as of `--set`.
    #[serde(default)]
    set: Vec<String>,
}

/// Result of a shot, a line of JSON on standard output.
#[derive(Debug, Serialize)]
struct BatchRow {
    /// Number of the line, from 0.
    index: usize,
    status: BatchStatus,
    /// Reason for any status but `completed`.
    reason: Option<String>,
    /// Figures of `summary.json`.
    summary: Option<RunSummary>,
}

/// Status of a shot, as in the tables of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum BatchStatus {
    Completed,
    Stopped,
    Refused,
    Crashed,
}

/// Lines of standard input and their number so far.
#[derive(Default)]
struct NumberedLines {
    next: usize,
}

impl NumberedLines {
    /// Returns the next line with its number; `None` at the end of the input.
    fn next(&mut self) -> io::Result<Option<(usize, String)>> {
        let mut line = String::new();
        while line.trim().is_empty() {
            line.clear();
            if io::stdin().read_line(&mut line)? == 0 {
                return Ok(None);
            }
        }
        self.next += 1;
        Ok(Some((self.next - 1, line)))
    }
}

/// Runs the shots of standard input, and prints a line for each as it ends.
pub fn batch(options: &BatchOptions) -> Result<(), CommandError> {
    let lines = Mutex::new(NumberedLines::default());
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let workers = if options.threads == 0 { cores } else { options.threads };
    let failed = Mutex::new(None);
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                if let Err(error) = run_lines(&lines, options) {
                    *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                }
            });
        }
    });
    failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), |error| {
        Err(CommandError::BadInput(format!(
            "batch: found {error}, expected standard input and output that can be used"
        )))
    })
}

/// Runs shots until there are no more lines.
fn run_lines(lines: &Mutex<NumberedLines>, options: &BatchOptions) -> io::Result<()> {
    let scratch = ScratchFolder::new()?;
    loop {
        let line = lines.lock().unwrap_or_else(PoisonError::into_inner).next()?;
        let Some((index, line)) = line else { return Ok(()) };
        let row = row_of(index, &line, options, &scratch);
        let mut text = serde_json::to_vec(&row)?;
        text.push(b'\n');
        let mut output = io::stdout().lock();
        output.write_all(&text)?;
        output.flush()?;
    }
}

/// Returns the row of a line.
fn row_of(index: usize, line: &str, options: &BatchOptions, scratch: &ScratchFolder) -> BatchRow {
    let refused =
        |reason: String| BatchRow { index, status: BatchStatus::Refused, reason: Some(reason), summary: None };
    let shot: BatchShot = match serde_json::from_str(line) {
        Ok(shot) => shot,
        Err(error) => {
            return refused(format!("line {}: found {error}, expected an object with scene and set", index + 1));
        }
    };
    let source = match load(&shot, options) {
        Ok(source) => source,
        Err(error) => return refused(error.to_string()),
    };
    match catch_unwind(AssertUnwindSafe(|| run_shot(&source.scene, scratch.path()))) {
        Ok(Ok(summary)) => {
            let status = if summary.completed { BatchStatus::Completed } else { BatchStatus::Stopped };
            BatchRow { index, status, reason: summary.failure.clone(), summary: Some(summary) }
        }
        Ok(Err(error)) => refused(error.to_string()),
        Err(panic) => BatchRow { status: BatchStatus::Crashed, ..refused(describe_panic(&*panic)) },
    }
}

fn describe_panic(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    format!("the shot panicked: {}", text.unwrap_or("without a message"))
}

/// Loads the scene of a shot at the level of the options.
fn load(shot: &BatchShot, options: &BatchOptions) -> Result<SceneSource, CommandError> {
    let level = options.fidelity.map(crate::level::level_override);
    let fixed = [("output.frames", "0"), ("output.report", "false")];
    let fixed = fixed.map(|(key, value)| Override { key: key.to_owned(), value: value.to_owned() });
    let set: Result<Vec<Override>, SceneError> = shot.set.iter().map(|set| set.parse()).collect();
    let set = set.map_err(|error| CommandError::BadInput(error.to_string()))?;
    let all: Vec<Override> = set.into_iter().chain(level).chain(fixed).collect();
    match &shot.text {
        Some(text) => source::load_text(&shot.scene, text, &all),
        None => source::load(&shot.scene, &all),
    }
}

/// Runs a shot to its end, and returns its figures.
fn run_shot(scene: &Scene, folder: &Path) -> Result<RunSummary, RunError> {
    let mut simulation = job::build_simulation(scene, CouplingMode::Integrated, 1)?;
    let mut recorder = RunRecorder::create(&folder.join("shot"), scene, DriverInterface::Direct, 1)?;
    recorder.record(&simulation)?;
    let header = &scene.scene;
    let factor = (header.end_time / (MOST_RECORDS * header.communication_step)).ceil().max(1.0);
    let times = job::step_ends(scene, factor * header.communication_step);
    let ending = direct::step_to_end(&mut simulation, &mut recorder, times, &mut |_| ControlFlow::Continue(()))?;
    Ok(recorder.finish(&simulation, ending.failure())?)
}
