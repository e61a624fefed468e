//! The curve on paper: a table for the console, Markdown, CSV and JSON.

use super::curve::{Assessed, Curve, QUANTITIES, Reference};
use super::levels;
use super::row::Row;
use crate::console::Console;
use ballistic_gel::output::{OutputError, ResultFolder};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes `trade.md`, `trade.csv` and, if there is one, the picture; one of an earlier curve goes.
pub fn write(folder: &mut ResultFolder, curve: &Curve, picture: Option<String>) -> Result<(), OutputError> {
    let [markdown_file, csv_file, picture_file] = FILES;
    folder.write(markdown_file, markdown(curve).as_bytes())?;
    folder.write(csv_file, csv(curve).as_bytes())?;
    match picture {
        Some(picture) => folder.write(picture_file, picture.as_bytes()),
        None => folder.remove(picture_file),
    }
}

/// Names of the files of a curve.
pub const FILES: [&str; 3] = ["trade.md", "trade.csv", "trade.svg"];

/// Columns of the tables; those of the errors are of [`QUANTITIES`].
const BEFORE: [&str; 5] = ["knob", "run", "elements", "M updates", "CPU s"];
const AFTER: [&str; 2] = ["worst, %", "best"];

fn header() -> Vec<String> {
    let errors = QUANTITIES.iter().map(|quantity| format!("{}, %", quantity.name));
    let (before, after) = (BEFORE.map(str::to_owned), AFTER.map(str::to_owned));
    before.into_iter().chain(errors).chain(after).collect()
}

fn cells(assessed: &Assessed) -> Vec<String> {
    let rung = &assessed.run.rung;
    let names = [rung.knob.to_owned(), rung.label()];
    match &assessed.run.row {
        Ok(row) if row.failure.is_none() => names.into_iter().chain(figures(assessed, row)).collect(),
        Ok(row) => names.into_iter().chain(cost(row)).chain(["failed".to_owned()]).collect(),
        Err(_) => names.into_iter().chain(["-", "-", "-", "refused"].map(str::to_owned)).collect(),
    }
}

fn cost(row: &Row) -> [String; 3] {
    [row.elements.to_string(), digits(1e-6 * row.element_updates), digits(row.cpu_seconds)]
}

fn figures(assessed: &Assessed, row: &Row) -> impl Iterator<Item = String> {
    let percent = |error: Option<f64>| error.map_or("-".to_owned(), |error| digits(100.0 * error));
    let held = match (assessed.error, assessed.held) {
        (Some(own), Some(held)) if held > 1.001 * own => format!("{} ({})", digits(100.0 * own), digits(100.0 * held)),
        (own, _) => percent(own),
    };
    let best = if assessed.best { "*" } else { "" };
    cost(row).into_iter().chain(assessed.errors.map(percent)).chain([held, best.to_owned()])
}

/// Three digits.
fn digits(value: f64) -> String {
    let before = if value == 0.0 { 1 } else { value.abs().log10().floor() as i32 + 1 };
    let after = usize::try_from((3 - before).clamp(0, 5)).unwrap_or(0);
    format!("{value:.after$}")
}

/// What every quantity is compared with, a sentence each.
fn references(curve: &Curve) -> Vec<String> {
    let sentence = |(quantity, reference): (&super::curve::Quantity, &Reference)| {
        let (unit, per) = quantity.unit;
        match reference {
            Reference::Limit(limit, family) => format!(
                "{}: {} {unit}, the limit of refinement ({family}, observed order {:.2}); the finest mesh is {} % away",
                quantity.name,
                digits4(limit.value * per),
                limit.order,
                digits(100.0 * limit.reach)
            ),
            Reference::Refused(why) => format!("{}: no reference, its three finest values are {why}", quantity.name),
            Reference::Missing => format!("{}: no reference, fewer than three meshes have it", quantity.name),
        }
    };
    QUANTITIES.iter().zip(&curve.references).map(sentence).collect()
}

fn digits4(value: f64) -> String {
    let before = if value == 0.0 { 1 } else { value.abs().log10().floor() as i32 + 1 };
    let after = usize::try_from((5 - before).clamp(0, 6)).unwrap_or(0);
    format!("{value:.after$}")
}

/// Runs that did not reach their end, and why.
fn failures(curve: &Curve) -> Vec<String> {
    let sentence = |assessed: &Assessed| {
        let label = assessed.run.rung.label();
        match &assessed.run.row {
            Ok(row) => {
                row.failure.as_ref().map(|why| format!("{label}: failed after {:.4} ms: {why}", 1e3 * row.end_time))
            }
            Err(why) => Some(format!("{label}: refused: {why}")),
        }
    };
    curve.runs.iter().filter_map(sentence).collect()
}

const LEGEND: &str = "errors are relative to the limit of refinement of the same scene; worst is the greatest of them, in brackets \
                      with those of all finer runs of the knob; * marks what no cheaper run does as well";

