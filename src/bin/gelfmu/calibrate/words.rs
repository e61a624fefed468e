//! Text and JSON output of a calibration.

use super::search::{ShotOutcome, StrengthSearch, StrengthTrial};
use super::task::{CalibrationEnd, CalibrationTask, FITTED_KEY};
use crate::text_width::new_table;
use comfy_table::presets;
use serde_json::{Value, json};

/// Returns the headline: the scene, the speed and the target depth.
pub fn headline(task: &CalibrationTask) -> String {
    let [x, y, z] = task.scene.projectile.velocity;
    let (name, speed) = (&task.scene.scene.name, (x * x + y * y + z * z).sqrt());
    format!(
        "{name}: the {FITTED_KEY} with which the projectile of {speed:.2} m/s rests {} deep",
        in_millimetres(task.options.depth)
    )
}

/// Describes a trial in one line.
pub fn trial_line(number: usize, trial: &StrengthTrial) -> String {
    format!("run {number}: {}: {}", strength_scale(trial.strength), describe_outcome(&trial.outcome))
}

/// Formats a strength.
pub fn strength_scale(value: f64) -> String {
    format!("strength scale {value:.4}")
}

fn in_millimetres(depth: f64) -> String {
    format!("{:.2} mm", 1e3 * depth)
}

fn describe_outcome(outcome: &ShotOutcome) -> String {
    match outcome {
        ShotOutcome::Stopped { depth, time } => {
            format!("rests {} deep after {:.3} ms", in_millimetres(*depth), 1e3 * time)
        }
        ShotOutcome::Through => "goes deeper".to_owned(),
        ShotOutcome::ThrownBack => "is thrown back out of the gel".to_owned(),
        ShotOutcome::Failed(why) => format!("failed: {why}"),
    }
}

/// Returns the table of all trials, and the lines for the scene file.
pub fn table_and_lines(task: &CalibrationTask, search: &StrengthSearch) -> String {
    let mut table = new_table(presets::UTF8_FULL_CONDENSED);
    table.set_header(["run", "strength", "projectile"]);
    for (i, trial) in search.trials.iter().enumerate() {
        let told = match &trial.outcome {
            ShotOutcome::Failed(_) => "failed".to_owned(),
            known => describe_outcome(known),
        };
        table.add_row([(i + 1).to_string(), strength_scale(trial.strength), told]);
    }
    let Some((best, depth)) = search.best() else { return format!("{table}\nIn no run does the projectile rest.") };
    let percent = 100.0 * search.relative_error(depth);
    let met = format!(
        "{}: {}, {percent:.2} % from {}",
        strength_scale(best.strength),
        in_millimetres(depth),
        in_millimetres(task.options.depth)
    );
    format!("{table}\n{met}\n\n{}", scene_lines(task, best))
}

/// Returns the lines for the scene file: the fitted strength, and the velocity if it was an option.
fn scene_lines(task: &CalibrationTask, best: &StrengthTrial) -> String {
    let strength = format!("[gel]\nstrength_scale = {:?}", best.strength);
    let velocity = |_| format!("\n\n[projectile]\nvelocity = {:?}", task.scene.projectile.velocity);
    strength + &task.options.speed.map_or(String::new(), velocity)
}

/// Returns the calibration as JSON.
pub fn to_json(task: &CalibrationTask, search: &StrengthSearch, end: &CalibrationEnd) -> Value {
    let status = match end {
        CalibrationEnd::Fitted => "fitted",
        CalibrationEnd::Interrupted => "interrupted",
        CalibrationEnd::GivenUp(_) => "not fitted",
    };
    let trials: Vec<Value> = search.trials.iter().map(trial_json).collect();
    let best = search.best();
    json!({
        "scene": task.scene.scene.name,
        "depth": task.options.depth,
        "status": status,
        "strength_scale": best.map(|(trial, _)| trial.strength),
        "reached_depth": best.map(|(_, depth)| depth),
        "relative_error": best.map(|(_, depth)| search.relative_error(depth)),
        "lines": best.map(|(trial, _)| scene_lines(task, trial)),
        "trials": trials,
    })
}

fn trial_json(trial: &StrengthTrial) -> Value {
    let (depth, time, failure) = match &trial.outcome {
        ShotOutcome::Stopped { depth, time } => (Some(depth), Some(time), None),
        ShotOutcome::Through | ShotOutcome::ThrownBack => (None, None, None),
        ShotOutcome::Failed(why) => (None, None, Some(why)),
    };
    json!({ "strength_scale": trial.strength, "depth": depth, "time": time, "failure": failure })
}
