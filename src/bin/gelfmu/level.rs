//! Which level of `scene.fidelity` a run is to have, by its name or by the accuracy that is asked for.

use crate::failure::Failure;
use crate::options::LevelOptions;
use crate::source::{self, Source};
use ballistic_gel::scene::{Fidelity, Level, Override, Scene};

/// The scene with the overrides at the level that is asked for, and what is expected of it, if anything was.
pub fn load(name: &str, set: &[Override], asked: &LevelOptions) -> Result<(Source, Option<String>), Failure> {
    let source = source::load(name, set)?;
    let fidelity = match (asked.fidelity, asked.accuracy) {
        (None, None) => return Ok((source, None)),
        (Some(fidelity), _) => fidelity,
        (None, Some(accuracy)) => cheapest(name, &source.scene, accuracy)?,
    };
    let choice = Override { key: "scene.fidelity".to_owned(), value: fidelity.as_str().to_owned() };
    let source = source::load(name, &set.iter().cloned().chain([choice]).collect::<Vec<_>>())?;
    let expected = source.scene.fidelity.get(fidelity).map_or("nothing was measured".to_owned(), expectation);
    Ok((source, Some(format!("fidelity {}: {expected}", fidelity.as_str()))))
}

/// The cheapest level whose error is known and no greater.
fn cheapest(name: &str, scene: &Scene, accuracy: f64) -> Result<Fidelity, Failure> {
    let refuse = |found: &str, expected: &str| {
        let asked = format!("--accuracy {}%", 100.0 * accuracy);
        Err(Failure::BadInput(format!("{asked}: found {found}, expected {expected}")))
    };
    let known = scene.fidelity.known().filter_map(|(fidelity, level)| Some((fidelity, level.error?, level.updates?)));
    let known: Vec<(Fidelity, f64, f64)> = known.collect();
    let Some(best) = known.iter().map(|level| level.1).reduce(f64::min) else {
        let found = format!("scene {name} without a curve that was measured with these values");
        let expected = format!(
            "one with fidelity tables: `gelfmu trade {name}` measures them, with the same --set, and prints the lines"
        );
        return refuse(&found, &expected);
    };
    let fit = known.iter().filter(|level| level.1 <= accuracy).min_by(|a, b| a.2.total_cmp(&b.2));
    let least =
        || format!("at least {}%, the best of its curve, or a finer one (`gelfmu trade --finer`)", percent(best));
    fit.map_or_else(|| refuse("nothing so accurate", &least()), |level| Ok(level.0))
}

/// What a level is expected to miss by and to cost.
pub fn expectation(level: &Level) -> String {
    let error = level.error.map(|error| format!("an error of {} %", percent(error)));
    let updates = level.updates.map(|updates| format!("{:.3} million element updates", 1e-6 * updates));
    let seconds = level.cpu_seconds.map(|seconds| format!("{seconds} CPU seconds where it was measured"));
    let all: Vec<String> = error.into_iter().chain(updates).chain(seconds).collect();
    if all.is_empty() {
        "nothing was measured with these values".to_owned()
    } else {
        format!("expect {}", all.join(", "))
    }
}

/// A part in percent, in three digits.
fn percent(part: f64) -> f64 {
    format!("{:.2e}", 100.0 * part).parse().unwrap_or(100.0 * part)
}
