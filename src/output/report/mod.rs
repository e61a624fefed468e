//! `report.html`: one self-contained page about a run.

mod answer;
mod axis;
mod charts;
mod compared;
mod comparison;
mod crack_slices;
mod depths;
mod figures;
mod film;
mod format;
mod identity;
mod inputs;
mod layers;
mod legend;
mod plot;
mod section;
mod shot_inputs;
mod tables;
mod trust;
mod view;
mod words;
mod wound_profile;

pub use compared::{ComparedCurve, CurveAbscissa, CurvePoint, CurveResidual, insert_comparison};
pub use comparison::{ReportRun, comparison_page};
pub use figures::{FigureRow, figure_rows, summary_schema};
pub(super) use film::speed_pictures;
pub(super) use format::escape;
pub use format::peak_force_label;
pub use identity::{LogoImage, MOST_LOGO_BYTES, ReportDate, ReportIdentity};
pub use layers::layer_rows;

use super::history::HistoryRow;
use super::picture::{Camera, MeshPicture};
use super::saved_run::{SavedRun, SavedRunError, SavedShot};
use super::summary::RunSummary;
use super::view::{SectionOutline, ViewFrame};
use crate::scene::Scene;
use section::SectionMoment;
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
    /// Section of the gel at the widest cavity; absent in a run without frames.
    section: Option<SectionOutline>,
}

/// Returns the report of a run of this scene as HTML, made from the files in its folder, with case, author, logo and date
/// as far as they are given.
///
/// # Errors
/// [`SavedRunError`] if a file is missing or is not one of a run.
pub fn report_page(folder: &Path, scene: &Scene, identity: &ReportIdentity) -> Result<String, SavedRunError> {
    let run = SavedRun::open(folder, scene)?;
    let summary = run.summary()?;
    let mut data = ReportData {
        rows: run.history(PLOT_POINTS)?,
        shot: run.shot(&summary)?,
        pictures: vec![],
        views: vec![],
        section: None,
    };
    let moment = SectionMoment::of(&summary);
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
        moment.keep_nearest(&mut data.section, frame.time, || SectionOutline::of(&frame, scene));
        if is_pictured(*number) {
            let camera = camera.get_or_insert_with(|| Camera::of(&frame, scene));
            data.pictures.push(MeshPicture::take(&frame, scene, camera));
        }
        if is_viewed(*number) {
            data.views.push(ViewFrame::of(&frame, scene));
        }
    }
    Ok(page(scene, &summary, &data, identity))
}

/// Returns the page as HTML.
fn page(scene: &Scene, summary: &RunSummary, data: &ReportData, identity: &ReportIdentity) -> String {
    let level = summary.fidelity.as_str();
    let sections = [
        words::failure(scene, summary),
        answer::answer(scene, summary),
        wound(scene, summary, data),
        trust::trust(scene, summary),
        words::summary(scene, summary),
        words::key_figures(scene, summary),
        MEASURED_PLACE.to_owned(),
        shot(scene, summary, data),
        data.shot.as_ref().map_or(String::new(), |shot| depths::charts(scene, shot)),
        charts::charts(scene, &data.rows, data.shot.as_ref()),
        tables::fragments(summary),
        tables::sensors(summary),
        inputs::inputs(scene, level),
        diagnostics(summary, &data.rows),
        view::script(),
    ];
    let headline = identity::headline(scene);
    let body = identity.header(headline, &identity::run_line(scene, level)) + &sections.concat();
    document(headline, &identity.print_style(headline), &body)
}

/// Returns a page with this title, a text, further style, and body.
fn document(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{} — ballistic-gel</title>\n<style>\n{STYLE}{}{style}</style>\n</head>\n<body>\n<main>\n{body}</main>\n\
         </body>\n</html>\n",
        escape(title),
        view::STYLE
    )
}

/// Returns the wound profile and the section at the widest cavity; empty without both.
fn wound(scene: &Scene, summary: &RunSummary, data: &ReportData) -> String {
    let profile = data.shot.as_ref().map_or(String::new(), |shot| wound_profile::figure(scene, shot));
    let of_outline = |outline: &SectionOutline| section::figure(summary, outline, &data.rows, data.shot.as_ref());
    let section = data.section.as_ref().map_or(String::new(), of_outline);
    if profile.is_empty() && section.is_empty() {
        return String::new();
    }
    format!("<section aria-label=\"Wound\">\n{profile}{section}</section>\n")
}

/// Returns the section of the shot: the view in three dimensions, and pictures where it cannot be shown or is printed.
fn shot(scene: &Scene, summary: &RunSummary, data: &ReportData) -> String {
    let moment = SectionMoment::of(summary).time;
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
