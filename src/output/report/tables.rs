//! Tables of the report.

use super::format::{count, escape, peak_force_label, percent, quantity, ratio};
use crate::math::Vector3;
use crate::output::summary::{FragmentFigures, RunSummary};
use crate::scene::{body_name, numbered};
use std::fmt::Write;

/// Returns the table of the fragments; empty without fragments.
pub(super) fn fragments(summary: &RunSummary) -> String {
    if summary.fragments.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for (i, fragment) in summary.fragments.iter().enumerate() {
        let cells = fragment_cells(fragment);
        row(&mut rows, &body_name(i + 1), &cells.each_ref().map(String::as_str));
    }
    let peak_force = peak_force_label(summary.force_window);
    let heads = [
        "fragment",
        "state at the end",
        "greatest depth",
        "depth at the end",
        "speed at the end",
        &peak_force,
        "impulse",
    ];
    format!("<section><h2>Fragments</h2>\n{}</section>\n", table("Fragments at the end of the run", &heads, &rows))
}

fn fragment_cells(fragment: &FragmentFigures) -> [String; 6] {
    let length = |vector: [f64; 3]| Vector3::from(vector).norm();
    [
        if fragment.active { "active" } else { "inactive" }.to_string(),
        quantity(fragment.peak_depth, "m"),
        quantity(fragment.final_depth, "m"),
        quantity(length(fragment.final_velocity), "m/s"),
        quantity(fragment.peak_force, "N"),
        quantity(length(fragment.total_impulse), "N s"),
    ]
}

/// Returns the table of the sensors; empty without sensors.
pub(super) fn sensors(summary: &RunSummary) -> String {
    if summary.sensors.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for (i, sensor) in summary.sensors.iter().enumerate() {
        let [x, y, z] = sensor.position.map(|length| quantity(length, "m"));
        let dent = sensor.dent.map_or(["–".to_string(), "–".to_string()], |dent| {
            [quantity(dent.depth, "m"), quantity(dent.viscous_criterion, "m/s")]
        });
        let pressure = quantity(sensor.peak_pressure, "Pa");
        let (time, rate) = (quantity(sensor.time_of_peak_pressure, "s"), quantity(sensor.peak_pressure_rate, "Pa/s"));
        row(
            &mut rows,
            &numbered("sensor", i),
            &[&format!("{x}, {y}, {z}"), &pressure, &time, &rate, &dent[0], &dent[1]],
        );
    }
    let heads =
        ["sensor", "reference position", "peak pressure", "at time", "peak pressure rate", "dent", "viscous criterion"];
    format!("<section><h2>Sensors</h2>\n{}</section>\n", table("Sensor measurements", &heads, &rows))
}

/// Returns the table of the energy accounts at the end, with the errors of the balances.
pub(super) fn energy(summary: &RunSummary) -> String {
    let initial = summary.initial_energy();
    let mut rows = String::new();
    for account in &summary.accounts {
        let share = if initial == 0.0 { "–".to_string() } else { percent(account.value / initial) };
        let (name, meaning) = (account.name.replace('_', " "), account.meaning);
        let value = quantity(account.value, "J");
        row(&mut rows, &name, &[meaning, &value, &share]);
    }
    let heads = ["account", "meaning", "energy", "share of the initial energy"];
    let errors = format!(
        "<p>Imbalance relative to the throughput: energy {}, momentum {}, angular momentum {}. Numerical energy \
         defect: {} of the initial energy and the external work. Change of mass: {}.</p>\n",
        ratio(summary.energy_error),
        ratio(summary.momentum_error),
        ratio(summary.angular_momentum_error),
        percent(summary.energy_defect),
        summary.mass_error.map_or("not known".to_string(), ratio)
    );
    format!("<section><h3>Energy</h3>\n{}{errors}</section>\n", table("Energy accounts at the end", &heads, &rows))
}

/// Returns the table of the cost, compared with a synchronous integrator.
pub(super) fn cost(summary: &RunSummary) -> String {
    let mut rows = String::new();
    row(&mut rows, "Element updates", &[&count(summary.element_updates)]);
    row(&mut rows, "Updates with one global time step", &[&count(summary.synchronous_updates)]);
    let saved = summary.synchronous_updates / summary.element_updates;
    row(&mut rows, "Ratio", &[&ratio(saved)]);
    row(&mut rows, "Smallest step", &[&quantity(summary.smallest_step, "s")]);
    row(&mut rows, "Largest step", &[&quantity(summary.largest_step, "s")]);
    row(&mut rows, "Elements", &[&count(summary.elements as f64)]);
    row(&mut rows, "Nodes", &[&count(summary.nodes as f64)]);
    row(&mut rows, "Wall time", &[&quantity(summary.wall_seconds, "s")]);
    row(&mut rows, "CPU time", &[&quantity(summary.cpu_seconds, "s")]);
    row(&mut rows, "Of it shared among threads", &[&quantity(summary.parallel_seconds, "s")]);
    row(&mut rows, "Contact solves that did not converge", &[&count(summary.unconverged_solves as f64)]);
    row(&mut rows, "Updates per second", &[&count(summary.updates_per_second)]);
    row(&mut rows, "Threads", &[&summary.threads.to_string()]);
    format!("<section><h3>Cost</h3>\n{}</section>\n", table("Cost of the run", &["", "value"], &rows))
}

/// Returns the table of the effects switched off in the scene.
pub(super) fn switched_off(summary: &RunSummary) -> String {
    if summary.switched_off.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for entry in &summary.switched_off {
        row(&mut rows, entry, &[]);
    }
    format!(
        "<section><h3>Switched off</h3>\n{}</section>\n",
        table("Effects not modelled in this scene", &["effect"], &rows)
    )
}

/// Appends a table row; cells are HTML, the row name is text.
pub(super) fn row(rows: &mut String, name: &str, cells: &[&str]) {
    write!(rows, "<tr><th scope=\"row\">{}</th>", escape(name)).expect("a string grows");
    for cell in cells {
        write!(rows, "<td>{cell}</td>").expect("a string grows");
    }
    *rows += "</tr>\n";
}

/// Returns a table with a caption; heads and rows are HTML.
pub(super) fn table(caption: &str, heads: &[&str], rows: &str) -> String {
    let heads = heads.join("</th><th scope=\"col\">");
    format!(
        "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\"><table><caption>{caption}</caption>\n\
         <thead><tr><th scope=\"col\">{heads}</th></tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
    )
}
