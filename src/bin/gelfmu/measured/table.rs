//! A laboratory's table: reading of the CSV file, and its errors by line and column.

use super::quantity::{MatchedColumn, MeasuredQuantity, match_column};
use crate::failure::CommandError;
use crate::user_table::{TableFault, TableRow, UserTable};
use ballistic_gel::output::{CurveAbscissa, CurvePoint};
use csv::StringRecord;
use std::path::Path;

/// Measured values of one column against time or depth.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCurve {
    pub column: String,
    pub quantity: MeasuredQuantity,
    pub points: Vec<CurvePoint>,
}

/// Curves of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredTable {
    pub file: String,
    pub abscissa: CurveAbscissa,
    pub curves: Vec<MeasuredCurve>,
    /// Names of the columns that were not understood.
    pub unmatched: Vec<String>,
    /// Sentences on the meaning of each column.
    pub notes: Vec<String>,
}

/// Header of a file: names of the columns and their meaning.
struct TableHeader {
    names: Vec<String>,
    columns: Vec<Option<MatchedColumn>>,
}

/// Reads the file of `--measured`.
pub fn read(path: &Path) -> Result<MeasuredTable, CommandError> {
    let file = path.display().to_string();
    let refuse = |fault: TableFault| CommandError::BadInput(format!("--measured {file}: {fault}"));
    parse(&file, &UserTable::read(path).map_err(refuse)?)
}

/// Parses a table.
fn parse(file: &str, table: &UserTable) -> Result<MeasuredTable, CommandError> {
    let refuse = |line: u64, what: &str| CommandError::BadInput(format!("--measured {file}: line {line}: {what}"));
    let header = TableHeader::of(&table.header.cells);
    let abscissa = header.abscissa().map_err(|what| refuse(table.header.line, &what))?;
    let mut points: Vec<Vec<CurvePoint>> = vec![vec![]; header.names.len()];
    for TableRow { line, cells } in &table.rows {
        let values = header.values(table, cells).map_err(|what| refuse(*line, &what))?;
        let Some(at) = values[abscissa] else { continue };
        for (values, points) in values.iter().zip(&mut points) {
            points.extend(values.map(|value| CurvePoint { at, value }));
        }
    }
    header.curves(file, abscissa, points).map_err(|what| refuse(table.header.line, &what))
}

impl TableHeader {
    fn of(record: &StringRecord) -> Self {
        let names: Vec<String> = record.iter().map(str::to_owned).collect();
        let columns = names.iter().map(|name| match_column(name)).collect();
        Self { names, columns }
    }

    fn position(&self, quantity: MeasuredQuantity) -> Option<usize> {
        self.columns.iter().position(|column| column.as_ref().is_some_and(|column| column.quantity == quantity))
    }

    /// Returns the number of the column of the abscissa: time if there is one, else depth.
    fn abscissa(&self) -> Result<usize, String> {
        let found = self.position(MeasuredQuantity::Time).or_else(|| self.position(MeasuredQuantity::Depth));
        found.ok_or_else(|| {
            format!(
                "found the columns {}, expected one named time or depth with its unit, such as time_ms or depth_mm",
                self.names.join(", ")
            )
        })
    }

    /// Returns the values of a record, SI units; an empty cell has none.
    fn values(&self, table: &UserTable, record: &StringRecord) -> Result<Vec<Option<f64>>, String> {
        let value = |(i, cell): (usize, &str)| {
            let Some(column) = self.columns[i].as_ref().filter(|_| !cell.is_empty()) else { return Ok(None) };
            let refuse = |expected: &str| {
                format!("column `{}`: found {cell:?}, expected {expected}, or an empty cell", self.names[i])
            };
            let number = table.number(cell).map_err(|form| refuse(&format!("a number {form}")))?;
            let value = Some(number * column.factor).filter(|value| value.is_finite());
            let finite = || refuse(&format!("a number that is finite in {}", column.quantity.si_unit()));
            value.ok_or_else(finite).map(Some)
        };
        record.iter().enumerate().map(value).collect()
    }

