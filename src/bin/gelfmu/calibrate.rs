//! `gelfmu calibrate`: fits the strength of a gel to the depth at which a projectile stopped in it.

mod search;
mod trial;
mod words;

use crate::console::Console;
use crate::failure::Failure;
use crate::interrupt;
use crate::options::CalibrateOptions;
use crate::progress::Bar;
use crate::source::{self, Source};
use ballistic_gel::scene::{Override, Scene, StrengthSpec};
use search::{Next, Outcome, Search, Trial};
use std::ops::ControlFlow;

/// What is fitted.
const KEY: &str = "gel.strength.yield_stress";
/// Name of the scene that is calibrated if none is named.
const SCENE: &str = "fbi-bb";
/// What the first Ctrl-C is answered with.
const WAITING: &str = "interrupted: the best strength so far is kept; Ctrl-C again ends it at once";

/// What is asked for: the scene, its strength, and how deep the projectile has to go, m.
struct Task<'a> {
    name: &'a str,
    overrides: Vec<Override>,
    scene: Scene,
    strength: StrengthSpec,
    options: &'a CalibrateOptions,
}

/// Why no further strength is tried.
enum End {
    /// The depth was met.
    Fitted,
    /// The user stopped it.
    Interrupted,
    /// It cannot be met: why.
    GivenUp(String),
}

/// Fits the strength, prints what to write into the scene, and says with which status to end.
pub fn calibrate(options: &CalibrateOptions, console: &Console) -> Result<u8, Failure> {
    let task = Task::read(options)?;
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will not keep the best strength so far: {error}"));
    }
    console.note(&words::heading(&task));
    let mut search = Search::new(options.depth, task.strength.yield_stress, task.strength.cap);
    let end = fit(&task, &mut search, console)?;
    console.result(&words::value(&task, &search, &end), &words::text(&task, &search));
    Ok(match end {
        End::Fitted => 0,
        End::Interrupted => {
            console.error("interrupted; above is the best strength so far, if there is one");
            interrupt::INTERRUPTED
        }
        End::GivenUp(why) => {
            console.error(&format!("{KEY} was not fitted: {why}"));
            1
        }
    })
}

/// Tries strengths until one of them fits.
fn fit(task: &Task, search: &mut Search, console: &Console) -> Result<End, Failure> {
    loop {
        let yield_stress = match search.next() {
            Next::Fitted => return Ok(End::Fitted),
            Next::GivenUp(why) => return Ok(End::GivenUp(why)),
            Next::OutOfReach(why) => return Err(task.refuse("--depth", &why)),
            Next::Try(yield_stress) => yield_stress,
        };
        let Some(outcome) = attempt(task, search, yield_stress, console)? else {
            return Ok(End::Interrupted);
        };
        let trial = Trial { yield_stress, outcome };
        console.note(&words::trial(search.trials.len() + 1, &trial));
        search.trials.push(trial);
    }
}

/// One run with this strength, with a bar; nothing if it was interrupted.
fn attempt(task: &Task, search: &Search, yield_stress: f64, console: &Console) -> Result<Option<Outcome>, Failure> {
    let (bar, number) = (Bar::new(console), search.trials.len() + 1);
    let expected = search.time_to_stop().unwrap_or(task.scene.scene.end_time);
    let mut watch = |time: f64, depth: f64| {
        let what = format!("run {number}, {}: {:.1} mm deep", words::stress(yield_stress), 1e3 * depth);
        bar.show_part(&what, (time / expected).min(1.0));
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let scene = task.with(yield_stress)?.scene;
    let outcome = trial::run(scene, task.options, &mut watch);
    bar.clear();
    outcome
}

/// Fastest projectile that is calibrated, m/s: beyond, gel and projectile flow whatever their strength.
const FASTEST: f64 = 5000.0;

/// Explains why a speed, m/s, is none of a projectile that gel stops.
fn too_fast(speed: f64) -> Option<String> {
    let meant = if speed <= 1e3 * FASTEST {
        format!("; were mm/s meant? They are {} m/s", 1e-3 * speed)
    } else {
        String::new()
    };
    (speed > FASTEST).then(|| format!("found {speed:?} m/s, expected at most {FASTEST:?} m/s{meant}"))
}

impl<'a> Task<'a> {
    fn read(options: &'a CalibrateOptions) -> Result<Self, Failure> {
        let name = options.scene.as_deref().unwrap_or(SCENE);
        let mut overrides = options.set.clone();
        if let Some(speed) = options.speed {
            let value = format!("[0.0, 0.0, {:?}]", -speed);
            overrides.push(Override { key: "projectile.velocity".to_owned(), value });
        }
        let scene = source::load(name, &overrides)?.scene;
        let refuse = |key: &str, why: &str| Failure::BadInput(format!("scene {name}: {key}: {why}"));
        let Some(strength) = scene.gel.strength else {
            let example = "{ yield_stress = 10e3, rate_exponent = 0.23, cap = 0.16e6, confined = { pressure = 0.3e6, factor = 15.0, time = 3e-6 } }";
            let why = format!(
                "found none, expected gel.material = \"flowing\" with the strength to begin with, such as gel.strength = {example}"
            );
            return Err(refuse("gel.strength", &why));
        };
        if let Some(why) = options.speed.and_then(too_fast) {
            return Err(Failure::BadInput(format!("--speed: {why}")));
        }
        if let Some(why) = scene.gel.shape.thickness().and_then(|gel| trial::too_deep(options.depth, gel)) {
            return Err(Failure::BadInput(format!("--depth: {why}")));
        }
        let velocity = scene.projectile.velocity;
        if velocity[2] >= 0.0 {
            let expected = "a projectile that runs into the gel along -z: --speed gives its speed";
            return Err(refuse("projectile.velocity", &format!("found {velocity:?}, expected {expected}")));
        }
        Ok(Self { name, overrides, scene, strength, options })
    }

    /// The scene with another strength.
    fn with(&self, yield_stress: f64) -> Result<Source, Failure> {
        let fitted = Override { key: KEY.to_owned(), value: format!("{yield_stress:?}") };
        let overrides: Vec<Override> = self.overrides.iter().cloned().chain([fitted]).collect();
        source::load(self.name, &overrides)
    }

    fn refuse(&self, key: &str, why: &str) -> Failure {
        Failure::BadInput(format!("scene {}: {key}: {why}", self.name))
    }
}
