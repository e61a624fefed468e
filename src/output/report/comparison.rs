//! Several runs on one page: their figures in one table, curves on common axes, and the values in which the scenes differ.

use super::answer;
use super::axis::finite_range;
use super::depths::{HINT, MIN_YAW, curve_along_track, energy_steps};
use super::document;
use super::format::{bullet_list, escape, peak_force_label, percent, quantity};
use super::identity::ReportIdentity;
use super::plot::{CurvePlot, HorizontalAxis, PlotCurve, VerticalScale};
use super::tables::{row, table};
use super::trust;
use super::view;
use crate::output::saved_run::{SavedRun, SavedRunError, SavedShot, ShotPoint};
use crate::output::summary::RunSummary;
use crate::scene::Scene;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// Run that is compared with others: folder and scene, and a name for tables and legends.
#[derive(Debug, Clone, Copy)]
pub struct ReportRun<'a> {
    /// Name.
    pub name: &'a str,
    /// Folder with the results.
    pub folder: &'a Path,
    /// Scene of the results.
    pub scene: &'a Scene,
}

impl ReportRun<'_> {
    /// Most runs on a page: one for each colour.
    pub const MOST: usize = CurvePlot::MAX_CURVES;
}

/// Results of a run that is compared.
struct ComparedResults<'a> {
    name: String,
    scene: &'a Scene,
    summary: RunSummary,
    shot: Option<SavedShot>,
}

impl<'a> ComparedResults<'a> {
    fn read(run: &ReportRun<'a>) -> Result<Self, SavedRunError> {
        let saved = SavedRun::open(run.folder, run.scene)?;
        let summary = saved.summary()?;
        let shot = saved.shot(&summary)?;
        Ok(Self { name: escape(run.name), scene: run.scene, summary, shot })
    }
}

/// Returns a page that compares runs, made from the files in their folders; the first [`ReportRun::MOST`] have curves.
///
/// # Errors
/// [`SavedRunError`] if a file is missing or is not one of a run.
pub fn comparison_page(runs: &[ReportRun<'_>], identity: &ReportIdentity) -> Result<String, SavedRunError> {
    let all = runs.iter().map(ComparedResults::read).collect::<Result<Vec<_>, _>>()?;
    let headline = format!("{} runs compared", all.len());
    let names: Vec<&str> = all.iter().map(|run| run.name.as_str()).collect();
    let body = [
        identity.header(&headline, &names.join(" · ")),
        figures(&all),
        plots(&all),
        differences(&all),
        trust(&all),
        view::script(),
    ];
    Ok(document(&headline, &identity.print_style(&headline), &body.concat()))
}

/// Returns the heads of a table with a column for each run.
fn heads<'a>(first: &'a str, runs: &'a [ComparedResults<'a>]) -> Vec<&'a str> {
    std::iter::once(first).chain(runs.iter().map(|run| run.name.as_str())).collect()
}

/// Appends a row with a cell of each run.
fn add_row(rows: &mut String, name: &str, runs: &[ComparedResults], cell: impl Fn(&ComparedResults) -> String) {
    let cells: Vec<String> = runs.iter().map(cell).collect();
    row(rows, name, &cells.iter().map(String::as_str).collect::<Vec<_>>());
}

/// Returns the table of the figures.
fn figures(runs: &[ComparedResults]) -> String {
    let mut rows = String::new();
    add_row(&mut rows, "scene", runs, |run| escape(super::identity::headline(run.scene)));
    add_row(&mut rows, "level", runs, |run| run.summary.fidelity.as_str().to_owned());
    for (i, name) in
        ["penetration", "widest temporary cavity", "most energy to the gel", "expansion"].iter().enumerate()
    {
        let cell = |run: &ComparedResults| {
            let figure = answer::figures(run.scene, &run.summary).into_iter().nth(i).flatten();
            figure.map_or("–".to_owned(), |figure| {
                let kind = if i == 0 { format!("{}: ", figure.name) } else { String::new() };
                format!("{kind}<strong>{}</strong>, {}", figure.value, figure.details)
            })
        };
        add_row(&mut rows, name, runs, cell);
    }
    let known = |value: Option<f64>, unit: &str| value.map_or("–".to_owned(), |value| quantity(value, unit));
    add_row(&mut rows, "energy given", runs, |run| quantity(run.summary.exit.energy_deposited, "J"));
    add_row(&mut rows, "permanent track", runs, |run| known(run.summary.wound.greatest_track_diameter, "m"));
    add_row(&mut rows, "neck", runs, |run| known(run.summary.wound.neck_length, "m"));
    add_row(&mut rows, "peak force", runs, |run| {
        let label = peak_force_label(run.summary.force_window);
        let window = label.strip_prefix("peak force, ").unwrap_or(&label);
        format!("{}, {window}", quantity(run.summary.peak_force, "N"))
    });
    add_row(&mut rows, "expected error", runs, |run| {
        run.summary.errors.expected_error.map_or("not measured".to_owned(), percent)
    });
    add_row(&mut rows, "end of the run", runs, |run| {
        let cause = if run.summary.completed { "" } else { ", stopped early" };
        quantity(run.summary.end_time, "s") + cause
    });
    format!("<section>{}</section>\n", table("Figures of the runs", &heads("figure", runs), &rows))
}

