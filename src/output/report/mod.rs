//! `report.html`: one self-contained page about a run.

mod axis;
mod charts;
mod compared;
mod crack_slices;
mod depths;
mod figures;
mod film;
mod format;
mod inputs;
mod layers;
mod plot;
mod tables;
mod view;
mod words;
mod wound_profile;

pub use compared::{ComparedCurve, CurveAbscissa, CurvePoint, CurveResidual, insert_comparison};
pub use figures::{FigureRow, figure_rows, summary_schema};
pub(super) use film::speed_pictures;
pub(super) use format::escape;
pub use format::peak_force_label;
pub use layers::layer_rows;

use super::history::HistoryRow;
use super::picture::{Camera, MeshPicture};
use super::saved_run::{SavedRun, SavedRunError, SavedShot};
use super::summary::RunSummary;
use super::view::ViewFrame;
use crate::scene::Scene;
use std::path::Path;

/// Limit of the points of a curve: a plot is 640 pixels wide.
const PLOT_POINTS: usize = 2000;

/// Limit of the number of intervals between pictures, which stand in for the view where there is no WebGL, and in print.
const MAX_PICTURE_INTERVALS: usize = 6;

/// Limit of the number of intervals between frames of the view in three dimensions.
const MAX_VIEW_INTERVALS: usize = 120;

/// Place in the page at which a comparison with measured curves is inserted.
pub(super) const MEASURED_PLACE: &str = "<!-- measured -->\n";

const STYLE: &str = include_str!("style.css");

/// Curves and pictures of a report.
struct ReportData {
    /// History, thinned to at most [`PLOT_POINTS`] rows.
    rows: Vec<HistoryRow>,
    /// Tables of a shot, for a projectile that went deeper than its length.
    shot: Option<SavedShot>,
    /// Pictures of the mesh.
    pictures: Vec<MeshPicture>,
    /// Frames of the view in three dimensions.
    views: Vec<ViewFrame>,
}

/// Returns the report of a run of this scene as HTML, made from the files in its folder.
///
/// # Errors
/// [`SavedRunError`] if a file is missing or is not one of a run.
pub fn report_page(folder: &Path, scene: &Scene) -> Result<String, SavedRunError> {
    let run = SavedRun::open(folder, scene)?;
    let summary = run.summary()?;
    let mut data =
        ReportData { rows: run.history(PLOT_POINTS)?, shot: run.shot(&summary)?, pictures: vec![], views: vec![] };
    let (mut camera, n_frames) = (None, run.n_frames());
    let is_kept = |number: usize, most_intervals: usize| {
        let stride = n_frames.saturating_sub(1).div_ceil(most_intervals).max(1);
        number.is_multiple_of(stride) || number + 1 == n_frames
    };
    let [is_pictured, is_viewed] =
        [MAX_PICTURE_INTERVALS, MAX_VIEW_INTERVALS].map(|most| move |number: usize| is_kept(number, most));
    let kept: Vec<usize> = (0..n_frames).filter(|number| is_pictured(*number) || is_viewed(*number)).collect();
    for (number, frame) in kept.iter().zip(run.frames(kept.iter().copied())?) {
        let frame = frame?;
        if is_pictured(*number) {
            let camera = camera.get_or_insert_with(|| Camera::of(&frame, scene));
            data.pictures.push(MeshPicture::take(&frame, scene, camera));
        }
        if is_viewed(*number) {
            data.views.push(ViewFrame::of(&frame, scene));
        }
    }
    Ok(page(scene, &summary, &data))
}

/// Returns the page as HTML.
fn page(scene: &Scene, summary: &RunSummary, data: &ReportData) -> String {
    let name = escape(&summary.scene);
    let title = escape(&scene.scene.title);
    let sections = [
        words::failure(scene, summary),
        shot(scene, data),
        words::summary(scene, summary),
        words::key_figures(scene, summary),
        MEASURED_PLACE.to_owned(),
        data.shot.as_ref().map_or(String::new(), |shot| depths::charts(scene, shot)),
        charts::charts(scene, &data.rows, data.shot.as_ref()),
        tables::fragments(summary),
        tables::sensors(summary),
        inputs::inputs(scene),
        inputs::validity(scene, summary),
        diagnostics(summary, &data.rows),
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
    let moment = charts::time_of_greatest_energy(&data.rows);
    let (stills, place) = (film::film(moment, &data.pictures), view::place(scene, moment, &data.views));
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
