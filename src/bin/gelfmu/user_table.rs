//! Tables that a user has written: CSV files whose cells commas separate, or semicolons, as where decimals have a
//! comma.

use ballistic_gel::output::{MOST_TABLE_BYTES, read_limited_text};
use csv::{ReaderBuilder, StringRecord, Trim};
use std::cell::Cell;
use std::io;
use std::path::Path;

/// Rows of a table, and how its numbers are written.
pub struct UserTable {
    /// Names of the columns.
    pub header: TableRow,
    /// Rows below the header, with as many cells as it.
    pub rows: Vec<TableRow>,
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

/// Fault of a table.
#[derive(Debug, thiserror::Error)]
pub enum TableFault {
    /// The file cannot be read.
    #[error("found no readable file ({0}), expected a CSV file")]
    Unreadable(#[from] io::Error),
    /// A line is none of a table.
    #[error("line {line}: {what}")]
    Line { line: u64, what: String },
}

impl UserTable {
    /// Reads the table in a file.
    pub fn read(path: &Path) -> Result<Self, TableFault> {
        Self::parse(&read_limited_text(path, MOST_TABLE_BYTES)?)
    }

    /// Parses a table. Lines without a cell that has text, and lines that begin with #, are no rows.
    pub fn parse(text: &str) -> Result<Self, TableFault> {
        let text = text.trim_start_matches('\u{feff}');
        let first = text.lines().find(|line| !is_skipped(line)).unwrap_or_default();
        let delimiter = if first.contains(';') { b';' } else { b',' };
        let mut builder = ReaderBuilder::new();
        builder.trim(Trim::All).comment(Some(b'#')).delimiter(delimiter).has_headers(false).flexible(true);
        let mut reader = builder.from_reader(text.as_bytes());
        let is_empty = |cells: &StringRecord| cells.iter().all(str::is_empty);
        let mut rows = reader.records().filter(|cells| !cells.as_ref().is_ok_and(is_empty)).map(|cells| {
            let cells = cells.map_err(io::Error::from)?;
            Ok(TableRow { line: first_line(text, &cells), cells })
        });
        let nothing = || TableRow { line: 1, cells: StringRecord::new() };
        let header: TableRow = rows.next().transpose()?.unwrap_or_else(nothing);
        let rows = rows.map(|row: Result<TableRow, TableFault>| row?.with_cells(header.cells.len()));
        let rows = rows.collect::<Result<_, _>>()?;
        Ok(Self { header, rows, delimiter, mark: Cell::new(None) })
    }

    /// Parses a finite number. Where semicolons separate the cells its decimal mark is a point or a comma, in all of
    /// the table the same.
    ///
    /// # Errors
    /// The form of numbers in the table, to follow the words "expected a number".
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

impl TableRow {
    /// Refuses another number of cells than that of the header.
    fn with_cells(self, expected: usize) -> Result<Self, TableFault> {
        match self.cells.len() {
            found if found == expected => Ok(self),
            found => {
                let what = format!("found {found} cells, expected {expected}, as in the header");
                Err(TableFault::Line { line: self.line, what })
            }
        }
    }
}

/// Returns the line of a record, from 1: the position of the reader is before the comments and empty lines above it.
fn first_line(text: &str, record: &StringRecord) -> u64 {
    let Some(start) = record.position() else { return 1 };
    let above = text.get(start.byte() as usize..).unwrap_or_default().lines();
    start.line() + above.take_while(|line| is_skipped(line)).count() as u64
}

/// Returns true for a line that is no row.
fn is_skipped(line: &str) -> bool {
    line.trim().is_empty() || line.starts_with('#')
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
            let table = UserTable::parse(table).unwrap();
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
        let table = UserTable::parse("\u{feff}# range 3\n \na;b\n1;2\n# lens\n\"3\n\";4\n;\n5;6\n; \n").unwrap();
        let lines: Vec<u64> = table.rows.iter().map(|row| row.line).collect();
        assert_eq!((table.header.line, lines), (3, vec![4, 6, 9]));
        assert_eq!(table.header.cells, vec!["a", "b"]);
        let fault = UserTable::parse("a,b\n1\n").err().unwrap().to_string();
        assert_eq!(fault, "line 2: found 1 cells, expected 2, as in the header");
        assert!(UserTable::parse("").unwrap().header.cells.is_empty());
    }
}
