//! The runs as Markdown and as CSV.

use super::master::Master;
use super::{ERRORS, Row, STEPS, Sheet};
use std::fmt::Write as _;

/// Steps from 1 ms to 0.1 ms.
const DECADE: usize = 4;

/// One table per error: a row per step, a column per master.
pub fn print(sheet: &Sheet) {
    for (i, what) in ERRORS.iter().enumerate() {
        println!("{}\n{}", heading(&format!("{}, {what}: H, s", sheet.scene)), "|---".repeat(8) + "|");
        for step in STEPS {
            let errors = sheet.at(step).map(|row| format!("{:+.1e}", row.errors[i]));
            println!("| {step:.1e} | {} |", errors.collect::<Vec<_>>().join(" | "));
        }
        println!();
    }
    let tries = sheet.of(Master::Iterated).map(|row| format!("{:.1}", row.tries)).collect::<Vec<_>>().join(", ");
    println!("{}: `iterated` computes a step {tries} times, from the longest to the shortest;", sheet.scene);
    println!("the smallest element step is {:.0e} s.\n", sheet.element_step);
}

/// Observed orders in the decade of the longest steps: below it the steps of the elements set a floor.
pub fn print_orders(sheets: &[Sheet]) {
    println!("{}\n{}", heading("order from 1 ms to 0.1 ms"), "|---".repeat(8) + "|");
    for sheet in sheets {
        for (i, what) in ERRORS.iter().enumerate() {
            let orders = Master::ALL.map(|master| order(&sheet.of(master).take(DECADE).collect::<Vec<_>>(), i));
            println!("| {}, {what} | {} |", sheet.scene, orders.join(" | "));
        }
    }
}

fn heading(first: &str) -> String {
    format!("| {first} | {} |", Master::ALL.map(Master::name).join(" | "))
}

/// Least-squares slope of log |e| against log H; none at round-off.
fn order(runs: &[&Row], error: usize) -> String {
    if runs.iter().all(|row| row.errors[error].abs() < 1e-10) {
        return "–".to_owned();
    }
    let points = runs.iter().map(|row| (row.step.ln(), row.errors[error].abs().ln()));
    let n = runs.len() as f64;
    let (x, y) = points.clone().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / n, sum.1 + point.1 / n));
    let (above, below) = points.fold((0.0, 0.0), |sum, point| {
        let from = point.0 - x;
        (sum.0 + from * (point.1 - y), sum.1 + from * from)
    });
    format!("{:.1}", above / below)
}

/// Everything, a row per run.
pub fn csv(sheets: &[Sheet]) -> String {
    let mut text = "scene,master,step_s,velocity_error,energy_error,residual,tries_per_step\n".to_owned();
    for sheet in sheets {
        for row in &sheet.rows {
            let [velocity, energy, residual] = row.errors.map(|error| format!("{error:.3e}"));
            let (scene, master, step, tries) = (&sheet.scene, row.master.name(), row.step, row.tries);
            writeln!(text, "{scene},{master},{step:e},{velocity},{energy},{residual},{tries:.2}").expect("a string");
        }
    }
    text
}

impl Sheet {
    /// Runs of a master, the longest step first.
    pub fn of(&self, master: Master) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.master == master)
    }

    fn at(&self, step: f64) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.step == step)
    }
}
