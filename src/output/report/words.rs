//! Summary of the run in sentences.

use super::figures::{FigureRow, page_rows, per_thickness};
use super::format::{escape, quantity};
use crate::math::Vector3;
use crate::output::summary::RunSummary;
use crate::scene::Scene;
use std::fmt::Write;

/// Returns a box with the diagnosis of an early stop; empty for a completed run.
pub(super) fn failure(scene: &Scene, summary: &RunSummary) -> String {
    let ended =
        || format!("The run was ended there; the end time of the scene is {}.", quantity(scene.scene.end_time, "s"));
    let diagnosis = match &summary.failure {
        Some(diagnosis) => escape(diagnosis),
        None if summary.completed => return String::new(),
        None => ended(),
    };
    format!(
        "<section class=\"failure\" role=\"alert\"><h2>This run stopped early, at {}</h2>\n<p>{}</p>\n\
         <p>All results below were computed before this time and are valid.</p></section>\n",
        quantity(summary.end_time, "s"),
        diagnosis
    )
}

/// Returns the summary paragraph.
pub(super) fn summary(scene: &Scene, summary: &RunSummary) -> String {
    let (depth, fragments) = (depth_sentence(summary), fragment_sentence(summary));
    let mut sentences = vec![
        impact_sentence(scene, summary),
        expansion_sentence(summary),
        depth,
        outcome_sentence(scene, summary),
        fragments,
        thickness_sentence(scene),
    ];
    sentences.retain(|sentence| !sentence.is_empty());
    format!("<section><p class=\"lead\">{}</p></section>\n", sentences.join(" ").trim())
}

fn impact_sentence(scene: &Scene, summary: &RunSummary) -> String {
    let speed = (Vector3::from(scene.projectile.velocity) - Vector3::from(scene.gel.velocity)).norm();
    let gel = Vector3::from(scene.gel.velocity).norm();
    let meets = if summary.contact_duration.is_some() { "strikes the gel" } else { "starts" };
    match (scene.projectile.fixed, speed > 0.0, gel > 0.0) {
        (true, _, true) => {
            format!("The gel moves at {} against a fixed body.", quantity(gel, "m/s"))
        }
        (true, ..) => "The projectile is fixed.".to_string(),
        (false, true, _) => format!("A projectile {meets} at {}.", quantity(speed, "m/s")),
        (false, false, _) => format!("A projectile {meets} from rest."),
    }
}

/// Returns the sentence on the opening of an expanding projectile; empty for any other.
fn expansion_sentence(summary: &RunSummary) -> String {
    let (Some(opening), Some(diameter)) = (summary.expansion.expansion, summary.expansion.expanded_diameter) else {
        return String::new();
    };
    if opening > 0.0 {
        format!("It opens to {} across.", quantity(diameter, "m"))
    } else {
        "It does not open.".to_string()
    }
}

fn depth_sentence(summary: &RunSummary) -> String {
    if summary.peak_depth <= 0.0 || summary.contact_duration.is_none() {
        return String::new();
    }
    let when = quantity(summary.time_of_peak_depth, "s");
    if summary.exit.perforated {
        let thickness = quantity(summary.peak_depth, "m");
        return format!("Its tip reaches the back face of the gel, <strong>{thickness}</strong> deep, after {when}.");
    }
    format!("It reaches its greatest depth, <strong>{}</strong>, after {when}.", quantity(summary.peak_depth, "m"))
}

fn outcome_sentence(scene: &Scene, summary: &RunSummary) -> String {
    let force = if summary.peak_force > 0.0 {
        let window = quantity(summary.force_window, "s");
        let force = quantity(summary.peak_force, "N");
        format!("The force on the projectile peaks at {force}{} (mean over {window}).", per_thickness(scene))
    } else {
        "No force has acted on the projectile.".to_string()
    };
    let end = match summary.rebound_velocity {
        _ if scene.projectile.fixed => String::new(),
        _ if summary.exit.perforated => exit_sentence(summary),
        Some(speed) if speed > 0.0 && summary.final_depth > 0.0 => format!(
            " At {} it rebounds at <strong>{}</strong>, at a depth of {}.",
            quantity(summary.end_time, "s"),
            quantity(speed, "m/s"),
            quantity(summary.final_depth, "m")
        ),
        Some(speed) if speed > 0.0 => {
            format!(" It rebounds from the gel at <strong>{}</strong>.", quantity(speed, "m/s"))
        }
        Some(_) => " It moves on past the gel.".to_string(),
        None => {
            let speed = quantity(Vector3::from(summary.final_velocity).norm(), "m/s");
            format!(" At {} it moves at <strong>{speed}</strong>.", quantity(summary.end_time, "s"))
        }
    };
    force + &end
}

/// Returns the sentence on the exit of a perforating projectile; empty otherwise.
fn exit_sentence(summary: &RunSummary) -> String {
    let Some(exit) = exit_state(summary) else { return String::new() };
    format!(
        " It has perforated the gel: it left the back face with <strong>{}</strong> at {}, deposited {} in the gel \
         and retained {}.",
        quantity(exit.speed, "m/s"),
        quantity(exit.time, "s"),
        quantity(summary.exit.energy_deposited, "J"),
        quantity(exit.residual_energy, "J")
    )
}

/// State of the projectile at the exit.
struct ExitState {
    /// Speed, m/s.
    speed: f64,
    /// Time, s.
    time: f64,
    /// Kinetic energy, J.
    residual_energy: f64,
}

/// Returns the state at the exit of a perforating projectile.
fn exit_state(summary: &RunSummary) -> Option<ExitState> {
    let speed = Vector3::from(summary.exit.exit_velocity?).norm();
    Some(ExitState { speed, time: summary.exit.exit_time?, residual_energy: summary.exit.residual_energy? })
}

fn fragment_sentence(summary: &RunSummary) -> String {
    let there = match summary.fragments.len() {
        0 => return String::new(),
        1 => "is one fragment".to_string(),
        n => format!("are {n} fragments"),
    };
    let active = summary.fragments.iter().filter(|fragment| fragment.active).count();
    format!("There {there} beside the projectile, {active} of {} active at the end.", summary.fragments.len())
}

fn thickness_sentence(scene: &Scene) -> String {
    match per_thickness(scene) {
        "" => String::new(),
        per => format!("All masses, forces, impulses and energies on this page are{per}."),
    }
}

/// Returns the list of key figures.
pub(super) fn key_figures(scene: &Scene, summary: &RunSummary) -> String {
    let summary_value = serde_json::to_value(summary).expect("names and numbers can always be written");
    let mut list = String::from("<section aria-label=\"Key figures\"><dl class=\"figures\">\n");
    for FigureRow { name, text, .. } in page_rows(&summary_value, scene) {
        let [name, text] = [name, text].map(|text| escape(&text));
        writeln!(list, "<div><dt>{name}</dt><dd>{text}</dd></div>").expect("a string grows");
    }
    list + "</dl></section>\n"
}
