//! Runs of other codes from a CSV file, assessed with our reference values.

use super::curve::{QUANTITIES, ReferenceValue, TradeCurve};
use crate::failure::CommandError;
use crate::user_table::{TableRow, UserTable};
use std::path::Path;

/// Run of another code.
#[derive(Debug, Clone, PartialEq)]
pub struct PeerRun {
    /// Name of the code or run.
    pub name: String,
    /// CPU time, s.
    pub cpu_seconds: f64,
    /// Greatest relative error; `None` if no value has a reference.
    pub error: Option<f64>,
}

/// Run of another code as its table has it.
#[derive(Debug, Clone, PartialEq)]
pub struct PeerRow {
    name: String,
    cpu_seconds: f64,
    /// Values of the [`QUANTITIES`], as far as the table has them.
    values: Vec<Option<f64>>,
}

/// Columns for the name and the cost.
const NAME_COLUMN: &str = "run";
const COST_COLUMN: &str = "cpu_seconds";

/// Reads a table with the columns `run`, `cpu_seconds` and any of `trade.csv`, e.g. `peak_depth`; further columns are
/// ignored.
pub fn read_peers(path: &Path) -> Result<Vec<PeerRow>, CommandError> {
    let refuse = |what: String| CommandError::BadInput(format!("--with {}: {what}", path.display()));
    let table = UserTable::read(path).map_err(|fault| refuse(fault.to_string()))?;
    let TableRow { line, cells: header } = &table.header;
    let position = |name: &str| header.iter().position(|known| known == name);
    let column = |name: &str| {
        let found: Vec<&str> = header.iter().collect();
        let missing =
            || refuse(format!("line {line}: found the columns {}, expected a column {name}", found.join(", ")));
        position(name).ok_or_else(missing)
    };
    let (name, cost) = (column(NAME_COLUMN)?, column(COST_COLUMN)?);
    let values = QUANTITIES.map(|quantity| position(quantity.key));
    let row = |TableRow { line, cells }: &TableRow| {
        let number = |i: usize, expected: &str| {
            let at = |form| format!("line {line}: {}: found {:?}, expected {expected}, {form}", &header[i], &cells[i]);
            table.number(&cells[i]).map_err(|form| refuse(at(form)))
        };
        let value = |column: &Option<usize>| {
            let column = column.filter(|i| !cells[*i].is_empty());
            column.map(|i| number(i, "a number or an empty cell")).transpose()
        };
        let cpu_seconds = number(cost, "CPU seconds")?;
        if cpu_seconds <= 0.0 {
            let found = &cells[cost];
            return Err(refuse(format!("line {line}: {COST_COLUMN}: found {found}, expected CPU seconds above 0")));
        }
        let values = values.iter().map(value).collect::<Result<_, _>>()?;
        Ok(PeerRow { name: cells[name].to_owned(), cpu_seconds, values })
    };
    table.rows.iter().map(row).collect()
}

impl PeerRow {
    /// Assesses the run with the reference values of a curve.
    pub fn assess(&self, curve: &TradeCurve) -> PeerRun {
        let error = |(value, reference): (&Option<f64>, &ReferenceValue)| match reference {
            ReferenceValue::Limit(limit, _) => value.map(|value| (value - limit.value).abs() / limit.scale),
            ReferenceValue::Refused(_) | ReferenceValue::Missing => None,
        };
        let error = self.values.iter().zip(&curve.references).filter_map(error).reduce(f64::max);
        PeerRun { name: self.name.clone(), cpu_seconds: self.cpu_seconds, error }
    }
}

#[cfg(test)]
mod tests {
    use super::{PeerRun, read_peers};
    use crate::trade::curve::tests::curve;

    fn read_text(text: &str) -> Result<Vec<PeerRun>, String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        let rows = read_peers(file.path()).map_err(|error| error.to_string())?;
        Ok(rows.into_iter().map(|row| row.assess(&curve())).collect())
    }

    #[test]
    fn another_code_is_assessed_with_our_reference() {
        let others = read_text("run,peak_depth,mesh,cpu_seconds\na,0.0098,fine,2.5\nb,,coarse,1\n").unwrap();
        assert_eq!((others[0].name.as_str(), others[0].cpu_seconds), ("a", 2.5));
        assert!((others[0].error.unwrap() - 0.02).abs() < 1e-9);
        assert_eq!(others[1], PeerRun { name: "b".to_owned(), cpu_seconds: 1.0, error: None });
    }

    #[test]
    fn an_invalid_table_is_refused_with_its_line() {
        assert!(
            read_text("run,depth\na,1\n")
                .unwrap_err()
                .contains("line 1: found the columns run, depth, expected a column cpu_seconds")
        );
        assert!(read_text("run,cpu_seconds\n\na,soon\n").unwrap_err().contains("line 3: cpu_seconds: found \"soon\""));
        assert!(
            read_text("run,cpu_seconds\na,0\n")
                .unwrap_err()
                .contains("line 2: cpu_seconds: found 0, expected CPU seconds above 0")
        );
        let deep = read_text("run;cpu_seconds;peak_depth\na;2,5;deep\n").unwrap_err();
        assert!(deep.contains("line 2: peak_depth: found \"deep\", expected a number or an empty cell"), "{deep}");
        assert!(read_text("run,cpu_seconds\na\n").unwrap_err().contains("line 2: found 1 cells, expected 2"));
    }
}
