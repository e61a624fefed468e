//! Error-cost curve as console table, Markdown, CSV and JSON.

use super::curve::{AssessedRun, QUANTITIES, ReferenceValue, TradeCurve};
use super::levels;
use super::row::TradeRow;
use crate::console::Console;
use ballistic_gel::output::{OutputError, ResultFolder};
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes `trade.md`, `trade.csv` and the picture; without a picture, an earlier one is removed.
pub fn write_files(folder: &mut ResultFolder, curve: &TradeCurve, picture: Option<String>) -> Result<(), OutputError> {
    let [markdown_file, csv_file, picture_file] = FILES;
    folder.write(markdown_file, to_markdown(curve).as_bytes())?;
    folder.write(csv_file, to_csv(curve).as_bytes())?;
    match picture {
        Some(picture) => folder.write(picture_file, picture.as_bytes()),
        None => folder.remove(picture_file),
    }
}

/// Names of the result files.
pub const FILES: [&str; 3] = ["trade.md", "trade.csv", "trade.svg"];

/// Columns of the tables before and after the errors of the [`QUANTITIES`].
const LEADING_COLUMNS: [&str; 5] = ["knob", "run", "elements", "M updates", "CPU s"];
const TRAILING_COLUMNS: [&str; 2] = ["worst, %", "best"];

fn column_names() -> Vec<String> {
    let errors = QUANTITIES.iter().map(|quantity| format!("{}, %", quantity.name));
    let (before, after) = (LEADING_COLUMNS.map(str::to_owned), TRAILING_COLUMNS.map(str::to_owned));
    before.into_iter().chain(errors).chain(after).collect()
}

fn table_cells(assessed: &AssessedRun) -> Vec<String> {
    let rung = &assessed.run.rung;
    let names = [rung.knob.to_owned(), rung.label()];
    match &assessed.run.row {
        Ok(row) if row.failure.is_none() => names.into_iter().chain(figure_cells(assessed, row)).collect(),
        Ok(row) => names.into_iter().chain(cost_cells(row)).chain(["failed".to_owned()]).collect(),
        Err(_) => names.into_iter().chain(["-", "-", "-", "refused"].map(str::to_owned)).collect(),
    }
}

fn cost_cells(row: &TradeRow) -> [String; 3] {
    [row.elements.to_string(), three_digits(1e-6 * row.element_updates), three_digits(row.cpu_seconds)]
}

fn figure_cells(assessed: &AssessedRun, row: &TradeRow) -> impl Iterator<Item = String> {
    let percent = |error: Option<f64>| error.map_or("-".to_owned(), |error| three_digits(100.0 * error));
    let worst = match (assessed.error, assessed.confirmed) {
        (Some(own), Some(confirmed)) if confirmed > 1.001 * own => {
            format!("{} ({})", three_digits(100.0 * own), three_digits(100.0 * confirmed))
        }
        (own, _) => percent(own),
    };
    let best = if assessed.is_best { "*" } else { "" };
    cost_cells(row).into_iter().chain(assessed.errors.map(percent)).chain([worst, best.to_owned()])
}

/// Formats a number with three digits.
fn three_digits(value: f64) -> String {
    let before = if value == 0.0 { 1 } else { value.abs().log10().floor() as i32 + 1 };
    let after = usize::try_from((3 - before).clamp(0, 5)).unwrap_or(0);
    format!("{value:.after$}")
}

/// Describes the reference value of each quantity in a sentence.
fn describe_references(curve: &TradeCurve) -> Vec<String> {
    let sentence = |(quantity, reference): (&super::curve::ComparedQuantity, &ReferenceValue)| {
        let unit = quantity.unit;
        match reference {
            ReferenceValue::Limit(limit, family) => format!(
                "{}: {} {unit}, the limit of refinement ({family}, observed order {:.2}); the finest mesh is {} % away",
                quantity.name,
                five_digits(limit.value * quantity.units_per_si),
                limit.order,
                three_digits(100.0 * limit.reach)
            ),
            ReferenceValue::Refused(why) => {
                format!("{}: no reference, its three finest values are {why}", quantity.name)
            }
            ReferenceValue::Missing => format!("{}: no reference, fewer than three meshes have it", quantity.name),
        }
    };
    QUANTITIES.iter().zip(&curve.references).map(sentence).collect()
}

fn five_digits(value: f64) -> String {
    let before = if value == 0.0 { 1 } else { value.abs().log10().floor() as i32 + 1 };
    let after = usize::try_from((5 - before).clamp(0, 6)).unwrap_or(0);
    format!("{value:.after$}")
}

