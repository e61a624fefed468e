//! Plots of the report against time.

use super::depths;
use super::format::quantity;
use super::plot::{CurvePlot, HorizontalAxis, PlotCurve, VerticalScale};
use crate::math::Vector3;
use crate::output::history::HistoryRow;
use crate::output::saved_run::SavedShot;
use crate::scene::{Scene, numbered};

/// Least travel of a curve relative to the liveliest curve of its plot: flatter curves would overlap at zero.
const MIN_RELATIVE_TRAVEL: f64 = 1e-3;
/// Lower limit of plotted errors: zero has no logarithm.
const MIN_ERROR: f64 = 1e-18;

/// Returns the plots against time; a plot of constant curves is left out.
pub(super) fn charts(scene: &Scene, rows: &[HistoryRow], shot: Option<&SavedShot>) -> String {
    let of_shot = shot.into_iter().flat_map(|shot| [depths::energy_by_time(shot), depths::cavity_by_time(shot)]);
    let plots = [speed_plot(rows), force_plot(rows, scene.force_window()), position_plot(rows)];
    let plots = plots.into_iter().chain(of_shot).chain([energy_plot(rows)]);
    let sensors = [
        sensor_plot(scene, rows, "Pressure at the sensors", "Pa", 0),
        sensor_plot(scene, rows, "Displacement along z at the sensors", "m", 3),
    ];
    let figures: String =
        sensors.into_iter().chain(plots).filter(|plot| !plot.curves.is_empty()).map(|plot| plot.figure()).collect();
    if figures.is_empty() {
        figures
    } else {
        format!("<section><h2>Time histories</h2>\n<div class=\"plots\">{figures}</div></section>\n")
    }
}

/// Returns the plot of the imbalances; empty if all are constant.
pub(super) fn imbalances(rows: &[HistoryRow]) -> String {
    let plot = balance_errors(rows);
    if plot.curves.is_empty() { String::new() } else { plot.figure() }
}

fn position_plot(rows: &[HistoryRow]) -> CurvePlot {
    let curves = ["x", "y", "z"].map(|axis| (format!("position {axis}"), format!("position_{axis}_m")));
    CurvePlot {
        title: "Position of the projectile",
        unit: "m",
        vertical: VerticalScale::Linear,
        horizontal: time_axis(rows),
        curves: select_visible(changing_curves(rows, &curves)),
    }
}

fn speed_plot(rows: &[HistoryRow]) -> CurvePlot {
    let curves = ["x", "y", "z"].map(|axis| (format!("velocity {axis}"), format!("velocity_{axis}_m_per_s")));
    CurvePlot {
        title: "Velocity of the projectile",
        unit: "m/s",
        vertical: VerticalScale::Linear,
        horizontal: time_axis(rows),
        curves: select_visible(changing_curves(rows, &curves)),
    }
}

/// Returns the plot of the mean force, over the window of the peak force and over a 200th of the run.
fn force_plot(rows: &[HistoryRow], window: f64) -> CurvePlot {
    let history: Vec<(f64, Vector3)> =
        rows.iter().map(|row| (row.get("time_s"), row.vector("total_impulse_", "_N_s"))).collect();
    let fine = history.last().map_or(window, |last| last.0 / 200.0).min(window);
    let curves = [(fine, "a short window"), (window, "the window of the peak force")].map(|(width, name)| {
        PlotCurve::line(format!("mean over {name}, {}", quantity(width, "s")), moving_mean(&history, width))
    });
    let curves = curves.into_iter().filter(PlotCurve::varies).collect();
    CurvePlot {
        title: "Force on the projectile",
        unit: "N",
        vertical: VerticalScale::Linear,
        horizontal: time_axis(rows),
        curves,
    }
}

