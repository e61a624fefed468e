//! `gelfmu run`: runs a scene and writes its results.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::forecast::{RunForecast, RunPoint};
use crate::job::{RunEnding, RunJob};
use crate::level::{self, LeveledScene};
use crate::options::{DEFAULT_SCENE, RunOptions};
use crate::pack::resources::{self, SceneResources};
use crate::progress::ProgressDisplay;
use crate::report::PageOptions;
use crate::source::SceneSource;
use crate::through_fmu::{self, InstanceFolder};
use crate::{direct, interrupt, measured, report, results, summary};
use ballistic_gel::output;
use ballistic_gel::output::{FolderClaim, ResultFolder};
use ballistic_gel::scene::{CouplingMode, MOST_STEPS, Override, Scene};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Answer to the first Ctrl-C. A communication step is never cut: its row in the results would be at a different time.
const WAITING: &str =
    "interrupted: the run ends with this communication step and keeps it; Ctrl-C again ends it at once";

/// Runs a scene, prints its summary and returns the exit status.
pub fn run(options: &RunOptions, console: &Console) -> Result<u8, CommandError> {
    let name = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let LeveledScene { source, expectation, folder_name } =
        level::load_at_level(name, &collect_overrides(options), &options.level)?;
    options.step.map_or(Ok(()), |step| check_communication_step(step, &source.scene))?;
    let measured = options.report.measured.as_deref().map(measured::read).transpose()?;
    let identity = options.report.identity()?;
    let header = source.scene.scene.clone();
    let folder = options.out.clone().unwrap_or_else(|| Path::new("gelfmu-out").join(folder_name));
    let SceneResources { text, files } = resources::collect(&source)?;
    let kept = format!("# Scene of this run, with the overrides of the command.\n\n{text}");
    let kept: Vec<(String, Vec<u8>)> =
        files.into_iter().chain([(output::SCENE.to_owned(), kept.into_bytes())]).collect();
    let inputs: Vec<PathBuf> = results::inputs(name, &source).into_iter().chain(options.report.files()).collect();
    let mut claimed = claim_folder(&folder, options, &inputs, &source, &kept)?;
    let way = if options.direct { "by the library" } else { "through the packed FMU" };
    console.note(&format!("{}: {} ({way}, into {})", header.name, header.title, folder.display()));
    if let Some(expectation) = expectation {
        console.note(&expectation);
    }
    if source.scene.coupling.mode != CouplingMode::Integrated {
        console.note(
            "coupling.mode of the scene is for importers of the packed FMU: here the component moves the projectile",
        );
    }
    if let Some(table) = &measured {
        console.notes(&table.notes);
    }
    for (file, bytes) in &kept {
        claimed.write(file, bytes).map_err(RunError::from)?;
    }
    let job = RunJob { source, folder, step: options.step, threads: options.threads };
    let units = console.figure_units(options.units.system());
    let ending = run_with_progress(&job, claimed, options.direct, console)?;
    if job.source.scene.output.report {
        let page = PageOptions { identity: &identity, measured: measured.as_ref(), units };
        console.notes(&report::write(&job.folder, &job.source.scene, &page)?);
    } else if let Some(table) = &measured {
        console.notes(&measured::compare(table, &job.folder, units)?.residuals);
    }
    let summary = PrintedSummary::read(&job.folder)?;
    console.result(&summary.text.trim_end(), &summary::describe(&summary.value, &job.source.scene, &job.folder, units));
    let doubts = summary.value["doubts"].as_array();
    doubts.into_iter().flatten().filter_map(serde_json::Value::as_str).for_each(|doubt| console.warning(doubt));
    Ok(report_ending(&ending, &job.folder, console))
}

/// Returns the overrides of `--set` and of the options that stand for an override.
fn collect_overrides(options: &RunOptions) -> Vec<Override> {
    let set = |key: &str, value: &str| Override { key: key.to_owned(), value: value.to_owned() };
    let no_frames = options.no_frames.then(|| set("output.frames", "0"));
    let no_report = options.no_report.then(|| set("output.report", "false"));
    options.set.iter().cloned().chain(no_frames).chain(no_report).collect()
}

