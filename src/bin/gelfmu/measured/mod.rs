//! `--measured`: the laboratory's curves over those of a run, and their residuals.

mod computed;
mod quantity;
mod table;

pub use table::{MeasuredTable, read};

use crate::failure::RunError;
use crate::results;
use crate::rounding::rounded;
use ballistic_gel::output::{ComparedCurve, insert_comparison};
use serde_json::{Value, json};
use std::path::Path;

/// Comparison of a table with the results of a run.
pub struct MeasuredComparison {
    file: String,
    curves: Vec<ComparedCurve>,
    notes: Vec<String>,
    /// Residuals and curves without a comparison, in sentences.
    pub residuals: Vec<String>,
}

impl MeasuredComparison {
    /// Returns the page of a report with the comparison in it.
    pub fn insert_into(&self, page: &str) -> String {
        insert_comparison(page, &self.file, &self.curves, &self.notes)
    }
}

/// Compares a table with the results in a folder, and writes the comparison into `summary.json`.
pub fn compare(table: &MeasuredTable, folder: &Path) -> Result<MeasuredComparison, RunError> {
    let summary_file = folder.join("summary.json");
    let text = read_file(&summary_file)?;
    let summary: Value = serde_json::from_str(&text).unwrap_or_default();
    let (mut curves, mut notes, mut entries) = (vec![], table.notes.clone(), vec![]);
    for measured in &table.curves {
        let computed = computed::curve(folder, &summary, measured.quantity, table.abscissa)?;
        let key = measured.quantity.key();
        if computed.is_empty() {
            let by = table.abscissa.name();
            notes.push(format!(
                "column {}: not compared, the run has no {} by {by}",
                measured.column,
                key.replace('_', " ")
            ));
            entries.push(json!({ "quantity": key, "column": measured.column, "by": table.abscissa, "residual": null }));
            continue;
        }
        let curve = ComparedCurve {
            title: measured.quantity.title(table.abscissa),
            column: measured.column.clone(),
            abscissa: table.abscissa,
            unit: measured.quantity.si_unit(),
            computed,
            measured: measured.points.clone(),
        };
        entries.push(json!({
            "quantity": key,
            "column": curve.column,
            "by": curve.abscissa,
            "unit": curve.unit,
            "residual": curve.residual(),
        }));
        curves.push(curve);
    }
    let measured = json!({ "file": table.file, "curves": entries, "unmatched": table.unmatched });
    write_summary(&summary_file, &text, &measured)?;
    let compared = curves.iter().map(describe_residual);
    let residuals = compared.chain(notes[table.notes.len()..].iter().cloned()).collect();
    Ok(MeasuredComparison { file: table.file.clone(), curves, notes, residuals })
}

fn read_file(path: &Path) -> Result<String, RunError> {
    let failed = |source| RunError::File { verb: "read", path: path.to_path_buf(), source };
    std::fs::read_to_string(path).map_err(failed)
}

/// Last key of a summary with a comparison.
const MEASURED_KEY: &str = ",\n  \"measured\": ";

/// Writes the last key `measured` of `summary.json`, whose order of keys stays.
fn write_summary(path: &Path, text: &str, measured: &Value) -> Result<(), RunError> {
    let value = format!("{measured:#}").replace('\n', "\n  ");
    let before = text.split_once(MEASURED_KEY).map(|(before, _)| before);
    let body = before.unwrap_or_else(|| text.trim_end().trim_end_matches('}').trim_end());
    results::replace(path, format!("{body}{MEASURED_KEY}{value}\n}}\n").as_bytes())
}

/// Describes the residual of a curve in one line.
fn describe_residual(curve: &ComparedCurve) -> String {
    let Some(residual) = curve.residual() else {
        return format!("{}: no point of column {} lies within the computed curve", curve.title, curve.column);
    };
    let share = |percent: Option<f64>| percent.map_or(String::new(), |percent| format!(" ({percent:.2} %)"));
    format!(
        "{}: {} points of column {}, rms residual {} {}{}, greatest {} {}{}",
        curve.title,
        residual.points,
        curve.column,
        rounded(residual.rms),
        curve.unit,
        share(residual.rms_percent),
        rounded(residual.greatest),
        curve.unit,
        share(residual.greatest_percent)
    )
}
