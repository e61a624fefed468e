//! `report.html`: one self-contained page about a run.

mod axis;
mod charts;
mod depths;
mod film;
mod format;
mod plot;
mod tables;
mod words;

pub(super) use format::{escape, format_tick, quantity, ratio};

use super::history::HistoryRow;
use super::penetration::PenetrationRecord;
use super::picture::MeshPicture;
use super::summary::RunSummary;
use crate::scene::Scene;

/// Limit of the points of a curve: a plot is 640 pixels wide.
pub(super) const PLOT_POINTS: usize = 2000;

pub(super) const STYLE: &str = include_str!("style.css");

/// Data for the curves and pictures of a report.
pub(super) struct ReportData<'a> {
    /// History, thinned to at most [`PLOT_POINTS`] rows.
    pub(super) rows: &'a [HistoryRow],
    /// Pictures of the mesh.
    pub(super) shots: &'a [&'a MeshPicture],
    /// Penetration record, for a projectile that went deeper than its length.
    pub(super) penetration: Option<&'a PenetrationRecord>,
}

/// Returns the page as HTML.
pub(super) fn page(scene: &Scene, summary: &RunSummary, data: &ReportData) -> String {
    let name = escape(&summary.scene);
    let title = escape(&scene.scene.title);
    let sections = [
        words::failure(scene, summary),
        words::summary(scene, summary),
        words::key_figures(scene, summary),
        film::film(charts::time_of_greatest_energy(data.rows), data.shots),
        data.penetration.map_or(String::new(), depths::charts),
        charts::charts(scene, data.rows),
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
