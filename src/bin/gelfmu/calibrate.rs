//! `gelfmu calibrate`: fits the yield stress of a gel to the depth at which a projectile stopped.

mod search;
mod trial;
mod words;

use crate::console::Console;
use crate::failure::CommandError;
use crate::interrupt;
use crate::options::CalibrateOptions;
use crate::progress::ProgressDisplay;
use crate::source::{self, SceneSource};
use ballistic_gel::scene::{Override, Scene, StrengthSpec};
use search::{SearchStep, ShotOutcome, StrengthSearch, StrengthTrial};
use std::ops::ControlFlow;

/// Scene key of the fitted value.
const FITTED_KEY: &str = "gel.strength.yield_stress";
/// Default scene of `calibrate`.
const DEFAULT_SCENE: &str = "fbi-bb";
/// Answer to the first Ctrl-C.
const WAITING: &str = "interrupted: the best strength so far is kept; Ctrl-C again ends it at once";

/// Calibration problem: the scene with its initial strength, and the target depth in the options, m.
struct CalibrationTask<'a> {
    name: &'a str,
    overrides: Vec<Override>,
    scene: Scene,
    strength: StrengthSpec,
    options: &'a CalibrateOptions,
}

/// Reason for the end of a calibration.
enum CalibrationEnd {
    /// The depth was met within the tolerance.
    Fitted,
    /// The user interrupted the search.
    Interrupted,
    /// The depth cannot be met; the reason.
    GivenUp(String),
}

/// Fits the strength, prints the lines for the scene, and returns the exit status.
pub fn calibrate(options: &CalibrateOptions, console: &Console) -> Result<u8, CommandError> {
    let task = CalibrationTask::read(options)?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep the best strength so far: {error}"));
    }
    console.note(&words::headline(&task));
    let mut search = StrengthSearch::new(options.depth, task.strength.yield_stress, task.strength.cap);
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
        let yield_stress = match search.next_step() {
            SearchStep::Fitted => return Ok(CalibrationEnd::Fitted),
            SearchStep::GivenUp(why) => return Ok(CalibrationEnd::GivenUp(why)),
            SearchStep::OutOfReach(why) => return Err(task.refuse("--depth", &why)),
            SearchStep::Try(yield_stress) => yield_stress,
        };
        let Some(outcome) = run_trial(task, search, yield_stress, console)? else {
            return Ok(CalibrationEnd::Interrupted);
        };
        let trial = StrengthTrial { yield_stress, outcome };
        console.note(&words::trial_line(search.trials.len() + 1, &trial));
        search.trials.push(trial);
    }
}

/// Runs the scene with a yield stress, Pa, and a progress bar; returns `None` if the user interrupted it.
fn run_trial(
    task: &CalibrationTask,
    search: &StrengthSearch,
    yield_stress: f64,
    console: &Console,
) -> Result<Option<ShotOutcome>, CommandError> {
    let (bar, number) = (ProgressDisplay::new(console), search.trials.len() + 1);
    let expected = search.time_to_stop().unwrap_or(task.scene.scene.end_time);
    let mut watch = |time: f64, depth: f64| {
        let progress = format!("run {number}, {}: {:.1} mm deep", words::in_kilopascals(yield_stress), 1e3 * depth);
        bar.show_task(&progress, (time / expected).min(1.0));
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let scene = task.load_with(yield_stress)?.scene;
    let outcome = trial::run(scene, task.options, &mut watch);
    bar.clear();
    outcome
}

/// Greatest calibrated speed, m/s: above it the gel and the projectile flow whatever their strength.
const GREATEST_SPEED: f64 = 5000.0;

/// Explains why a speed, m/s, is out of range; `None` if the speed is valid.
fn explain_excess_speed(speed: f64) -> Option<String> {
    let hint = if speed <= 1e3 * GREATEST_SPEED {
        format!("; were mm/s meant? They are {} m/s", 1e-3 * speed)
    } else {
        String::new()
    };
    (speed > GREATEST_SPEED).then(|| format!("found {speed:?} m/s, expected at most {GREATEST_SPEED:?} m/s{hint}"))
}

impl<'a> CalibrationTask<'a> {
    fn read(options: &'a CalibrateOptions) -> Result<Self, CommandError> {
        let name = options.scene.as_deref().unwrap_or(DEFAULT_SCENE);
        let mut overrides = options.set.clone();
        if let Some(speed) = options.speed {
            let value = format!("[0.0, 0.0, {:?}]", -speed);
            overrides.push(Override { key: "projectile.velocity".to_owned(), value });
        }
        let scene = source::load(name, &overrides)?.scene;
        let refuse = |key: &str, why: &str| CommandError::BadInput(format!("scene {name}: {key}: {why}"));
        let Some(strength) = scene.gel.strength else {
            let example = "{ yield_stress = 10e3, rate_exponent = 0.23, cap = 0.16e6, confined = { pressure = 0.3e6, factor = 15.0, time = 3e-6 } }";
            let why = format!(
                "found none, expected gel.material = \"flowing\" with the strength to begin with, such as gel.strength = {example}"
            );
            return Err(refuse("gel.strength", &why));
        };
        if let Some(why) = options.speed.and_then(explain_excess_speed) {
            return Err(CommandError::BadInput(format!("--speed: {why}")));
        }
        if let Some(why) =
            scene.gel.shape.thickness().and_then(|thickness| trial::explain_excess_depth(options.depth, thickness))
        {
            return Err(CommandError::BadInput(format!("--depth: {why}")));
        }
        let velocity = scene.projectile.velocity;
        if velocity[2] >= 0.0 {
            let expected = "a projectile that runs into the gel along -z: --speed gives its speed";
            return Err(refuse("projectile.velocity", &format!("found {velocity:?}, expected {expected}")));
        }
        Ok(Self { name, overrides, scene, strength, options })
    }

    /// Loads the scene with another yield stress, Pa.
    fn load_with(&self, yield_stress: f64) -> Result<SceneSource, CommandError> {
        let fitted = Override { key: FITTED_KEY.to_owned(), value: format!("{yield_stress:?}") };
        let overrides: Vec<Override> = self.overrides.iter().cloned().chain([fitted]).collect();
        source::load(self.name, &overrides)
    }

    fn refuse(&self, key: &str, why: &str) -> CommandError {
        CommandError::BadInput(format!("scene {}: {key}: {why}", self.name))
    }
}
