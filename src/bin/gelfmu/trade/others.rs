//! Runs of other codes, from a CSV file, judged by the same references.

use super::curve::{Curve, QUANTITIES, Reference};
use crate::failure::Failure;
use ballistic_gel::fmi2;
use std::path::Path;

/// A run of another code.
#[derive(Debug, Clone, PartialEq)]
pub struct Other {
    /// Who made it.
    pub name: String,
    /// CPU time, s.
    pub cpu_seconds: f64,
    /// Greatest relative error of what it gives, if anything of it has a reference.
    pub error: Option<f64>,
}

/// Bytes of the longest table that is read.
const MOST_BYTES: u64 = 1 << 24;
/// Columns of the file that are no figures.
const NAME: &str = "run";
const COST: &str = "cpu_seconds";

/// Reads a table with the columns `run`, `cpu_seconds` and some of those of `trade.csv`, such as `peak_depth`; others are passed
/// over.
pub fn read(path: &Path, curve: &Curve) -> Result<Vec<Other>, Failure> {
    let refuse = |place: &str, found: &str, expected: &str| {
        Failure::BadInput(format!("--with {}: {place}found {found}, expected {expected}", path.display()))
    };
    let text =
        fmi2::read_limited_text(path, MOST_BYTES).map_err(|error| refuse("", &error.to_string(), "a CSV file"))?;
    let mut lines = text.lines().enumerate();
    let header: Vec<&str> = lines.next().map_or(vec![], |(_, line)| line.split(',').map(str::trim).collect());
    let column = |name: &str| {
        let missing = || refuse("line 1: ", &format!("the columns {}", header.join(", ")), &format!("a column {name}"));
        header.iter().position(|known| *known == name).ok_or_else(missing)
    };
    let (name, cost) = (column(NAME)?, column(COST)?);
    let one = |(number, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let place = format!("line {}: ", number + 1);
        if cells.len() != header.len() {
            return Err(refuse(&place, &format!("{} cells", cells.len()), &format!("{}, as in line 1", header.len())));
        }
        let value =
            |key: &str| header.iter().position(|known| *known == key).and_then(|i| cells[i].parse::<f64>().ok());
        let seconds = cells[cost].parse::<f64>().ok().filter(|seconds| *seconds > 0.0);
        let cpu_seconds = seconds.ok_or_else(|| refuse(&place, cells[cost], "CPU seconds, a positive number"))?;
        Ok(Other { name: cells[name].to_owned(), cpu_seconds, error: error(value, curve) })
    };
    lines.filter(|(_, line)| !line.trim().is_empty()).map(one).collect()
}

fn error(value: impl Fn(&str) -> Option<f64>, curve: &Curve) -> Option<f64> {
    let of = |(quantity, reference): (&super::curve::Quantity, &Reference)| match reference {
        Reference::Limit(limit, _) => value(quantity.key).map(|value| (value - limit.value).abs() / limit.scale),
        Reference::Refused(_) | Reference::Missing => None,
    };
    QUANTITIES.iter().zip(&curve.references).filter_map(of).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::{Other, read};
    use crate::trade::curve::tests::curve;

    fn said(text: &str) -> Result<Vec<Other>, String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read(file.path(), &curve()).map_err(|error| error.to_string())
    }

    #[test]
    fn another_code_is_judged_by_the_same_reference() {
        let others = said("run,peak_depth,mesh,cpu_seconds\na,0.0098,fine,2.5\nb,,coarse,1\n").unwrap();
        assert_eq!((others[0].name.as_str(), others[0].cpu_seconds), ("a", 2.5));
        assert!((others[0].error.unwrap() - 0.02).abs() < 1e-9);
        assert_eq!(others[1], Other { name: "b".to_owned(), cpu_seconds: 1.0, error: None });
    }

    #[test]
    fn what_is_no_such_table_is_refused_with_its_line() {
        assert!(
            said("run,depth\na,1\n")
                .unwrap_err()
                .contains("line 1: found the columns run, depth, expected a column cpu_seconds")
        );
        assert!(said("run,cpu_seconds\n\na,soon\n").unwrap_err().contains("line 3: found soon"));
        assert!(said("run,cpu_seconds\na\n").unwrap_err().contains("line 2: found 1 cells, expected 2"));
    }
}