    /// Returns the curves of the columns beside the abscissa.
    fn curves(&self, file: &str, abscissa: usize, points: Vec<Vec<CurvePoint>>) -> Result<MeasuredTable, String> {
        let by =
            if self.position(MeasuredQuantity::Time).is_some() { CurveAbscissa::Time } else { CurveAbscissa::Depth };
        let mut table =
            MeasuredTable { file: file.to_owned(), abscissa: by, curves: vec![], unmatched: vec![], notes: vec![] };
        for (i, (name, points)) in self.names.iter().zip(points).enumerate() {
            let Some(column) = &self.columns[i] else {
                table.unmatched.push(name.clone());
                table.notes.push(format!("column {name}: not matched, and not used"));
                continue;
            };
            let unit = column
                .unit
                .map_or_else(|| format!("{}, the name has no unit", column.quantity.si_unit()), str::to_owned);
            let meaning = column.quantity.key().replace('_', " ");
            table.notes.push(format!("column {name}: {meaning} ({unit}), {} values", points.len()));
            if i != abscissa && !points.is_empty() {
                table.curves.push(MeasuredCurve { column: name.clone(), quantity: column.quantity, points });
            }
        }
        if table.curves.is_empty() {
            let known = MeasuredQuantity::ALL[1..].iter();
            let known: Vec<String> = known.map(|known| format!("{} ({})", known.key(), known.unit_symbols())).collect();
            return Err(format!(
                "found the columns {}, expected beside {} a column with values, named with its unit: one of {}",
                self.names.join(", "),
                self.names[abscissa],
                known.join(", ")
            ));
        }
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<MeasuredTable, CommandError> {
        let fault = |fault: TableFault| CommandError::BadInput(format!("{fault}"));
        parse("lab.csv", &UserTable::parse(text).map_err(fault)?)
    }

    fn refusal(text: &str) -> String {
        parse_text(text).unwrap_err().to_string()
    }

    #[test]
    fn a_table_gives_its_curves_in_si_units() {
        let table = parse_text("# range 3\ndepth_mm,velocity_m_per_s,camera\n10,150,a\n20,,b\n30,90,c\n").unwrap();
        assert_eq!(
            (table.abscissa, table.unmatched.as_slice()),
            (CurveAbscissa::Depth, ["camera".to_owned()].as_slice())
        );
        let points: Vec<[f64; 2]> = table.curves[0].points.iter().map(|point| [point.at, point.value]).collect();
        assert_eq!(points, [[0.01, 150.0], [0.03, 90.0]]);
        assert!(table.notes[2].contains("camera: not matched"));
        let german = parse_text("time_ms;depth_cm\n1,5;5\n").unwrap();
        assert_eq!(german.curves[0].points, [CurvePoint { at: 1.5e-3, value: 0.05 }]);
    }

    #[test]
    fn a_bad_table_is_refused_with_line_and_remedy() {
        let mixed = refusal("time_ms;velocity_m_per_s\n1.5;150\n2;1,5\n");
        assert!(mixed.starts_with("--measured lab.csv: line 3: column `velocity_m_per_s`: found \"1,5\""), "{mixed}");
        assert!(mixed.contains("expected a number with a decimal point, as others of the table"), "{mixed}");
        let short = refusal("time,velocity\n1\n");
        assert!(short.contains("line 2: found 1 cells, expected 2, as in the header"), "{short}");
        assert!(refusal("a,b\n1,2\n").contains("line 1: found the columns a, b, expected one named time or depth"));
        assert!(
            refusal("time,b\n1,2\n")
                .contains("expected beside time a column with values, named with its unit: one of depth (m, cm,")
        );
        assert!(refusal("").contains("expected one named time or depth"));
    }

    #[test]
    fn a_value_is_checked_after_its_unit() {
        let refused = refusal("time_ms,force_kN\n1,2\n2,1e308\n");
        assert!(
            refused.contains("line 3: column `force_kN`: found \"1e308\", expected a number that is finite in N"),
            "{refused}"
        );
    }
}
