//! Which curves the report shows.

use super::number::quantity;
use super::plot::{Across, Curve, Height, Plot};
use crate::math::Vector3;
use crate::output::history::Row;
use crate::scene::{Scene, numbered};

/// Curves that move less than this share of the liveliest one would lie on top of each other at zero.
const VISIBLE: f64 = 1e-3;
/// Errors below this are drawn on it: zero has no logarithm.
const FLOOR: f64 = 1e-18;

/// All plots; one whose curves stand still is left out.
pub(super) fn charts(scene: &Scene, rows: &[Row]) -> String {
    let plots = [motion(rows), speed(rows), force(rows, scene.force_window()), energy(rows), closure(rows)];
    let sensed = [
        sensed(scene, rows, ("Pressure at the sensors", "Pa", 0)),
        sensed(scene, rows, ("Displacement along z at the sensors", "m", 3)),
    ];
    let plots: Vec<Plot> = sensed.into_iter().chain(plots).collect();
    let figures: String = plots.iter().filter(|plot| !plot.curves.is_empty()).map(Plot::figure).collect();
    if figures.is_empty() { figures } else { format!("<section><h2>In time</h2>\n{figures}</section>\n") }
}

/// Time at which the gel stores the most energy, s: the fullest picture.
pub(super) fn fullest(rows: &[Row]) -> f64 {
    let stored = |row: &&Row| row.get("energy_elastic_J");
    rows.iter()
        .filter(|row| stored(row).is_finite())
        .max_by(|a, b| stored(a).total_cmp(&stored(b)))
        .map_or(0.0, |row| row.get("time_s"))
}

fn motion(rows: &[Row]) -> Plot {
    let curves = ["x", "y", "z"].map(|axis| (format!("position {axis}"), format!("position_{axis}_m")));
    Plot {
        title: "Position of the projectile",
        unit: "m",
        height: Height::Linear,
        across: span(rows),
        curves: visible(moving(rows, &curves)),
    }
}

fn speed(rows: &[Row]) -> Plot {
    let curves = ["x", "y", "z"].map(|axis| (format!("velocity {axis}"), format!("velocity_{axis}_m_per_s")));
    Plot {
        title: "Velocity of the projectile",
        unit: "m/s",
        height: Height::Linear,
        across: span(rows),
        curves: visible(moving(rows, &curves)),
    }
}

/// Mean force over the window of the peak force, and over windows of a 200th of the run.
fn force(rows: &[Row], window: f64) -> Plot {
    let history: Vec<(f64, Vector3)> =
        rows.iter().map(|row| (row.get("time_s"), row.triple("total_impulse_", "_N_s"))).collect();
    let fine = history.last().map_or(window, |last| last.0 / 200.0).min(window);
    let curves = [(fine, "a short window"), (window, "the window of the peak force")].map(|(width, name)| Curve {
        name: format!("mean over {name}, {}", quantity(width, "s")),
        points: moving_mean(&history, width),
    });
    let curves = curves.into_iter().filter(Curve::varies).collect();
    Plot { title: "Force on the projectile", unit: "N", height: Height::Linear, across: span(rows), curves }
}

/// Mean force over a window of at least this width, s, behind each row; drawn in the middle of the window.
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

fn energy(rows: &[Row]) -> Plot {
    let names = [
        "kinetic",
        "projectile",
        "elastic",
        "contact",
        "friction",
        "contact_bias",
        "integration",
        "external",
        "importer",
        "remesh",
        "load",
        "damping",
        "plastic",
        "viscous",
        "splash",
        "damage",
        "closure",
    ];
    let curves = names.map(|name| (name.replace('_', " "), format!("energy_{name}_J")));
    Plot {
        title: "Energy accounts",
        unit: "J",
        height: Height::Linear,
        across: span(rows),
        curves: visible(moving(rows, &curves)),
    }
}

/// One of the columns of all sensors.
fn sensed(scene: &Scene, rows: &[Row], (title, unit, column): (&'static str, &'static str, usize)) -> Plot {
    let n = scene.sensor.len();
    let points = |i: usize| rows.iter().map(|row| (row.get("time_s"), row.sensor(i, n)[column])).collect();
    let curves = (0..n).map(|i| Curve { name: numbered("sensor", i), points: points(i) });
    let curves = curves.filter(Curve::varies).take(Plot::MOST_CURVES).collect();
    Plot { title, unit, height: Height::Linear, across: span(rows), curves }
}

fn closure(rows: &[Row]) -> Plot {
    let names = ["energy", "momentum", "angular_momentum"];
    let curves = names.map(|name| (name.replace('_', " "), format!("{name}_error")));
    let mut curves = moving(rows, &curves);
    for point in curves.iter_mut().flat_map(|curve| &mut curve.points) {
        point.1 = point.1.max(FLOOR).log10();
    }
    Plot {
        title: "What no account explains, relative to what went through",
        unit: "",
        height: Height::Decades,
        across: span(rows),
        curves,
    }
}

/// From the first to the last row: all plots of a page have the same axis.
fn span(rows: &[Row]) -> Across {
    let at = |row: Option<&Row>| row.map_or(0.0, |row| row.get("time_s"));
    Across { name: "time", unit: "s", range: at(rows.first())..at(rows.last()) }
}

/// The curves that can be told from a line at rest, the liveliest as far as there are colours.
fn visible(mut curves: Vec<Curve>) -> Vec<Curve> {
    let mut travels: Vec<f64> = curves.iter().map(Curve::travel).collect();
    travels.sort_unstable_by(|a, b| b.total_cmp(a));
    let nth = |n: usize| travels.get(n).copied().unwrap_or(0.0);
    let least = nth(Plot::MOST_CURVES).max(VISIBLE * nth(0));
    curves.retain(|curve| curve.travel() > least);
    curves
}

/// The columns that change, as curves: (name, column).
fn moving(rows: &[Row], columns: &[(String, String)]) -> Vec<Curve> {
    let points = |column: &str| rows.iter().map(|row| (row.get("time_s"), row.get(column))).collect();
    let curves = columns.iter().map(|(name, column)| Curve { name: name.clone(), points: points(column) });
    curves.filter(Curve::varies).collect()
}
