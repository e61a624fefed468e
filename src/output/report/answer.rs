//! Answer of a shot in a few large figures: how deep or how fast out, the widest cavity, the most energy, the opening.

use super::figures::per_thickness;
use super::format::{centimetres, quantity, shortest};
use crate::math::Vector3;
use crate::output::summary::RunSummary;
use crate::scene::Scene;
use std::fmt::Write;

/// Large figure of the answer.
pub(super) struct AnswerFigure {
    /// Quantity.
    pub(super) name: &'static str,
    /// Value with its unit, or a word.
    pub(super) value: String,
    /// Place, time and other circumstances.
    pub(super) details: String,
}

impl AnswerFigure {
    fn new(name: &'static str, value: String, details: &[String]) -> Self {
        let told: Vec<&str> = details.iter().map(String::as_str).filter(|text| !text.is_empty()).collect();
        Self { name, value, details: told.join(", ") }
    }
}

/// Returns the figures of the answer: penetration, cavity, energy and expansion, as far as the run has them.
pub(super) fn figures(scene: &Scene, summary: &RunSummary) -> [Option<AnswerFigure>; 4] {
    [
        Some(penetration(scene, summary)).filter(|_| !scene.projectile.fixed),
        cavity(summary),
        energy(scene, summary),
        expansion(summary),
    ]
}

/// Returns the answer, with the number of doubts about it.
pub(super) fn answer(scene: &Scene, summary: &RunSummary) -> String {
    let mut list = String::new();
    for AnswerFigure { name, value, details } in figures(scene, summary).into_iter().flatten() {
        writeln!(list, "<div><dt>{name}</dt><dd>{value}</dd><dd class=\"details\">{details}</dd></div>")
            .expect("a string grows");
    }
    let doubts = match summary.doubts.len() {
        0 => "No reason to doubt these figures was found; the limits of the model are told below.".to_owned(),
        1 => "One doubt about these figures, and the limits of the model, are told below.".to_owned(),
        n => format!("{n} doubts about these figures, and the limits of the model, are told below."),
    };
    let list = if list.is_empty() { list } else { format!("<dl class=\"answer\">\n{list}</dl>\n") };
    format!("<section aria-label=\"Answer\">{list}<p class=\"hint\">{doubts}</p></section>\n")
}

/// Returns the exit speed of a perforation, or the depth.
fn penetration(scene: &Scene, summary: &RunSummary) -> AnswerFigure {
    let exit = summary.exit.exit_velocity.map(|velocity| Vector3::from(velocity).norm());
    if let Some(speed) = exit.filter(|_| summary.exit.perforated) {
        let gel = scene.gel.shape.thickness().map(|thickness| format!("through {} of gel", centimetres(thickness)));
        let rest = summary.exit.residual_energy.map(|energy| format!("with {} left", quantity(energy, "J")));
        return AnswerFigure::new(
            "Perforated, exit speed",
            quantity(speed, "m/s"),
            &[gel, rest].map(Option::unwrap_or_default),
        );
    }
    let is_reached = summary.contact_duration.is_some() && summary.peak_depth > 0.0;
    if !is_reached {
        let name = "Depth";
        return AnswerFigure::new(name, "none".to_owned(), &["the projectile has not struck the gel".to_owned()]);
    }
    if let (Some(depth), Some(time)) = (summary.wound.rest_depth, summary.wound.time_of_rest) {
        let greatest = match summary.peak_depth - depth {
            spring if spring > 5e-4 => format!("{} deep before it sprang back", quantity(summary.peak_depth, "m")),
            _ => String::new(),
        };
        let when = format!("at rest after {}", quantity(time, "s"));
        return AnswerFigure::new("Not perforated, depth", quantity(depth, "m"), &[when, greatest]);
    }
    let when = format!("after {}", quantity(summary.time_of_peak_depth, "s"));
    let end = match summary.rebound_velocity {
        Some(speed) if speed > 0.0 && summary.final_depth <= 0.0 => {
            format!("then it rebounds at {}", quantity(speed, "m/s"))
        }
        _ => "not at rest when the run ends".to_owned(),
    };
    let thickness = scene.gel.shape.thickness().unwrap_or(f64::INFINITY);
    let name = match summary.peak_depth {
        depth if depth >= thickness * (1.0 - 1e-6) => "Reached the back face, not perforated, depth",
        _ => "Not perforated, greatest depth",
    };
    AnswerFigure::new(name, quantity(summary.peak_depth, "m"), &[when, end])
}

/// Returns the widest temporary cavity and its place.
fn cavity(summary: &RunSummary) -> Option<AnswerFigure> {
    let diameter = summary.wound.greatest_cavity_diameter?;
    let place = summary.wound.depth_of_greatest_cavity.map(|depth| format!("{} deep", centimetres(depth)));
    let when = summary.wound.time_of_greatest_cavity.map(|time| format!("after {}", quantity(time, "s")));
    let still = summary.wound.cavity_still_opening.filter(|opens| *opens).map(|_| "still opening".to_owned());
    Some(AnswerFigure::new(
        "Widest temporary cavity",
        quantity(diameter, "m"),
        &[place, when, still].map(Option::unwrap_or_default),
    ))
}

/// Returns the greatest energy in a centimetre of depth and its place.
fn energy(scene: &Scene, summary: &RunSummary) -> Option<AnswerFigure> {
    let energies = summary.energy_per_centimetre.as_ref()?.iter().copied().enumerate();
    let (i, most) = energies.filter(|(_, energy)| *energy > 0.0).max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let place = format!("from {i} to {} cm deep", i + 1);
    let given = format!("of {} given", quantity(summary.exit.energy_deposited, "J"));
    let value = format!("{} J/cm", shortest(most));
    Some(AnswerFigure::new("Most energy to the gel", value + per_thickness(scene), &[place, given]))
}

/// Returns the opening of an expanding projectile.
fn expansion(summary: &RunSummary) -> Option<AnswerFigure> {
    let (opening, diameter) = (summary.expansion.expansion?, summary.expansion.expanded_diameter?);
    let value = if opening > 0.0 { quantity(diameter, "m") } else { "none".to_owned() };
    let part = match opening {
        opening if opening >= 1.0 => "wide, opened completely".to_owned(),
        opening if opening > 0.0 => format!("wide, {} % open", shortest(100.0 * opening)),
        _ => "the projectile did not open".to_owned(),
    };
    Some(AnswerFigure::new("Expansion", value, &[part]))
}