/// For the console.
pub fn text(curve: &Curve, folder: &Path, console: &Console) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(header());
    for assessed in &curve.runs {
        table.add_row(cells(assessed));
    }
    table.column_iter_mut().skip(2).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let lists = [("references", references(curve)), ("did not reach their end", failures(curve))];
    let lists = lists.into_iter().filter(|(_, lines)| !lines.is_empty());
    let lists: Vec<String> =
        lists.map(|(name, lines)| format!("{}\n  {}", console.heading(name), lines.join("\n  "))).collect();
    let chosen = levels::choose(curve);
    let levels = if chosen.is_empty() {
        "no levels: too few runs have a known error\n".to_owned()
    } else {
        format!("{}\n{}", console.heading("levels, as lines of the scene"), levels::lines(&chosen))
    };
    let files = FILES.map(|name| folder.join(name));
    let files: Vec<String> = files.iter().filter(|path| path.exists()).map(|path| path.display().to_string()).collect();
    format!("{table}\n{LEGEND}\n\n{}\n\n{levels}\n{}", lists.join("\n\n"), files.join("\n"))
}

fn markdown(curve: &Curve) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let header = header();
    let rule: Vec<String> = header.iter().map(|_| "---".to_owned()).collect();
    let pad = |mut cells: Vec<String>| {
        cells.resize(header.len(), String::new());
        cells
    };
    let rows = curve.runs.iter().map(|assessed| line(&pad(cells(assessed))));
    let lists = [references(curve), failures(curve)].concat();
    let lists: Vec<String> = lists.iter().map(|sentence| format!("- {sentence}")).collect();
    let chosen = levels::choose(curve);
    let levels = if chosen.is_empty() { String::new() } else { format!("\n```toml\n{}```\n", levels::lines(&chosen)) };
    let table = format!("{}{}{}", line(&header), line(&rule), rows.collect::<String>());
    format!("{table}\n{LEGEND}.\n\n{}\n{levels}", lists.join("\n"))
}

/// All figures, SI, a line per run.
fn csv(curve: &Curve) -> String {
    let values = ["knob", "run", "elements", "element_updates", "cpu_seconds", "wall_seconds"].map(str::to_owned);
    let figures = QUANTITIES.iter().map(|quantity| quantity.key.to_owned());
    let errors = QUANTITIES.iter().map(|quantity| format!("{}_error", quantity.key));
    let last = ["error", "held_error", "best", "failure"].map(str::to_owned);
    let header: Vec<String> = values.into_iter().chain(figures).chain(errors).chain(last).collect();
    let lines = curve.runs.iter().map(|assessed| csv_cells(assessed).join(","));
    [header.join(",")].into_iter().chain(lines).map(|line| line + "\n").collect()
}

fn csv_cells(assessed: &Assessed) -> Vec<String> {
    let (rung, row) = (&assessed.run.rung, assessed.run.row.as_ref().ok());
    let some = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    let cost = [
        row.map_or(String::new(), |row| row.elements.to_string()),
        some(row.map(|row| row.element_updates)),
        some(row.map(|row| row.cpu_seconds)),
        some(row.map(|row| row.wall_seconds)),
    ];
    let values = QUANTITIES.iter().map(|quantity| some(row.and_then(|row| quantity.of(row))));
    let last = [some(assessed.error), some(assessed.held), assessed.best.to_string(), quoted(&failure(assessed))];
    let names = [quoted(rung.knob), quoted(&rung.label())];
    names.into_iter().chain(cost).chain(values).chain(assessed.errors.map(some)).chain(last).collect()
}

fn quoted(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

fn failure(assessed: &Assessed) -> String {
    match &assessed.run.row {
        Ok(row) => row.failure.clone().unwrap_or_default(),
        Err(why) => why.clone(),
    }
}

/// For scripts.
pub fn value(scene: &str, curve: &Curve) -> Value {
    let reference = |reference: &Reference| match reference {
        Reference::Limit(limit, family) => {
            json!({ "value": limit.value, "order": limit.order, "reach": limit.reach, "knob": family })
        }
        Reference::Refused(why) => json!({ "refused": why.to_string() }),
        Reference::Missing => json!({ "refused": "fewer than three meshes have it" }),
    };
    let references: Map<String, Value> =
        QUANTITIES.iter().zip(&curve.references).map(|(q, r)| (q.key.to_owned(), reference(r))).collect();
    let runs: Vec<Value> = curve.runs.iter().map(run).collect();
    let levels: Map<String, Value> = levels::choose(curve)
        .into_iter()
        .map(|(fidelity, level)| (fidelity.as_str().to_owned(), json!(level)))
        .collect();
    json!({ "scene": scene, "references": references, "runs": runs, "levels": levels })
}

fn run(assessed: &Assessed) -> Value {
    let rung = &assessed.run.rung;
    let errors: Map<String, Value> = QUANTITIES
        .iter()
        .zip(assessed.errors)
        .map(|(quantity, error)| (quantity.key.to_owned(), json!(error)))
        .collect();
    json!({
        "knob": rung.knob,
        "run": rung.label(),
        "row": assessed.run.row.as_ref().ok(),
        "refused": assessed.run.row.as_ref().err(),
        "errors": errors,
        "error": assessed.error,
        "held_error": assessed.held,
        "best": assessed.best,
    })
}
