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
use crate::options::TradeOptions;
use crate::progress::Bar;
use crate::source::{self, Source};
use ballistic_gel::scene::{Override, Scene};
use curve::{Curve, Run};
use ladder::{HasFailed, Rung};
use std::path::{Path, PathBuf};
use work::{Work, named};

/// What the first Ctrl-C is answered with.
const WAITING: &str = "interrupted: finished runs are kept, the others are left; the same command goes on from there";

/// Measures the curve, writes it, and says with which status to end.
pub fn trade(options: &TradeOptions, console: &Console) -> Result<u8, Failure> {
    let task = Task::read(options)?;
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
        let runs = task.work(console, switches::REPEATS, |work| work.all(task.all(switches::rungs(&task.scene))))?;
        switches::show(&task, &runs, console)?;
        return Ok(task.status(console));
    }
    let curve = Curve::of(&task.work(console, 1, |work| task.runs(work))?);
    let others = options.with.as_deref().map_or(Ok(vec![]), |path| others::read(path, &curve))?;
    paper::write(&task.folder, &curve, picture::svg(&base.name, &curve, &others))?;
    console.result(&paper::value(&base.name, &curve), &paper::text(&curve, &task.folder, console));
    Ok(task.status(console))
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
        console: &Console,
        repeats: usize,
        work: impl FnOnce(&Work<'_>) -> Result<Vec<Run>, Failure>,
    ) -> Result<Vec<Run>, Failure> {
        let bar = Bar::new(console.is_quiet());
        let folder = self.folder.join("rows");
        if self.options.afresh && folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(named("empty", &folder))?;
        }
        let runs = work(&Work { folder, jobs: self.options.jobs, repeats, bar: &bar });
        bar.clear();
        runs
    }

    /// The scene as it comes, and then what is around it.
    fn runs(&self, work: &Work<'_>) -> Result<Vec<Run>, Failure> {
        let mut runs = work.all(self.all(vec![Rung::base()]))?;
        let failed = runs.iter().any(|run| run.row.as_ref().map_or(true, |row| row.failure.is_some()));
        let has_failed = if failed { HasFailed::Yes } else { HasFailed::No };
        let rungs = ladder::ladder(&self.scene, self.options.finer, has_failed);
        runs.extend(work.all(self.all(rungs.into_iter().filter(|rung| self.wants(rung.knob)).collect()))?);
        Ok(runs)
    }

    fn status(&self, console: &Console) -> u8 {
        if !interrupt::asked() {
            return 0;
        }
        console.error(&format!("interrupted; finished runs are kept in {}", self.folder.display()));
        interrupt::INTERRUPTED
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
