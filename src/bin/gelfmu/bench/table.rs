//! Benchmark results: rows of one table, with further values in JSON.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde_json::{Map, Value};

/// Measured row: what was measured, the figure and its unit, and named values for JSON.
#[derive(Debug, Clone, PartialEq)]
pub struct BenchRow {
    what: String,
    figure: f64,
    unit: &'static str,
    spread: Option<f64>,
    values: Vec<(&'static str, Value)>,
}

impl BenchRow {
    /// Creates a row without values for JSON.
    pub fn new(what: impl Into<String>, figure: f64, unit: &'static str) -> Self {
        Self { what: what.into(), figure, unit, spread: None, values: vec![] }
    }

    /// Sets the relative excess of the greatest of some repetitions over the least.
    #[must_use]
    pub fn spread(self, spread: f64) -> Self {
        Self { spread: Some(spread), ..self }
    }

    /// Adds a value for JSON.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.values.push((name, value.into()));
        self
    }

    /// Returns the values as a JSON object.
    pub fn to_json(&self) -> Value {
        Value::Object(
            self.values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect::<Map<_, _>>(),
        )
    }
}

/// Formats rows as a table.
pub fn text<'a>(rows: impl Iterator<Item = &'a BenchRow>) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    table.set_header(["measured", "figure", "unit", "spread"]);
    for BenchRow { what, figure, unit, spread, .. } in rows {
        let spread = spread.map_or_else(String::new, |spread| format!("{:.0} %", 100.0 * spread));
        table.add_row([what.clone(), format_four_digits(*figure), (*unit).to_owned(), spread]);
    }
    for column in [1, 3] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.to_string()
}

/// Formats a number with four digits.
fn format_four_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let before_the_point = value.abs().log10().floor() as i32 + 1;
    if (-2..=9).contains(&before_the_point) {
        let after = usize::try_from(4 - before_the_point).unwrap_or(0);
        format!("{value:.after$}")
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::{BenchRow, format_four_digits, text};

    #[test]
    fn numbers_have_four_digits() {
        for (value, expected) in
            [(0.0, "0"), (0.012_346, "0.01235"), (1.0, "1.000"), (123.45, "123.5"), (54321.0, "54321")]
        {
            assert_eq!(format_four_digits(value), expected, "{value}");
        }
        assert_eq!(format_four_digits(1.5e12), "1.500e12");
        assert_eq!(format_four_digits(2.5e-7), "2.500e-7");
    }

    #[test]
    fn a_table_shows_the_figure_and_json_has_the_values() {
        let row = BenchRow::new("a step", 0.5, "s").spread(0.25).with("wall_s", 0.5).with("cpu_s", 0.25);
        let shown = text(std::iter::once(&row));
        assert!(shown.contains("a step") && shown.contains("0.5000") && shown.contains("25 %"), "{shown}");
        assert!(!shown.contains("cpu"), "{shown}");
        assert_eq!(row.to_json(), serde_json::json!({ "wall_s": 0.5, "cpu_s": 0.25 }));
    }
}
