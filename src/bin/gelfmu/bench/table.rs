//! Benchmark results: rows of named values, as a table and as JSON.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use serde_json::{Map, Value};

/// Measured row: names with their units, and values.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BenchRow {
    shown: Vec<(&'static str, Value)>,
    kept: Vec<(&'static str, Value)>,
}

impl BenchRow {
    /// Adds a column.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.shown.push((name, value.into()));
        self
    }

    /// Adds a value for JSON only.
    #[must_use]
    pub fn and(mut self, name: &'static str, value: impl Into<Value>) -> Self {
        self.kept.push((name, value.into()));
        self
    }

    /// Returns the row as a JSON object.
    pub fn to_json(&self) -> Value {
        let all = self.shown.iter().chain(&self.kept);
        Value::Object(all.map(|(name, value)| ((*name).to_owned(), value.clone())).collect::<Map<_, _>>())
    }
}

/// Formats rows with the same columns as a table.
pub fn text(rows: &[BenchRow]) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_content_arrangement(ContentArrangement::Dynamic);
    let Some(first) = rows.first() else { return String::new() };
    table.set_header(first.shown.iter().map(|(name, _)| name.replace('_', " ")));
    for row in rows {
        table.add_row(row.shown.iter().map(|(_, value)| format_cell(value)));
    }
    for ((_, value), column) in first.shown.iter().zip(table.column_iter_mut()) {
        if !value.is_string() {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.to_string()
}

fn format_cell(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        Value::Bool(_) | Value::Array(_) | Value::Object(_) => value.to_string(),
        Value::Number(number) if number.is_u64() => number.to_string(),
        Value::Number(number) => format_four_digits(number.as_f64().unwrap_or(f64::NAN)),
    }
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
    fn a_table_shows_columns_and_json_has_all() {
        let row = BenchRow::default().with("mesh", "cube").with("wall_s", 0.5).and("cpu_s", 0.25);
        let shown = text(std::slice::from_ref(&row));
        assert!(shown.contains("wall s") && shown.contains("0.5000") && !shown.contains("cpu"), "{shown}");
        assert_eq!(row.to_json(), serde_json::json!({ "mesh": "cube", "wall_s": 0.5, "cpu_s": 0.25 }));
    }
}
