//! Which curves the report shows.

use super::plot::{Curve, Height, Plot};
use crate::algebra::Vector3;
use crate::output::history::Row;
use crate::scene::Scene;

/// Errors below this are drawn on it: zero has no logarithm.
const FLOOR: f64 = 1e-18;

/// All plots; one whose curves stand still is left out.
pub(super) fn charts(scene: &Scene, rows: &[Row]) -> String {
    let plots = [motion(rows), speed(rows), force(rows, scene.force_window()), energy(rows), closure(rows)];
    let figures: String = plots.iter().filter(|plot| !plot.curves.is_empty()).map(Plot::figure).collect();
    if figures.is_empty() { figures } else { format!("<section><h2>In time</h2>\n{figures}</section>\n") }
}

fn motion(rows: &[Row]) -> Plot {
    let curves = ["x", "y", "z"].map(|axis| (format!("position {axis}"), format!("position_{axis}_m")));
    Plot { title: "Position of the projectile", unit: "m", height: Height::Linear, curves: moving(rows, &curves) }
}

fn speed(rows: &[Row]) -> Plot {
    let curves = ["x", "y", "z"].map(|axis| (format!("velocity {axis}"), format!("velocity_{axis}_m_per_s")));
    Plot { title: "Velocity of the projectile", unit: "m/s", height: Height::Linear, curves: moving(rows, &curves) }
}

/// Mean force between rows, and over the window of the peak force.
fn force(rows: &[Row], window: f64) -> Plot {
    let history: Vec<(f64, Vector3)> =
        rows.iter().map(|row| (row.get("time_s"), row.triple("total_impulse_", "_N_s"))).collect();
    let step = history.windows(2).filter(|pair| pair[1].0 > pair[0].0);
    let step = step.map(|pair| (0.5 * (pair[0].0 + pair[1].0), mean_force(&pair[0], &pair[1])));
    let mut first = 0;
    let mean = (0..history.len()).filter_map(|last| {
        while history[last].0 - history[first].0 > window * (1.0 + 1e-9) {
            first += 1;
        }
        let (from, to) = (&history[first.saturating_sub(1)], &history[last]);
        (to.0 - from.0 >= window * (1.0 - 1e-9)).then(|| (0.5 * (from.0 + to.0), mean_force(from, to)))
    });
    let curves = [
        Curve { name: "mean between rows".into(), points: step.collect() },
        Curve { name: "mean over the force window".into(), points: mean.collect() },
    ];
    let curves = curves.into_iter().filter(Curve::varies).collect();
    Plot { title: "Force on the projectile", unit: "N", height: Height::Linear, curves }
}

fn mean_force(from: &(f64, Vector3), to: &(f64, Vector3)) -> f64 {
    (to.1 - from.1).norm() / (to.0 - from.0)
}

fn energy(rows: &[Row]) -> Plot {
    let names = [
        "kinetic",
        "projectile",
        "elastic",
        "contact",
        "contact_bias",
        "integration",
        "external",
        "importer",
        "closure",
    ];
    let curves = names.map(|name| (name.replace('_', " "), format!("energy_{name}_J")));
    Plot { title: "Energy accounts", unit: "J", height: Height::Linear, curves: moving(rows, &curves) }
}

fn closure(rows: &[Row]) -> Plot {
    let names = ["energy", "momentum", "angular_momentum"];
    let curves = names.map(|name| (name.replace('_', " "), format!("{name}_error")));
    let mut curves = moving(rows, &curves);
    for point in curves.iter_mut().flat_map(|curve| &mut curve.points) {
        point.1 = point.1.max(FLOOR).log10();
    }
    Plot { title: "What no account explains, relative to what went through", unit: "", height: Height::Decades, curves }
}

/// The columns that change, as curves: (name, column).
fn moving(rows: &[Row], columns: &[(String, String)]) -> Vec<Curve> {
    let points = |column: &str| rows.iter().map(|row| (row.get("time_s"), row.get(column))).collect();
    let curves = columns.iter().map(|(name, column)| Curve { name: name.clone(), points: points(column) });
    curves.filter(Curve::varies).collect()
}
