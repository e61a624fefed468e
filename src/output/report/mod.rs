//! `report.html`: the run on one page that needs nothing else, for a person.

mod axis;
mod charts;
mod depths;
mod film;
mod number;
mod plot;
mod tables;
mod words;

pub(super) use number::{mark, quantity, ratio};

use super::history::Row;
use super::penetration::Penetration;
use super::picture::Shot;
use super::summary::Summary;
use crate::scene::Scene;

/// Most points of a curve: a plot is 640 pixels wide.
pub(super) const PLOT_POINTS: usize = 2000;

pub(super) const STYLE: &str = include_str!("style.css");

/// What curves and pictures are made of.
pub(super) struct Seen<'a> {
    /// The history, thinned to at most [`PLOT_POINTS`].
    pub(super) rows: &'a [Row],
    /// The pictures.
    pub(super) shots: &'a [&'a Shot],
    /// What there is along the way of a projectile that has gone deep.
    pub(super) penetration: Option<&'a Penetration>,
}

/// The page.
pub(super) fn page(scene: &Scene, summary: &Summary, seen: &Seen) -> String {
    let name = escape(&summary.scene);
    let title = escape(&scene.scene.title);
    let sections = [
        words::failure(scene, summary),
        words::summary(scene, summary),
        words::key_figures(scene, summary),
        film::film(charts::fullest(seen.rows), seen.shots),
        seen.penetration.map_or(String::new(), depths::charts),
        charts::charts(scene, seen.rows),
        tables::fragments(summary),
        tables::sensors(summary),
        tables::energy(summary),
        tables::cost(summary),
        tables::switched_off(summary),
        words::origin(summary),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{name} — ballistic-gel</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <header><h1>{name}</h1>\n<p class=\"title\">{title}</p></header>\n{}</main>\n</body>\n</html>\n",
        sections.concat()
    )
}

/// Text that HTML takes literally; characters that XML does not allow are replaced.
pub(super) fn escape(text: &str) -> String {
    let is_forbidden = |c: char| (c.is_control() && c != '\n' && c != '\t') || matches!(c, '\u{fffe}' | '\u{ffff}');
    let text = text.replace(is_forbidden, "\u{fffd}");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
