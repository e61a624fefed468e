//! `gelfmu trade`: measures the error and the cost of a scene, knob by knob.

mod curve;
mod front;
mod importer;
mod ladder;
mod levels;
mod others;
mod paper;
mod picture;
mod richardson;
mod row;
mod switches;
mod work;

pub use importer::CouplingVariant;
pub use row::print_row;
pub use work::file_failure;

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::interrupt;
use crate::options::TradeOptions;
use crate::progress::ProgressDisplay;
use crate::results;
use crate::source;
use ballistic_gel::output::{FolderClaim, FolderState, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene::{Override, Scene};
use curve::{TradeCurve, TradeRun};
use ladder::{HasFailed, LadderRung};
use others::{PeerRow, PeerRun};
use std::path::{Path, PathBuf};
use work::{PreparedRung, RunQueue};

/// Name of the command in the folder manifest.
const COMMAND: &str = "trade";
/// Answer to the first Ctrl-C.
const WAITING: &str = "interrupted: finished runs are kept, the others are left; the same command goes on from there";

/// Measures the error-cost curve, writes it and returns the exit status.
pub fn trade(options: &TradeOptions, console: &Console) -> Result<u8, CommandError> {
    let task = TradeTask::read(options)?;
    let mut folder = task.claim()?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep what was computed: {error}"));
    }
    let base = &task.scene.scene;
    console.note(&format!(
        "{}: {} ({} processes, into {})",
        base.name,
        base.title,
        options.jobs,
        task.folder.display()
    ));
    if options.options {
        let rungs = task.with_scenes(switches::option_rungs(&task.scene));
        let runs = task.with_queue(&mut folder, console, switches::REPEATS, |queue| queue.run_all(rungs))?;
        switches::report(&base.name, &runs, &mut folder, console)?;
        return task.finish(folder, console);
    }
    let curve = TradeCurve::assess(&task.with_queue(&mut folder, console, 1, |queue| task.run_ladder(queue))?);
    let others: Vec<PeerRun> = task.others.iter().map(|row| row.assess(&curve)).collect();
    paper::write_files(&mut folder, &curve, picture::draw_svg(&base.name, &curve, &others)).map_err(RunError::from)?;
    console.result(&paper::to_json(&base.name, &curve), &paper::to_text(&curve, &task.folder, console));
    task.finish(folder, console)
}

/// Scene to measure, its options and the result folder.
struct TradeTask<'a> {
    options: &'a TradeOptions,
    scene: Scene,
    folder: PathBuf,
    /// Runs of other codes.
    others: Vec<PeerRow>,
}

impl<'a> TradeTask<'a> {
    fn read(options: &'a TradeOptions) -> Result<Self, CommandError> {
        let scene = source::load(&options.scene, &options.set)?.scene;
        let own = || Path::new("gelfmu-out").join(format!("{}-trade", scene.scene.name));
        let folder = options.out.clone().unwrap_or_else(own);
        let knobs = ladder::knobs(&scene);
        if let Some(unknown) = options.only.iter().find(|name| !knobs.contains(&name.as_str())) {
            let expected = format!("one of the knobs of this scene: {}", knobs.join(", "));
            return Err(CommandError::BadInput(format!(
                "--only {unknown}: found no knob of this name, expected {expected}"
            )));
        }
        let others = options.with.as_deref().map_or(Ok(vec![]), others::read_peers)?;
        Ok(Self { options, scene, folder, others })
    }

    /// Opens a run queue with a progress bar and lets `work` fill it.
    fn with_queue(
        &self,
        folder: &mut ResultFolder,
        console: &Console,
        repeats: usize,
        work: impl FnOnce(&mut RunQueue<'_>) -> Result<Vec<TradeRun>, CommandError>,
    ) -> Result<Vec<TradeRun>, CommandError> {
        let bar = ProgressDisplay::new(console);
        if self.options.afresh {
            folder.remove_all(work::ROWS_FOLDER).map_err(RunError::from)?;
        }
        let runs = work(&mut RunQueue { folder, jobs: self.options.jobs, repeats, bar: &bar });
        bar.clear();
        runs
    }

    /// Runs the unmodified scene, then its ladder.
    fn run_ladder(&self, queue: &mut RunQueue<'_>) -> Result<Vec<TradeRun>, CommandError> {
        let mut runs = queue.run_all(self.with_scenes(vec![LadderRung::unmodified()]))?;
        let failed = runs.iter().any(|run| run.row.as_ref().map_or(true, |row| row.failure.is_some()));
        let has_failed = if failed { HasFailed::Yes } else { HasFailed::No };
        let rungs = ladder::ladder(&self.scene, self.options.finer, has_failed);
        runs.extend(
            queue.run_all(self.with_scenes(rungs.into_iter().filter(|rung| self.is_wanted(rung.knob)).collect()))?,
        );
        Ok(runs)
    }

    /// Claims the folder; kept rows of an earlier `trade` are continued.
    fn claim(&self) -> Result<ResultFolder, CommandError> {
        let files: &[&str] = if self.options.options { &[switches::FILE] } else { &paper::FILES };
        let needs: Vec<String> = files.iter().map(|file| (*file).to_owned()).collect();
        let source = source::load(&self.options.scene, &self.options.set)?;
        let mut inputs = results::inputs(&self.options.scene, &source);
        inputs.extend(self.options.with.clone());
        let policy = TakeoverPolicy::Continue;
        results::claim(
            &self.folder,
            &FolderClaim { command: COMMAND, policy, needs: &needs, inputs: &inputs, is_of_fmu: false },
        )
    }

    /// Completes the folder and returns the exit status.
    fn finish(&self, mut folder: ResultFolder, console: &Console) -> Result<u8, CommandError> {
        let state = if interrupt::asked() { FolderState::Interrupted } else { FolderState::Complete };
        folder.begin().and_then(|()| folder.mark(state)).map_err(RunError::from)?;
        if state == FolderState::Complete {
            return Ok(0);
        }
        console.error(&format!("interrupted; finished runs are kept in {}", self.folder.display()));
        Ok(interrupt::INTERRUPTED)
    }

    fn is_wanted(&self, knob: &str) -> bool {
        let only = &self.options.only;
        only.is_empty() || knob.starts_with(ladder::MESH) || only.iter().any(|name| name == knob)
    }

    /// Loads the scene of each rung.
    fn with_scenes(&self, rungs: Vec<LadderRung>) -> Vec<PreparedRung> {
        let load = |rung: LadderRung| {
            let overrides: Vec<Override> = self.options.set.iter().chain(&rung.overrides).cloned().collect();
            let source = source::load(&self.options.scene, &overrides);
            PreparedRung { rung, source }
        };
        rungs.into_iter().map(load).collect()
    }
}
