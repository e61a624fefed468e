//! `--measured`: the laboratory's curves over those of a run, and their residuals.

mod computed;
mod quantity;
mod summary_file;
mod table;

pub use table::{MeasuredTable, read};

use crate::failure::RunError;
use crate::rounding::rounded;
use ballistic_gel::output::{ComparedCurve, UnitSystem, insert_comparison};
use serde_json::json;
use std::path::Path;
use summary_file::SummaryFile;

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
pub fn compare(table: &MeasuredTable, folder: &Path, units: UnitSystem) -> Result<MeasuredComparison, RunError> {
    let mut summary = SummaryFile::read(folder)?;
    let (mut curves, mut notes, mut entries) = (vec![], table.notes.clone(), vec![]);
    for measured in &table.curves {
        let computed = computed::curve(folder, &summary.value, measured.quantity, table.abscissa)?;
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
    summary.set("measured", &json!({ "file": table.file, "curves": entries, "unmatched": table.unmatched }));
    summary.write()?;
    let compared = curves.iter().map(|curve| describe_residual(curve, units));
    let residuals = compared.chain(notes[table.notes.len()..].iter().cloned()).collect();
    Ok(MeasuredComparison { file: table.file.clone(), curves, notes, residuals })
}

/// Describes the residual of a curve in one line.
fn describe_residual(curve: &ComparedCurve, units: UnitSystem) -> String {
    let Some(residual) = curve.residual() else {
        return format!("{}: no point of column {} lies within the computed curve", curve.title, curve.column);
    };
    let customary = units.customary_unit(curve.unit);
    let (unit, in_si) = customary.map_or((curve.unit, 1.0), |unit| (unit.symbol, unit.in_si));
    // In figures, and with an exponent where nobody would count them.
    let told = |value: f64| {
        let value = rounded(value / in_si);
        if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") }
    };
    let share = |percent: Option<f64>| percent.map_or(String::new(), |percent| format!(" ({percent:.2} %)"));
    format!(
        "{}: {} points of column {}, rms residual {} {}{}, greatest {} {}{}",
        curve.title,
        residual.points,
        curve.column,
        told(residual.rms),
        unit,
        share(residual.rms_percent),
        told(residual.greatest),
        unit,
        share(residual.greatest_percent)
    )
}
