//! `report.html`: one self-contained page about a run.

mod axis;
mod charts;
mod compared;
mod depths;
mod film;
mod format;
mod inputs;
mod plot;
mod tables;
mod view;
mod words;
mod wound_profile;

pub use compared::{ComparedCurve, CurveAbscissa, CurvePoint, CurveResidual, insert_comparison};
pub(super) use film::speed_pictures;
pub(super) use format::{escape, format_tick, quantity, ratio};

use super::history::HistoryRow;
use super::penetration::PenetrationRecord;
use super::picture::MeshPicture;
use super::summary::RunSummary;
use super::view::ViewFrame;
use crate::scene::Scene;

/// Limit of the points of a curve: a plot is 640 pixels wide.
pub(super) const PLOT_POINTS: usize = 2000;

/// Place in the page at which a comparison with measured curves is inserted.
pub(super) const MEASURED_PLACE: &str = "<!-- measured -->\n";

pub(super) const STYLE: &str = include_str!("style.css");

/// Data for the curves and pictures of a report.
pub(super) struct ReportData<'a> {
    /// History, thinned to at most [`PLOT_POINTS`] rows.
    pub(super) rows: &'a [HistoryRow],
    /// Pictures of the mesh.
    pub(super) shots: &'a [&'a MeshPicture],
    /// Frames of the view in three dimensions.
    pub(super) views: &'a [&'a ViewFrame],
    /// Penetration record, for a projectile that went deeper than its length.
    pub(super) penetration: Option<&'a PenetrationRecord>,
}

/// Returns the page as HTML.
pub(super) fn page(scene: &Scene, summary: &RunSummary, data: &ReportData) -> String {
    let name = escape(&summary.scene);
    let title = escape(&scene.scene.title);
    let sections = [
        words::failure(scene, summary),
        shot(scene, data),
        words::summary(scene, summary),
        words::key_figures(scene, summary),
        MEASURED_PLACE.to_owned(),
        data.penetration.map_or(String::new(), depths::charts),
        charts::charts(scene, data.rows, data.penetration),
        tables::fragments(summary),
        tables::sensors(summary),
        inputs::inputs(scene),
        inputs::validity(scene, summary),
        diagnostics(summary, data.rows),
        words::origin(summary),
        view::script(),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{name} — ballistic-gel</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n<main>\n\
         <header><h1>{name}</h1>\n<p class=\"title\">{title}</p></header>\n{}</main>\n</body>\n</html>\n",
        view::STYLE,
        sections.concat()
    )
}

/// Returns the section of the shot: the view in three dimensions, and pictures where it cannot be shown or is printed.
fn shot(scene: &Scene, data: &ReportData) -> String {
    let moment = charts::time_of_greatest_energy(data.rows);
    let (stills, place) = (film::film(moment, data.shots), view::place(scene, moment, data.views));
    if stills.is_empty() && place.is_empty() {
        return String::new();
    }
    format!("<section aria-label=\"The shot\">\n{place}{stills}</section>\n")
}

/// Returns the folded section of the solver: balances, cost and the effects switched off.
fn diagnostics(summary: &RunSummary, rows: &[HistoryRow]) -> String {
    format!(
        "<section><details class=\"diagnostics\"><summary>Solver diagnostics</summary>\n{}{}{}{}</details></section>\n",
        tables::energy(summary),
        charts::imbalances(rows),
        tables::cost(summary),
        tables::switched_off(summary)
    )
}
