//! What a calibration prints.

use super::search::{Outcome, Search, Trial};
use super::{End, KEY, Task};
use comfy_table::{Table, presets};
use serde_json::{Value, json};

/// What is going to be done.
pub fn heading(task: &Task) -> String {
    let [x, y, z] = task.scene.projectile.velocity;
    let (name, speed) = (&task.scene.scene.name, (x * x + y * y + z * z).sqrt());
    format!(
        "{name}: the {KEY} with which the projectile of {speed:.2} m/s stops {} deep",
        millimetres(task.options.depth)
    )
}

/// A trial as a line.
pub fn trial(number: usize, trial: &Trial) -> String {
    format!("run {number}: {}: {}", stress(trial.yield_stress), end(&trial.outcome))
}

/// A stress, kPa.
pub fn stress(value: f64) -> String {
    format!("{:.3} kPa", 1e-3 * value)
}

fn millimetres(depth: f64) -> String {
    format!("{:.2} mm", 1e3 * depth)
}

fn end(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Stopped { depth, time } => format!("{} deep after {:.3} ms", millimetres(*depth), 1e3 * time),
        Outcome::Through => "goes deeper".to_owned(),
        Outcome::Failed(why) => format!("failed: {why}"),
    }
}

/// All trials, and the lines for the scene.
pub fn text(task: &Task, search: &Search) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_header(["run", "yield stress", "projectile stops"]);
    for (i, trial) in search.trials.iter().enumerate() {
        let end = match &trial.outcome {
            Outcome::Failed(_) => "failed".to_owned(),
            known => end(known),
        };
        table.add_row([(i + 1).to_string(), stress(trial.yield_stress), end]);
    }
    let Some((best, depth)) = search.best() else { return format!("{table}\nNo run stopped the projectile.") };
    let miss = 100.0 * search.miss(depth);
    let met = format!(
        "{}: {}, {miss:.2} % from {}",
        stress(best.yield_stress),
        millimetres(depth),
        millimetres(task.options.depth)
    );
    format!("{table}\n{met}\n\n{}", lines(task, best))
}

/// What to write into the scene.
fn lines(task: &Task, best: &Trial) -> String {
    let (strength, fitted) = (task.strength, best.yield_stress);
    let confined = strength.confined.map_or(String::new(), |confined| {
        let time = if confined.time > 0.0 { format!(", time = {:?}", confined.time) } else { String::new() };
        format!(", confined = {{ pressure = {:?}, factor = {:?}{time} }}", confined.pressure, confined.factor)
    });
    let strength = format!(
        "[gel]\nstrength = {{ yield_stress = {fitted:?}, reference_rate = {:?}, rate_exponent = {:?}, cap = {:?}{confined} }}",
        strength.reference_rate, strength.rate_exponent, strength.cap
    );
    let velocity = |_| format!("\n\n[projectile]\nvelocity = {:?}", task.scene.projectile.velocity);
    strength + &task.options.speed.map_or(String::new(), velocity)
}

/// The same for scripts.
pub fn value(task: &Task, search: &Search, how: &End) -> Value {
    let status = match how {
        End::Fitted => "fitted",
        End::Interrupted => "interrupted",
        End::GivenUp(_) => "not fitted",
    };
    let trials: Vec<Value> = search.trials.iter().map(row).collect();
    let best = search.best();
    json!({
        "scene": task.scene.scene.name,
        "depth": task.options.depth,
        "status": status,
        "yield_stress": best.map(|(trial, _)| trial.yield_stress),
        "reached_depth": best.map(|(_, depth)| depth),
        "relative_error": best.map(|(_, depth)| search.miss(depth)),
        "lines": best.map(|(trial, _)| lines(task, trial)),
        "trials": trials,
    })
}

fn row(trial: &Trial) -> Value {
    let (depth, time, failure) = match &trial.outcome {
        Outcome::Stopped { depth, time } => (Some(depth), Some(time), None),
        Outcome::Through => (None, None, None),
        Outcome::Failed(why) => (None, None, Some(why)),
    };
    json!({ "yield_stress": trial.yield_stress, "depth": depth, "time": time, "failure": failure })
}
