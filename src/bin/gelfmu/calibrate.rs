//! `gelfmu calibrate`: fits the strength of a gel to the depth at which a projectile rests.

mod search;
mod task;
mod trial;
mod words;

use crate::console::Console;
use crate::failure::CommandError;
use crate::interrupt;
use crate::moved;
use crate::options::CalibrateOptions;
use crate::progress::ProgressDisplay;
use search::{SearchStep, ShotOutcome, StrengthSearch, StrengthTrial};
use std::ops::ControlFlow;
use task::{CalibrationEnd, CalibrationTask, FITTED_KEY};

/// Answer to the first Ctrl-C.
const WAITING: &str = "interrupted: the best strength so far is kept; Ctrl-C again ends it at once";

/// Fits the strength to one depth, prints the lines for the scene, and returns the exit status.
pub fn calibrate(options: &CalibrateOptions, console: &Console) -> Result<u8, CommandError> {
    if options.shots.is_some() || options.sensitivity.is_some() {
        return Err(moved::refuse("calibrate --shots", "calibrate SHOTS.csv"));
    }
    let task = CalibrationTask::read(options)?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep the best strength so far: {error}"));
    }
    console.note(&words::headline(&task));
    let mut search = StrengthSearch::new(options.depth, options.tolerance, task.strength, task.strongest());
    let end = fit_strength(&task, &mut search, console)?;
    console.result(&words::to_json(&task, &search, &end), &words::table_and_lines(&task, &search));
    Ok(match end {
        CalibrationEnd::Fitted => 0,
        CalibrationEnd::Interrupted => {
            console.error("interrupted; above is the best strength so far, if there is one");
            interrupt::INTERRUPTED
        }
        CalibrationEnd::GivenUp(why) => {
            console.error(&format!("{FITTED_KEY} was not fitted: {why}"));
            1
        }
    })
}

/// Tries strengths until one of them fits or the search ends.
fn fit_strength(
    task: &CalibrationTask,
    search: &mut StrengthSearch,
    console: &Console,
) -> Result<CalibrationEnd, CommandError> {
    loop {
        let strength = match search.next_step() {
            SearchStep::Fitted => return Ok(CalibrationEnd::Fitted),
            SearchStep::GivenUp(why) => return Ok(CalibrationEnd::GivenUp(why)),
            SearchStep::OutOfReach(why) => return Err(task.refuse("--depth", &why)),
            SearchStep::Try(strength) => strength,
        };
        let Some(outcome) = run_trial(task, search, strength, console)? else {
            return Ok(CalibrationEnd::Interrupted);
        };
        let trial = StrengthTrial { strength, outcome };
        console.note(&words::trial_line(search.trials.len() + 1, &trial));
        search.trials.push(trial);
    }
}

/// Runs the scene with a strength and a progress bar; returns `None` if the user interrupted it.
fn run_trial(
    task: &CalibrationTask,
    search: &StrengthSearch,
    strength: f64,
    console: &Console,
) -> Result<Option<ShotOutcome>, CommandError> {
    let (bar, number) = (ProgressDisplay::new(console), search.trials.len() + 1);
    let expected = search.time_to_stop().unwrap_or(trial::END_TIME_FACTOR * task.scene.scene.end_time);
    let mut watch = |time: f64, depth: f64| {
        let progress = format!("run {number}, {}: {:.1} mm deep", words::strength_scale(strength), 1e3 * depth);
        bar.show_task(&progress, (time / expected).min(1.0));
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let scene = task.load_with(strength)?.scene;
    let run = trial::run(scene, task.options.threads, &mut watch);
    bar.clear();
    let Some(run) = run? else { return Ok(None) };
    if let Some(why) = trial::explain_excess_depth(task.options.depth, run.thickness) {
        return Err(CommandError::BadInput(format!("--depth: {why}")));
    }
    Ok(Some(task.outcome(run)))
}
