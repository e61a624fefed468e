//! A laboratory's table: reading of the CSV file, and its errors by line and column.

use super::quantity::{MatchedColumn, MeasuredQuantity, match_column};
use crate::failure::CommandError;
use ballistic_gel::output::{CurveAbscissa, CurvePoint};
use csv::{ReaderBuilder, StringRecord, Trim};
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
    let text = std::fs::read_to_string(path).map_err(|error| {
        CommandError::BadInput(format!("--measured {file}: found no readable file ({error}), expected a CSV file"))
    })?;
    parse(&file, &text)
}

/// Parses the text of a file; a header with semicolons separates its cells by them.
pub fn parse(file: &str, text: &str) -> Result<MeasuredTable, CommandError> {
    let refuse = |line: u64, what: &str| CommandError::BadInput(format!("--measured {file}: line {line}: {what}"));
    let first = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let delimiter = if first.contains(';') { b';' } else { b',' };
    let mut builder = ReaderBuilder::new();
    builder.trim(Trim::All).comment(Some(b'#')).delimiter(delimiter);
    let mut reader = builder.from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let broken = |error: &csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        refuse(line, &format!("found no row of the table ({error}), expected as many cells as names of columns"))
    };
    let header = TableHeader::of(reader.headers().map_err(|error| broken(&error))?);
    let abscissa = header.abscissa().map_err(|what| refuse(1, &what))?;
    let mut points: Vec<Vec<CurvePoint>> = vec![vec![]; header.names.len()];
    for record in reader.records() {
        let record = record.map_err(|error| broken(&error))?;
        let line = record.position().map_or(1, csv::Position::line);
        let values = header.values(&record).map_err(|what| refuse(line, &what))?;
        let Some(at) = values[abscissa] else { continue };
        for (values, points) in values.iter().zip(&mut points) {
            points.extend(values.map(|value| CurvePoint { at, value }));
        }
    }
    header.table(file, abscissa, points).map_err(|what| refuse(1, &what))
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
    fn values(&self, record: &StringRecord) -> Result<Vec<Option<f64>>, String> {
        let value = |(i, cell): (usize, &str)| {
            let Some(column) = self.columns[i].as_ref().filter(|_| !cell.is_empty()) else { return Ok(None) };
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(Some(value * column.factor)),
                _ => Err(format!(
                    "column `{}`: found {cell:?}, expected a number with a decimal point, or an empty cell",
                    self.names[i]
                )),
            }
        };
        record.iter().enumerate().map(value).collect()
    }

    /// Returns the curves of the columns beside the abscissa.
    fn table(&self, file: &str, abscissa: usize, points: Vec<Vec<CurvePoint>>) -> Result<MeasuredTable, String> {
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

    fn refusal(text: &str) -> String {
        parse("lab.csv", text).unwrap_err().to_string()
    }

    #[test]
    fn a_table_gives_its_curves_in_si_units() {
        let table =
            parse("lab.csv", "# range 3\ndepth_mm,velocity_m_per_s,camera\n10,150,a\n20,,b\n30,90,c\n").unwrap();
        assert_eq!(
            (table.abscissa, table.unmatched.as_slice()),
            (CurveAbscissa::Depth, ["camera".to_owned()].as_slice())
        );
        let points: Vec<[f64; 2]> = table.curves[0].points.iter().map(|point| [point.at, point.value]).collect();
        assert_eq!(points, [[0.01, 150.0], [0.03, 90.0]]);
        assert!(table.notes[2].contains("camera: not matched"));
        let german = parse("lab.csv", "time_ms;depth_cm\n1;5\n").unwrap();
        assert_eq!((german.abscissa, german.curves[0].points[0].value), (CurveAbscissa::Time, 0.05));
    }

    #[test]
    fn a_bad_table_is_refused_with_line_and_remedy() {
        let comma = refusal("time_ms;velocity_m_per_s\n1;150\n2;1,5\n");
        assert!(comma.starts_with("--measured lab.csv: line 3: column `velocity_m_per_s`: found \"1,5\""), "{comma}");
        assert!(comma.contains("expected a number with a decimal point"), "{comma}");
        let short = refusal("time,velocity\n1\n");
        assert!(short.contains("line 2: found no row of the table"), "{short}");
        assert!(refusal("a,b\n1,2\n").contains("line 1: found the columns a, b, expected one named time or depth"));
        assert!(
            refusal("time,b\n1,2\n")
                .contains("expected beside time a column with values, named with its unit: one of depth (m, cm,")
        );
        assert!(refusal("").contains("expected one named time or depth"));
    }
}
