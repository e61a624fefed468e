//! Table of a run: a CSV file with values by the name of the column.

use super::{SavedRunError, read_text};
use crate::output::reading::MOST_RESULT_BYTES;
use std::collections::HashMap;
use std::path::Path;

/// Table with named columns.
#[derive(Debug)]
pub(super) struct CsvTable {
    columns: HashMap<String, usize>,
    rows: Vec<Vec<f64>>,
}

impl CsvTable {
    /// Reads a file; a cell that is no number gives NaN.
    pub(super) fn read(path: &Path) -> Result<Self, SavedRunError> {
        let text = read_text(path, MOST_RESULT_BYTES)?;
        let mut lines = text.lines();
        let names = lines.next().unwrap_or_default().split(',');
        let columns = names.enumerate().map(|(i, name)| (name.to_owned(), i)).collect();
        let cell = |cell: &str| cell.parse().unwrap_or(f64::NAN);
        Ok(Self { columns, rows: lines.map(|line| line.split(',').map(cell).collect()).collect() })
    }

    /// Returns the rows in the order of the file.
    pub(super) fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Returns the row whose first column is nearest to a value.
    pub(super) fn nearest_row(&self, value: f64) -> Option<&[f64]> {
        let distance = |row: &&Vec<f64>| (row.first().copied().unwrap_or(f64::INFINITY) - value).abs();
        self.rows.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(Vec::as_slice)
    }

    /// Returns the value of a row in a column; `None` without such a column.
    pub(super) fn value(&self, row: &[f64], name: &str) -> Option<f64> {
        self.columns.get(name).and_then(|column| row.get(*column)).copied()
    }
}
