//! Runs of other codes from a CSV file, assessed with our reference values.

use super::curve::{QUANTITIES, ReferenceValue, TradeCurve};
use crate::failure::CommandError;
use ballistic_gel::fmi2;
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

/// Size limit of the table, bytes.
const MOST_BYTES: u64 = 1 << 24;
/// Columns for the name and the cost.
const NAME_COLUMN: &str = "run";
const COST_COLUMN: &str = "cpu_seconds";

/// Reads a table with the columns `run`, `cpu_seconds` and any of `trade.csv`, e.g. `peak_depth`; further columns are
/// ignored.
pub fn read_peers(path: &Path, curve: &TradeCurve) -> Result<Vec<PeerRun>, CommandError> {
    let refuse = |place: &str, found: &str, expected: &str| {
        CommandError::BadInput(format!("--with {}: {place}found {found}, expected {expected}", path.display()))
    };
    let text =
        fmi2::read_limited_text(path, MOST_BYTES).map_err(|error| refuse("", &error.to_string(), "a CSV file"))?;
    let mut lines = text.lines().enumerate();
    let header: Vec<&str> = lines.next().map_or(vec![], |(_, line)| line.split(',').map(str::trim).collect());
    let column = |name: &str| {
        let missing = || refuse("line 1: ", &format!("the columns {}", header.join(", ")), &format!("a column {name}"));
        header.iter().position(|known| *known == name).ok_or_else(missing)
    };
    let (name, cost) = (column(NAME_COLUMN)?, column(COST_COLUMN)?);
    let parse_line = |(number, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let place = format!("line {}: ", number + 1);
        if cells.len() != header.len() {
            return Err(refuse(&place, &format!("{} cells", cells.len()), &format!("{}, as in line 1", header.len())));
        }
        let value =
            |key: &str| header.iter().position(|known| *known == key).and_then(|i| cells[i].parse::<f64>().ok());
        let seconds = cells[cost].parse::<f64>().ok().filter(|seconds| *seconds > 0.0);
        let cpu_seconds = seconds.ok_or_else(|| refuse(&place, cells[cost], "CPU seconds, a positive number"))?;
        Ok(PeerRun { name: cells[name].to_owned(), cpu_seconds, error: greatest_error(value, curve) })
    };
    lines.filter(|(_, line)| !line.trim().is_empty()).map(parse_line).collect()
}

fn greatest_error(value: impl Fn(&str) -> Option<f64>, curve: &TradeCurve) -> Option<f64> {
    let error = |(quantity, reference): (&super::curve::ComparedQuantity, &ReferenceValue)| match reference {
        ReferenceValue::Limit(limit, _) => value(quantity.key).map(|value| (value - limit.value).abs() / limit.scale),
        ReferenceValue::Refused(_) | ReferenceValue::Missing => None,
    };
    QUANTITIES.iter().zip(&curve.references).filter_map(error).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::{PeerRun, read_peers};
    use crate::trade::curve::tests::curve;

    fn read_text(text: &str) -> Result<Vec<PeerRun>, String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read_peers(file.path(), &curve()).map_err(|error| error.to_string())
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
        assert!(read_text("run,cpu_seconds\n\na,soon\n").unwrap_err().contains("line 3: found soon"));
        assert!(read_text("run,cpu_seconds\na\n").unwrap_err().contains("line 2: found 1 cells, expected 2"));
    }
}