/// Returns the plots against depth with a curve of each run.
fn plots(runs: &[ComparedResults]) -> String {
    let along = |value: fn(&ShotPoint) -> f64| {
        move |run: &ComparedResults, shot: &SavedShot| curve_along_track(shot, &run.name, value)
    };
    let cavity = |run: &ComparedResults, shot: &SavedShot| {
        let points = shot.cavity.temporary.iter().map(|(depth, radius)| (*depth, 2.0 * radius));
        PlotCurve::line(run.name.clone(), points.collect())
    };
    let energy = |run: &ComparedResults, shot: &SavedShot| PlotCurve::line(run.name.clone(), energy_steps(shot));
    let all = [
        plot(runs, "Speed of the projectile by depth", "m/s", along(|point| point.velocity)),
        plot(runs, "Diameter of the temporary cavity by depth, widest over the run", "m", cavity),
        plot(runs, "Energy given to the gel in each centimetre of depth", "J", energy),
        plot(runs, "Yaw of the projectile by depth", "°", along(|point| point.yaw.to_degrees()))
            .filter(|plot| highest(plot) > MIN_YAW),
        plot(runs, "Expansion of the projectile by depth", "%", along(|point| 100.0 * point.expansion))
            .filter(|plot| highest(plot) > 0.0),
        plot(runs, "Force on the projectile by depth", "N", along(|point| point.force)),
    ];
    let figures: String = all.iter().flatten().map(CurvePlot::figure).collect();
    if figures.is_empty() {
        return figures;
    }
    format!(
        "<section><h2>Along the path of the projectile</h2>\n{HINT}<div class=\"plots\">{figures}</div></section>\n"
    )
}

/// Returns the plot of a curve of each run over a common depth; `None` without a shot.
fn plot(
    runs: &[ComparedResults],
    title: &'static str,
    unit: &'static str,
    curve: impl Fn(&ComparedResults, &SavedShot) -> PlotCurve,
) -> Option<CurvePlot> {
    let shots = || runs.iter().filter_map(|run| Some((run, run.shot.as_ref()?))).take(ReportRun::MOST);
    let end = shots().map(|(_, shot)| shot.greatest_depth()).reduce(f64::max)?;
    Some(CurvePlot {
        title,
        unit,
        vertical: VerticalScale::FromZero,
        horizontal: HorizontalAxis { name: "depth", unit: "m", range: 0.0..end },
        curves: shots().map(|(run, shot)| curve(run, shot)).collect(),
    })
}

/// Returns the greatest finite value of a plot; 0 without one.
fn highest(plot: &CurvePlot) -> f64 {
    let values = plot.curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
    finite_range(values).map_or(0.0, |range| range.end)
}

/// Returns the table of the values in which the scenes differ, SI units.
fn differences(runs: &[ComparedResults]) -> String {
    let leaves: Vec<BTreeMap<String, String>> = runs.iter().map(|run| scene_leaves(run.scene)).collect();
    let keys: BTreeSet<&String> = leaves.iter().flat_map(BTreeMap::keys).collect();
    let differs = |key: &&String| leaves.windows(2).any(|pair| pair[0].get(*key) != pair[1].get(*key));
    let mut rows = String::new();
    let differing: Vec<&String> = keys.iter().copied().filter(differs).collect();
    for key in &differing {
        let cell = |values: &BTreeMap<String, String>| {
            values.get(*key).map_or("–".to_owned(), |value| format!("<code>{}</code>", escape(value)))
        };
        let cells: Vec<String> = leaves.iter().map(cell).collect();
        row(&mut rows, key, &cells.iter().map(String::as_str).collect::<Vec<_>>());
    }
    let same = keys.len() - differing.len();
    let told = if differing.is_empty() {
        format!("<p>The scenes have the same {same} values.</p>\n")
    } else {
        let caption = "Values in which the scenes differ, SI units";
        table(caption, &heads("key", runs), &rows) + &format!("<p>{same} further values are the same.</p>\n")
    };
    format!("<section><h2>Scenes</h2>\n{told}</section>\n")
}

/// Returns the values of a scene by their dotted keys, without name, title and levels, which change nothing of a run.
fn scene_leaves(scene: &Scene) -> BTreeMap<String, String> {
    let mut leaves = BTreeMap::new();
    collect("", &serde_json::to_value(scene).unwrap_or_default(), &mut leaves);
    leaves.retain(|key, _| !["scene.name", "scene.title"].contains(&key.as_str()) && !key.starts_with("fidelity."));
    leaves
}

fn collect(key: &str, value: &Value, leaves: &mut BTreeMap<String, String>) {
    match value {
        Value::Null => {}
        Value::Object(members) => {
            for (name, value) in members {
                collect(&if key.is_empty() { name.clone() } else { format!("{key}.{name}") }, value, leaves);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            for (i, item) in items.iter().enumerate() {
                collect(&format!("{key}[{}]", i + 1), item, leaves);
            }
        }
        _ => {
            leaves.insert(key.to_owned(), value.to_string());
        }
    }
}

/// Returns the doubts about each run, and the limits of the model, once for runs with the same.
fn trust(runs: &[ComparedResults]) -> String {
    let mut told = String::new();
    for run in runs {
        let sentences = trust::plain_doubts(&run.summary);
        let doubts = if sentences.is_empty() {
            "<p>No reason to doubt the figures was found.</p>".to_owned()
        } else {
            format!("<div class=\"doubts\">{}</div>", bullet_list(&sentences))
        };
        write!(
            told,
            "<h3>{}</h3>\n{doubts}\n<p>{}</p>\n<p class=\"hint\">ballistic-gel {}, state digest <code>{}</code></p>\n",
            run.name,
            trust::limits(run.scene),
            escape(&run.summary.version),
            escape(&run.summary.digest)
        )
        .expect("a string grows");
    }
    format!("<section class=\"trust\"><h2>How far to trust these figures</h2>\n{told}</section>\n")
}
