//! Bytes per element: as the engine counts them, and as a process grows.
//!
//! What an earlier gel has freed would hide the growth: of several gels each is built in a process of its own.

use super::Measurement;
use super::scenes::{advance, awake, elements, scene, simulation, size};
use super::settings::Settings;
use super::spent::Spent;
use super::table::Row;
use crate::failure::Failure;
use crate::job::RunError;
use crate::options::{ElementName, SectionName};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// So far a gel is stepped that all of its memory was touched, s.
const TOUCHED: f64 = 1e-9;
/// What a row shows, and what only JSON has.
const SHOWN: [&str; 5] =
    ["elements", "element", "engine_bytes_per_element", "process_bytes_per_element", "build_cpu_s"];
const KEPT: [&str; 3] = ["engine_bytes", "process_bytes", "build_wall_s"];

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let subjects = settings.subjects();
    let alone = subjects.len() == 1 && settings.is_chosen(SectionName::Memory);
    let of = |(n, kind): (usize, ElementName)| Measurement {
        section: SectionName::Memory,
        what: format!("{n} elements, {}", kind.as_str()),
        cost: n as f64 * 5e-6,
        go: Box::new(move || Ok(vec![if alone { here(n, kind)? } else { in_a_process(n, kind)? }])),
    };
    subjects.into_iter().map(of).collect()
}

fn here(n: usize, kind: ElementName) -> Result<Row, Failure> {
    let scene = scene("sphere-block", &[awake(), size(n), elements(kind)])?;
    let (before, mut built) = (resident(), None);
    let spent = Spent::on(|| built = Some(simulation(&scene, 1)));
    let mut simulation = built.expect("it was built just now")?;
    advance(&mut simulation, TOUCHED)?;
    let grown = resident().zip(before).map(|(after, before)| after.saturating_sub(before));
    let n_elements = simulation.observe().cost.elements;
    let per_element = |bytes: u64| bytes as f64 / n_elements as f64;
    let shown: [Value; 5] = [
        n_elements.into(),
        kind.as_str().into(),
        per_element(simulation.bytes() as u64).into(),
        grown.map(per_element).into(),
        spent.cpu.into(),
    ];
    Ok(row(shown, [simulation.bytes().into(), grown.into(), spent.wall.into()]))
}

/// The same measured by a process that does nothing else.
fn in_a_process(n: usize, kind: ElementName) -> Result<Row, Failure> {
    let program = std::env::current_exe().map_err(|error| started(PathBuf::from("gelfmu"), error))?;
    let size = n.to_string();
    let arguments = ["bench", "--quiet", "--json", "--only", "memory", "--elements", &size, "--element", kind.as_str()];
    let output = Command::new(&program).args(arguments).output().map_err(|error| started(program.clone(), error))?;
    let value: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let of = |key: &str| value["memory"]["rows"][0][key].clone();
    if !output.status.success() || of(SHOWN[0]).is_null() {
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(started(program, std::io::Error::other(said)));
    }
    Ok(row(SHOWN.map(of), KEPT.map(of)))
}

fn row(shown: [Value; 5], kept: [Value; 3]) -> Row {
    let row = SHOWN.into_iter().zip(shown).fold(Row::default(), |row, (name, value)| row.with(name, value));
    KEPT.into_iter().zip(kept).fold(row, |row, (name, value)| row.and(name, value))
}

fn started(path: PathBuf, source: std::io::Error) -> Failure {
    Failure::Run(RunError::File { verb: "measure memory with", path, source })
}

/// Resident set of the process, bytes, where the system tells.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}
