//! `gelfmu trade`: what accuracy costs, knob by knob.

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

pub use importer::Importer;
pub use row::print as row;

use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt;
use crate::job::RunError;
use crate::options::TradeOptions;
use crate::progress::Bar;
use crate::results;
use crate::source::{self, Source};
use ballistic_gel::output::{FolderClaim, FolderState, ResultFolder, TakeoverPolicy};
use ballistic_gel::scene::{Override, Scene};
use curve::{Curve, Run};
use ladder::{HasFailed, Rung};
use std::path::{Path, PathBuf};
use work::Work;

/// Name of the command in the manifest of its folder.
const COMMAND: &str = "trade";
/// What the first Ctrl-C is answered with.
const WAITING: &str = "interrupted: finished runs are kept, the others are left; the same command goes on from there";

/// Measures the curve, writes it, and says with which status to end.
pub fn trade(options: &TradeOptions, console: &Console) -> Result<u8, Failure> {
    let task = Task::read(options)?;
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
        let rungs = task.all(switches::rungs(&task.scene));
        let runs = task.work(&mut folder, console, switches::REPEATS, |work| work.all(rungs))?;
        switches::show(&task, &runs, &mut folder, console)?;
        return task.end(folder, console);
    }
    let curve = Curve::of(&task.work(&mut folder, console, 1, |work| task.runs(work))?);
    let others = options.with.as_deref().map_or(Ok(vec![]), |path| others::read(path, &curve))?;
    paper::write(&mut folder, &curve, picture::svg(&base.name, &curve, &others)).map_err(RunError::from)?;
    console.result(&paper::value(&base.name, &curve), &paper::text(&curve, &task.folder, console));
    task.end(folder, console)
}

/// The scene whose curve is measured.
struct Task<'a> {
    options: &'a TradeOptions,
    scene: Scene,
    folder: PathBuf,
}

impl<'a> Task<'a> {
    fn read(options: &'a TradeOptions) -> Result<Self, Failure> {
        let scene = source::load(&options.scene, &options.set)?.scene;
        let own = || Path::new("gelfmu-out").join(format!("{}-trade", scene.scene.name));
        let folder = options.out.clone().unwrap_or_else(own);
        let knobs = ladder::knobs(&scene);
        if let Some(strange) = options.only.iter().find(|name| !knobs.contains(&name.as_str())) {
            let expected = format!("one of the knobs of this scene: {}", knobs.join(", "));
            return Err(Failure::BadInput(format!(
                "--only {strange}: found no knob of this name, expected {expected}"
            )));
        }
        Ok(Self { options, scene, folder })
    }

    /// Has work done, with a bar; each run so many times.
    fn work(
        &self,
        folder: &mut ResultFolder,
        console: &Console,
        repeats: usize,
        work: impl FnOnce(&mut Work<'_>) -> Result<Vec<Run>, Failure>,
    ) -> Result<Vec<Run>, Failure> {
        let bar = Bar::new(console);
        if self.options.afresh {
            folder.remove_all(work::ROWS).map_err(RunError::from)?;
        }
        let runs = work(&mut Work { folder, jobs: self.options.jobs, repeats, bar: &bar });
        bar.clear();
        runs
    }

    /// The scene as it comes, and then what is around it.
    fn runs(&self, work: &mut Work<'_>) -> Result<Vec<Run>, Failure> {
        let mut runs = work.all(self.all(vec![Rung::base()]))?;
        let failed = runs.iter().any(|run| run.row.as_ref().map_or(true, |row| row.failure.is_some()));
        let has_failed = if failed { HasFailed::Yes } else { HasFailed::No };
        let rungs = ladder::ladder(&self.scene, self.options.finer, has_failed);
        runs.extend(work.all(self.all(rungs.into_iter().filter(|rung| self.wants(rung.knob)).collect()))?);
        Ok(runs)
    }

    /// Claims the folder: rows that this command has made there are gone on with.
    fn claim(&self) -> Result<ResultFolder, Failure> {
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

    /// Completes the folder, and says with which status to end.
    fn end(&self, mut folder: ResultFolder, console: &Console) -> Result<u8, Failure> {
        let state = if interrupt::asked() { FolderState::Interrupted } else { FolderState::Complete };
        folder.begin().and_then(|()| folder.mark(state)).map_err(RunError::from)?;
        if state == FolderState::Complete {
            return Ok(0);
        }
        console.error(&format!("interrupted; finished runs are kept in {}", self.folder.display()));
        Ok(interrupt::INTERRUPTED)
    }

    fn wants(&self, knob: &str) -> bool {
        let only = &self.options.only;
        only.is_empty() || knob.starts_with(ladder::MESH) || only.iter().any(|name| name == knob)
    }

    /// Rungs with their scenes.
    fn all(&self, rungs: Vec<Rung>) -> Vec<(Rung, Result<Source, Failure>)> {
        let with = |rung: Rung| {
            let overrides: Vec<Override> = self.options.set.iter().chain(&rung.overrides).cloned().collect();
            let source = source::load(&self.options.scene, &overrides);
            (rung, source)
        };
        rungs.into_iter().map(with).collect()
    }
}