/// Claims the folder of a run.
///
/// Refuses a folder name that an FMU cannot take, and scene files that are named like results.
fn claim_folder(
    folder: &Path,
    options: &RunOptions,
    inputs: &[PathBuf],
    source: &SceneSource,
    kept: &[(String, Vec<u8>)],
) -> Result<ResultFolder, CommandError> {
    let named = if options.direct { Ok(()) } else { InstanceFolder::of(folder).map(drop) };
    named.map_err(|found| {
        let expected = "a folder whose name has none of / \\ : * ? \" < > |, or --direct";
        CommandError::BadInput(format!("--out {}: found {found}, expected {expected}", folder.display()))
    })?;
    let mut needs = output::result_names(&source.scene);
    if let Some((file, _)) = kept.iter().find(|(file, _)| needs.contains(file)) {
        return Err(CommandError::BadInput(format!(
            "file {file:?} of the scene: found the name of a result, expected another name"
        )));
    }
    needs.extend(kept.iter().map(|(file, _)| file.clone()));
    let policy = results::policy(options.force);
    results::claim(folder, &FolderClaim { command: output::RUN, policy, needs: &needs, inputs, is_of_fmu: false })
}

/// Runs the job with a progress bar until it ends or the user interrupts it.
fn run_with_progress(
    job: &RunJob,
    mut folder: ResultFolder,
    is_direct: bool,
    console: &Console,
) -> Result<RunEnding, CommandError> {
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep partial results: {error}"));
    }
    let bar = ProgressDisplay::new(console);
    let (mut forecast, began) = (RunForecast::new(&job.source.scene), Instant::now());
    let end_time = job.source.scene.scene.end_time;
    let mut progress = |point: RunPoint| {
        let fraction = forecast.add(point, began.elapsed().as_secs_f64());
        bar.show(point.time, end_time, fraction);
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let ending = if is_direct {
        direct::run(job, folder, &mut progress)
    } else {
        folder.hand_over().map_err(RunError::from)?;
        // If the run cannot begin, the folder stays as it was: only the FMU writes results.
        let ending = through_fmu::run(job, &mut progress);
        drop(folder);
        ending
    };
    bar.clear();
    Ok(ending?)
}

/// Text of `summary.json`, and its value.
struct PrintedSummary {
    text: String,
    value: serde_json::Value,
}

impl PrintedSummary {
    fn read(folder: &Path) -> Result<Self, RunError> {
        let path: PathBuf = folder.join("summary.json");
        let text = output::read_limited_text(&path, output::MOST_TABLE_BYTES);
        let read = text.and_then(|text| Ok(Self { value: serde_json::from_str(&text)?, text }));
        read.map_err(|source| RunError::File { verb: "read", path, source })
    }
}

fn report_ending(ending: &RunEnding, folder: &Path, console: &Console) -> u8 {
    match ending {
        RunEnding::Completed => 0,
        RunEnding::Stopped(diagnosis) => {
            console.error(&format!("the run stopped before its end: {diagnosis}. Kept in {}", folder.display()));
            1
        }
        RunEnding::Interrupted => {
            console.error(&format!("interrupted; the results up to now are in {}", folder.display()));
            interrupt::INTERRUPTED
        }
    }
}

/// Refuses a communication step, s, too short for the run to end in a lifetime.
fn check_communication_step(step: f64, scene: &Scene) -> Result<(), CommandError> {
    let end = scene.scene.end_time;
    let n_steps = end / step;
    // The message rounds the shortest step; the rounded value must be accepted.
    if n_steps * (1.0 - 1e-3) <= MOST_STEPS {
        return Ok(());
    }
    let shortest = end / MOST_STEPS;
    Err(CommandError::BadInput(format!(
        "--step {step:e}: found {n_steps:.3e} steps to the end time, {end:?} s, expected at most {MOST_STEPS:e}: a step of \
         {shortest:.3e} s or more"
    )))
}

#[cfg(test)]
mod tests {
    use super::check_communication_step;
    use ballistic_gel::scene;

    #[test]
    fn a_step_without_an_end_is_refused_with_the_shortest_valid_step() {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let refused = check_communication_step(1e-20, &scene).unwrap_err().to_string();
        assert!(refused.starts_with("--step 1e-20: found 1.000e18 steps"), "{refused}");
        assert!(refused.ends_with("a step of 1.000e-11 s or more"), "{refused}");
        assert!(check_communication_step(1e-11, &scene).is_ok() && check_communication_step(1.0, &scene).is_ok());
    }
}