/// Lists the runs that did not reach their end, with the reasons.
fn describe_failures(curve: &TradeCurve) -> Vec<String> {
    let sentence = |assessed: &AssessedRun| {
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

/// Formats the curve for the console.
pub fn to_text(curve: &TradeCurve, folder: &Path, console: &Console) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(column_names());
    for assessed in &curve.runs {
        table.add_row(table_cells(assessed));
    }
    table.column_iter_mut().skip(2).for_each(|column| column.set_cell_alignment(CellAlignment::Right));
    let lists = [("references", describe_references(curve)), ("did not reach their end", describe_failures(curve))];
    let lists = lists.into_iter().filter(|(_, lines)| !lines.is_empty());
    let lists: Vec<String> =
        lists.map(|(name, lines)| format!("{}\n  {}", console.heading(name), lines.join("\n  "))).collect();
    let chosen = levels::choose_levels(curve);
    let levels = if chosen.is_empty() {
        "no levels: too few runs have a known error\n".to_owned()
    } else {
        format!("{}\n{}", console.heading("levels, as lines of the scene"), levels::scene_lines(&chosen))
    };
    let files = FILES.map(|name| folder.join(name));
    let files: Vec<String> = files.iter().filter(|path| path.exists()).map(|path| path.display().to_string()).collect();
    format!("{table}\n{LEGEND}\n\n{}\n\n{levels}\n{}", lists.join("\n\n"), files.join("\n"))
}

fn to_markdown(curve: &TradeCurve) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let header = column_names();
    let rule: Vec<String> = header.iter().map(|_| "---".to_owned()).collect();
    let pad = |mut cells: Vec<String>| {
        cells.resize(header.len(), String::new());
        cells
    };
    let rows = curve.runs.iter().map(|assessed| line(&pad(table_cells(assessed))));
    let lists = [describe_references(curve), describe_failures(curve)].concat();
    let lists: Vec<String> = lists.iter().map(|sentence| format!("- {sentence}")).collect();
    let chosen = levels::choose_levels(curve);
    let levels =
        if chosen.is_empty() { String::new() } else { format!("\n```toml\n{}```\n", levels::scene_lines(&chosen)) };
    let table = format!("{}{}{}", line(&header), line(&rule), rows.collect::<String>());
    format!("{table}\n{LEGEND}.\n\n{}\n{levels}", lists.join("\n"))
}

/// Formats all figures as CSV, SI units, one line per run.
fn to_csv(curve: &TradeCurve) -> String {
    let values = ["knob", "run", "elements", "element_updates", "cpu_seconds", "wall_seconds"].map(str::to_owned);
    let figures = QUANTITIES.iter().map(|quantity| quantity.key.to_owned());
    let errors = QUANTITIES.iter().map(|quantity| format!("{}_error", quantity.key));
    let last = ["error", "held_error", "best", "failure"].map(str::to_owned);
    let header: Vec<String> = values.into_iter().chain(figures).chain(errors).chain(last).collect();
    let lines = curve.runs.iter().map(|assessed| csv_cells(assessed).join(","));
    [header.join(",")].into_iter().chain(lines).map(|line| line + "\n").collect()
}

fn csv_cells(assessed: &AssessedRun) -> Vec<String> {
    let (rung, row) = (&assessed.run.rung, assessed.run.row.as_ref().ok());
    let some = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    let cost = [
        row.map_or(String::new(), |row| row.elements.to_string()),
        some(row.map(|row| row.element_updates)),
        some(row.map(|row| row.cpu_seconds)),
        some(row.map(|row| row.wall_seconds)),
    ];
    let values = QUANTITIES.iter().map(|quantity| some(row.and_then(|row| quantity.value(row))));
    let last = [
        some(assessed.error),
        some(assessed.confirmed),
        assessed.is_best.to_string(),
        quote_csv(&failure_text(assessed)),
    ];
    let names = [quote_csv(rung.knob), quote_csv(&rung.label())];
    names.into_iter().chain(cost).chain(values).chain(assessed.errors.map(some)).chain(last).collect()
}

fn quote_csv(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

fn failure_text(assessed: &AssessedRun) -> String {
    match &assessed.run.row {
        Ok(row) => row.failure.clone().unwrap_or_default(),
        Err(why) => why.clone(),
    }
}

/// Returns the curve as JSON.
pub fn to_json(scene: &str, curve: &TradeCurve) -> Value {
    let reference = |reference: &ReferenceValue| match reference {
        ReferenceValue::Limit(limit, family) => {
            json!({ "value": limit.value, "order": limit.order, "reach": limit.reach, "knob": family })
        }
        ReferenceValue::Refused(why) => json!({ "refused": why.to_string() }),
        ReferenceValue::Missing => json!({ "refused": "fewer than three meshes have it" }),
    };
    let references: Map<String, Value> =
        QUANTITIES.iter().zip(&curve.references).map(|(q, r)| (q.key.to_owned(), reference(r))).collect();
    let runs: Vec<Value> = curve.runs.iter().map(run_json).collect();
    let levels: Map<String, Value> = levels::choose_levels(curve)
        .into_iter()
        .map(|(fidelity, level)| (fidelity.as_str().to_owned(), json!(level)))
        .collect();
    json!({ "scene": scene, "references": references, "runs": runs, "levels": levels })
}

fn run_json(assessed: &AssessedRun) -> Value {
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
        "held_error": assessed.confirmed,
        "best": assessed.is_best,
    })
}
