//! `gelfmu run`: the main job.

use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Ending, Job, RunError, check_step};
use crate::options::{DEFAULT_SCENE, RunOptions};
use crate::pack::resources;
use crate::progress::Bar;
use crate::source::Source;
use crate::{direct, interrupt, level, summary, through_fmu};
use ballistic_gel::scene::CouplingMode;
use ballistic_gel::{fmi2, output};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// What the first Ctrl-C is answered with: a communication step is not divided, its rows would not be those asked for.
const WAITING: &str =
    "interrupted: the run ends with this communication step and keeps it; Ctrl-C again ends it at once";

/// Runs a scene, shows how it went, and says with which status to end.
pub fn run(options: &RunOptions, console: &Console) -> Result<u8, Failure> {
    let name = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let (source, expected) = level::load(name, &options.set, &options.level)?;
    options.step.map_or(Ok(()), |step| check_step(step, &source.scene))?;
    let header = source.scene.scene.clone();
    let folder = options.out.clone().unwrap_or_else(|| Path::new("gelfmu-out").join(&header.name));
    usable(&folder, options)?;
    let way = if options.direct { "by the library" } else { "through the packed FMU" };
    console.note(&format!("{}: {} ({way}, into {})", header.name, header.title, folder.display()));
    if let Some(expected) = expected {
        console.note(&expected);
    }
    if source.scene.coupling.mode != CouplingMode::Integrated {
        console.note(
            "coupling.mode of the scene is for importers of the packed FMU: here the component moves the projectile",
        );
    }
    let kept = keep_scene(&folder, &source)?;
    let job = Job { scene: (source.text, source.folder), folder, step: options.step, threads: options.threads };
    let ending = watch(&job, options.direct, console).inspect_err(|_| abandon(&job.folder, &kept))?;
    let (text, summary) = read_summary(&job.folder)?;
    console.result(&text.trim_end(), &summary::describe(&summary, &job.folder));
    if let Some(doubt) = summary["doubt"].as_str() {
        console.warning(doubt);
    }
    Ok(status(&ending, &job.folder, console))
}

/// An output folder is new, empty, or given up by the user; it is made here, and can be written.
fn usable(folder: &Path, options: &RunOptions) -> Result<(), Failure> {
    let refuse = |found: &str, remedy: &str| {
        Failure::BadInput(format!("--out {}: found {found}, expected {remedy}", folder.display()))
    };
    let named = if options.direct { Ok(()) } else { through_fmu::destination(folder).map(drop) };
    let plain = "a folder whose name has none of / \\ : * ? \" < > |, or --direct";
    named.map_err(|found| refuse(&found, plain))?;
    match std::fs::read_dir(folder).map(|mut entries| entries.next().is_some()) {
        Ok(true) if !options.force => {
            Err(refuse("a folder that is not empty", "an empty or new folder, or --force to overwrite"))
        }
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(writable(refuse, &error)),
        Ok(_) | Err(_) => {
            output::claim(folder).map_err(|error| writable(refuse, &error.source))?;
            tempfile::tempfile_in(folder).map(drop).map_err(|error| writable(refuse, &error))
        }
    }
}

fn writable(refuse: impl Fn(&str, &str) -> Failure, error: &std::io::Error) -> Failure {
    refuse(&error.to_string(), "a folder that can be written")
}

/// Keeps the scene, and the files that it names, beside what comes of it: it can be run again from there.
fn keep_scene(folder: &Path, source: &Source) -> Result<Vec<PathBuf>, RunError> {
    let (text, files) = resources::of((&source.text, &source.scene), &fmi2::files_in(&source.folder))?;
    let kept = format!("# As it is run, with what the command wrote over it.\n\n{text}");
    let all = files.into_iter().chain([("scene.toml".to_owned(), kept.into_bytes())]);
    let write = |(name, bytes): (String, Vec<u8>)| {
        let path = folder.join(name);
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        match made.and_then(|()| std::fs::write(&path, bytes)) {
            Ok(()) => Ok(path),
            Err(source) => Err(RunError::File { verb: "write", path, source }),
        }
    };
    all.map(write).collect()
}

/// Takes away what was kept of a run that has not begun; what cannot be removed does no harm.
fn abandon(folder: &Path, kept: &[PathBuf]) {
    if !folder.join("history.csv").exists() {
        for path in kept {
            let _ = std::fs::remove_file(path);
        }
        let _ = std::fs::remove_dir(folder);
    }
}

/// Runs the job with a progress bar, until it ends or the user interrupts it.
fn watch(job: &Job, by_library: bool, console: &Console) -> Result<Ending, Failure> {
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
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

/// `summary.json` as it stands, and read.
fn read_summary(folder: &Path) -> Result<(String, serde_json::Value), RunError> {
    let path: PathBuf = folder.join("summary.json");
    let read = std::fs::read_to_string(&path).and_then(|text| Ok((serde_json::from_str(&text)?, text)));
    read.map(|(value, text)| (text, value)).map_err(|source| RunError::File { verb: "read", path, source })
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