/// Returns the mean force over a window of at least this width, s, behind each row, at the middle of the window.
fn moving_mean(history: &[(f64, Vector3)], width: f64) -> Vec<(f64, f64)> {
    let mut first = 0;
    let mut points = Vec::with_capacity(history.len());
    for to in history {
        while history.get(first + 1).is_some_and(|next| next.0 <= to.0 - width * (1.0 - 1e-9)) {
            first += 1;
        }
        let from = &history[first];
        if to.0 > from.0 && to.0 - from.0 >= width * (1.0 - 1e-9) {
            points.push((0.5 * (from.0 + to.0), (to.1 - from.1).norm() / (to.0 - from.0)));
        }
    }
    points
}

fn energy_plot(rows: &[HistoryRow]) -> CurvePlot {
    let names = [
        "kinetic",
        "projectile",
        "elastic",
        "contact",
        "self_contact",
        "friction",
        "contact_bias",
        "integration",
        "external",
        "expansion",
        "importer",
        "remesh",
        "remesh_returned",
        "load",
        "air",
        "damping",
        "bulk_viscous",
        "viscous",
        "eroded",
        "damage",
        "imbalance",
    ];
    let curves = names.map(|name| (name.replace('_', " "), format!("energy_{name}_J")));
    CurvePlot {
        title: "Energy accounts",
        unit: "J",
        vertical: VerticalScale::Linear,
        horizontal: time_axis(rows),
        curves: select_visible(changing_curves(rows, &curves)),
    }
}

/// Returns the plot of a column over all sensors.
fn sensor_plot(
    scene: &Scene,
    rows: &[HistoryRow],
    title: &'static str,
    unit: &'static str,
    column: usize,
) -> CurvePlot {
    let n = scene.sensor.len();
    let points = |i: usize| rows.iter().map(|row| (row.get("time_s"), row.sensor(i, n)[column])).collect();
    let curves = (0..n).map(|i| PlotCurve::line(numbered("sensor", i), points(i)));
    let curves = curves.filter(PlotCurve::varies).take(CurvePlot::MAX_CURVES).collect();
    CurvePlot { title, unit, vertical: VerticalScale::Linear, horizontal: time_axis(rows), curves }
}

fn balance_errors(rows: &[HistoryRow]) -> CurvePlot {
    let names = ["energy", "momentum", "angular_momentum"];
    let curves = names.map(|name| (name.replace('_', " "), format!("{name}_error")));
    let mut curves = changing_curves(rows, &curves);
    for point in curves.iter_mut().flat_map(|curve| &mut curve.points) {
        point.1 = point.1.max(MIN_ERROR).log10();
    }
    CurvePlot {
        title: "Imbalance of energy and momentum, relative to the throughput",
        unit: "",
        vertical: VerticalScale::Decades,
        horizontal: time_axis(rows),
        curves,
    }
}

/// Returns the time axis from the first to the last row, common to all plots of a page.
fn time_axis(rows: &[HistoryRow]) -> HorizontalAxis {
    let at = |row: Option<&HistoryRow>| row.map_or(0.0, |row| row.get("time_s"));
    HorizontalAxis { name: "time", unit: "s", range: at(rows.first())..at(rows.last()) }
}

/// Returns the curves with visible travel, at most as many as there are colours.
fn select_visible(mut curves: Vec<PlotCurve>) -> Vec<PlotCurve> {
    let mut travels: Vec<f64> = curves.iter().map(PlotCurve::travel).collect();
    travels.sort_unstable_by(|a, b| b.total_cmp(a));
    let nth = |n: usize| travels.get(n).copied().unwrap_or(0.0);
    let least = nth(CurvePlot::MAX_CURVES).max(MIN_RELATIVE_TRAVEL * nth(0));
    curves.retain(|curve| curve.travel() > least);
    curves
}

/// Returns the columns that change as curves; `columns` holds curve names and column names.
fn changing_curves(rows: &[HistoryRow], columns: &[(String, String)]) -> Vec<PlotCurve> {
    let points = |column: &str| rows.iter().map(|row| (row.get("time_s"), row.get(column))).collect();
    let curves = columns.iter().map(|(name, column)| PlotCurve::line(name.clone(), points(column)));
    curves.filter(PlotCurve::varies).collect()
}
