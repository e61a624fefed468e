//! Tables that a user has written: CSV files whose cells commas separate, or semicolons, as where decimals have a comma.

use ballistic_gel::output::{MOST_TABLE_BYTES, read_limited_text};
use csv::{ReaderBuilder, StringRecord, Trim};
use std::cell::Cell;
use std::io;
use std::path::Path;

/// Text of a table, and how its cells and numbers are written.
pub struct UserTable {
    text: String,
    /// Separator of the cells: the comma, or the semicolon if the header has one.
    delimiter: u8,
    /// Decimal mark of the numbers read so far, if any had one.
    mark: Cell<Option<char>>,
}

/// Row of a table with its line, from 1.
pub struct TableRow {
    pub line: u64,
    pub cells: StringRecord,
}

/// Fault of a table at a line.
#[derive(Debug)]
pub struct TableFault {
    pub line: u64,
    pub what: String,
}

impl UserTable {
    /// Reads the table in a file.
    pub fn read(path: &Path) -> io::Result<Self> {
        read_limited_text(path, MOST_TABLE_BYTES).map(|text| Self::of(&text))
    }

    /// Returns the table of a text.
    pub fn of(text: &str) -> Self {
        let text = text.trim_start_matches('\u{feff}').to_owned();
        let header = text.lines().find(|line| !is_skipped(line)).unwrap_or_default();
        let delimiter = if header.contains(';') { b';' } else { b',' };
        Self { text, delimiter, mark: Cell::new(None) }
    }

    /// Returns the rows, the header first: all have as many cells as it. Empty lines and those that begin with # are none.
    pub fn rows(&self) -> Result<Vec<TableRow>, TableFault> {
        let mut builder = ReaderBuilder::new();
        builder.trim(Trim::All).comment(Some(b'#')).delimiter(self.delimiter).has_headers(false).flexible(true);
        let mut rows: Vec<TableRow> = vec![];
        for cells in builder.from_reader(self.text.as_bytes()).records() {
            let cells = cells.map_err(|error| TableFault { line: 1, what: format!("found no CSV table: {error}") })?;
            let line = self.first_line(&cells);
            if let Some(header) = rows.first().filter(|header| header.cells.len() != cells.len()) {
                let what = format!("found {} cells, expected {}, as in the header", cells.len(), header.cells.len());
                return Err(TableFault { line, what });
            }
            rows.push(TableRow { line, cells });
        }
        Ok(rows)
    }

    /// Returns the line of a record, from 1: the position of the reader is before the comments and empty lines above it.
    fn first_line(&self, record: &StringRecord) -> u64 {
        let Some(start) = record.position() else { return 1 };
        let above = self.text.get(start.byte() as usize..).unwrap_or_default().lines();
        start.line() + above.take_while(|line| is_skipped(line)).count() as u64
    }

    /// Parses a finite number. Where semicolons separate the cells its decimal mark is a point or a comma, in all of the
    /// table the same.
    ///
    /// # Errors
    /// How a number is written in the table, to follow the words "expected a number".
    pub fn number(&self, cell: &str) -> Result<f64, &'static str> {
        if self.delimiter == b',' {
            return parse_finite(cell).ok_or("with a decimal point");
        }
        match (cell.matches('.').count(), cell.matches(',').count()) {
            (0, 0) => parse_finite(cell).ok_or("with a decimal point or comma"),
            (1, 0) => self.expect_mark('.').and_then(|()| parse_finite(cell).ok_or("with a decimal point")),
            (0, 1) => {
                let with_point = cell.replace(',', ".");
                self.expect_mark(',').and_then(|()| parse_finite(&with_point).ok_or("with a decimal comma"))
            }
            _ => Err("without marks between its thousands"),
        }
    }

    /// Refuses a decimal mark other than that of the numbers before: one of the two could part thousands.
    fn expect_mark(&self, mark: char) -> Result<(), &'static str> {
        match self.mark.replace(Some(mark)) {
            Some('.') if mark == ',' => Err("with a decimal point, as others of the table"),
            Some(',') if mark == '.' => Err("with a decimal comma, as others of the table"),
            _ => Ok(()),
        }
    }
}

/// Returns true for a line that is no row.
fn is_skipped(line: &str) -> bool {
    line.is_empty() || line.starts_with('#')
}

fn parse_finite(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::UserTable;

    #[test]
    fn a_table_with_semicolons_has_decimal_commas_or_points_but_not_both() {
        let numbers = |table: &str, cells: &[&str]| {
            let table = UserTable::of(table);
            cells.iter().map(|cell| table.number(cell)).collect::<Result<Vec<f64>, _>>()
        };
        assert_eq!(numbers("a;b\n", &["1,5", "2", "-3,25e-3"]), Ok(vec![1.5, 2.0, -3.25e-3]));
        assert_eq!(numbers("a;b\n", &["1.5", "2"]), Ok(vec![1.5, 2.0]));
        let mixed = numbers("a;b\n", &["1,5", "1.500"]);
        assert_eq!(mixed, Err("with a decimal comma, as others of the table"));
        let mixed = numbers("a;b\n", &["1.5", "1,500"]);
        assert_eq!(mixed, Err("with a decimal point, as others of the table"));
        for thousands in ["1.234,5", "1,234,567", "1.234.567"] {
            assert_eq!(numbers("a;b\n", &[thousands]), Err("without marks between its thousands"), "{thousands}");
        }
        assert_eq!(numbers("a,b\n", &["1,5"]), Err("with a decimal point"));
        for unbounded in ["1e400", "inf", "NaN", "", "fast"] {
            assert_eq!(numbers("a;b\n", &[unbounded]), Err("with a decimal point or comma"), "{unbounded}");
        }
    }

    #[test]
    fn rows_have_their_lines_and_as_many_cells_as_the_header() {
        let rows = UserTable::of("\u{feff}# range 3\n\na;b\n1;2\n# lens\n\"3\n\";4\n5;6\n").rows().unwrap();
        let lines: Vec<u64> = rows.iter().map(|row| row.line).collect();
        assert_eq!(lines, [3, 4, 6, 8]);
        assert_eq!(rows[0].cells, vec!["a", "b"]);
        let fault = UserTable::of("a,b\n1\n").rows().err().unwrap();
        assert_eq!((fault.line, fault.what.as_str()), (2, "found 1 cells, expected 2, as in the header"));
    }
}
