//! `gelfmu run`: the main job.

use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Ending, Job, RunError};
use crate::options::{DEFAULT_SCENE, RunOptions};
use crate::progress::Bar;
use crate::{direct, interrupt, source, summary, through_fmu};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Runs a scene, shows how it went, and says with which status to end.
pub fn run(options: &RunOptions, console: &Console) -> Result<u8, Failure> {
    let name = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let source = source::load(name, &options.set)?;
    let header = source.scene.scene;
    let folder = options.out.clone().unwrap_or_else(|| Path::new("gelfmu-out").join(&header.name));
    usable(&folder, options.force)?;
    let way = if options.direct { "by the library" } else { "through the packed FMU" };
    console.note(&format!("{}: {} ({way}, into {})", header.name, header.title, folder.display()));
    let job = Job { scene: source.text, folder, step: options.step, threads: options.threads };
    let ending = watch(&job, options.direct, console)?;
    let summary = read_summary(&job.folder)?;
    console.result(&summary, &summary::describe(&summary, &job.folder));
    Ok(status(&ending, &job.folder, console))
}

/// An output folder is new, empty, or given up by the user.
fn usable(folder: &Path, force: bool) -> Result<(), Failure> {
    let refuse = |found: &str, remedy: &str| {
        Err(Failure::BadInput(format!("--out {}: found {found}, expected {remedy}", folder.display())))
    };
    match std::fs::read_dir(folder).map(|mut entries| entries.next().is_some()) {
        Ok(occupied) if occupied && !force => {
            refuse("a folder that is not empty", "an empty or new folder, or --force to overwrite")
        }
        Ok(_) => Ok(()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(error) => refuse(&error.to_string(), "a folder that can be written"),
    }
}

/// Runs the job with a progress bar, until it ends or the user interrupts it.
fn watch(job: &Job, by_library: bool, console: &Console) -> Result<Ending, Failure> {
    if let Err(error) = interrupt::listen() {
        console.note(&format!("Ctrl-C will not keep what was computed: {error}"));
    }
    let bar = Bar::new(console.is_quiet());
    let mut progress = |time, end| {
        bar.show(time, end);
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let ending = if by_library { direct::run(job, &mut progress) } else { through_fmu::run(job, &mut progress) };
    bar.clear();
    Ok(ending?)
}

fn read_summary(folder: &Path) -> Result<serde_json::Value, RunError> {
    let path: PathBuf = folder.join("summary.json");
    let read = std::fs::read_to_string(&path).and_then(|text| Ok(serde_json::from_str(&text)?));
    read.map_err(|source| RunError::File { verb: "read", path, source })
}

fn status(ending: &Ending, folder: &Path, console: &Console) -> u8 {
    match ending {
        Ending::Completed => 0,
        Ending::Stopped(diagnosis) => {
            console.error(&format!("the run stopped before its end: {diagnosis}. Kept in {}", folder.display()));
            1
        }
        Ending::Interrupted => {
            console.error(&format!("interrupted; what was computed is in {}", folder.display()));
            interrupt::INTERRUPTED
        }
    }
}
