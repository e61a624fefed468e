//! Memory per element: bytes counted by the engine, and growth of the resident set.
//!
//! Memory freed by an earlier gel would hide the growth, so each of several gels is built in a separate process.

use super::Measurement;
use super::options::SectionName;
use super::scenes::{cell_size, drifting_gel, element_kind, load_scene, new_simulation, step_to};
use super::settings::{BenchMesh, BenchSettings};
use super::spent::MeasuredTime;
use super::table::BenchRow;
use crate::failure::{CommandError, RunError};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// Simulated time in which a gel touches all of its memory, s.
const TOUCHING_TIME: f64 = 1e-9;
/// Values of a row.
const KEYS: [&str; 8] = [
    "elements",
    "element",
    "engine_bytes_per_element",
    "process_bytes_per_element",
    "build_cpu_s",
    "engine_bytes",
    "process_bytes",
    "build_wall_s",
];

/// Plans one measurement for each mesh.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let meshes = settings.meshes();
    let is_alone = meshes.len() == 1 && settings.is_named(SectionName::Memory);
    let measurement = |mesh: BenchMesh| Measurement {
        section: SectionName::Memory,
        what: mesh.describe(),
        cost: mesh.n_elements as f64 * 5e-6,
        go: Box::new(move || Ok(vec![if is_alone { measure_here(mesh)? } else { measure_in_process(mesh)? }])),
    };
    meshes.into_iter().map(measurement).collect()
}

/// Measures a gel in this process.
fn measure_here(mesh: BenchMesh) -> Result<BenchRow, CommandError> {
    let scene = load_scene("sphere-block", &[drifting_gel(), cell_size(mesh.n_elements), element_kind(mesh.kind)])?;
    let (before, mut built) = (resident_bytes(), None);
    let spent = MeasuredTime::measure(|| built = Some(new_simulation(&scene, 1)));
    let mut simulation = built.expect("it was built just now")?;
    step_to(&mut simulation, TOUCHING_TIME)?;
    let grown = resident_bytes().zip(before).map(|(after, before)| after.saturating_sub(before));
    let n_elements = simulation.observe().cost.elements;
    let per_element = |bytes: u64| bytes as f64 / n_elements as f64;
    Ok(row([
        n_elements.into(),
        mesh.kind.as_str().into(),
        per_element(simulation.bytes() as u64).into(),
        grown.map(per_element).into(),
        spent.cpu.least.into(),
        simulation.bytes().into(),
        grown.into(),
        spent.wall.least.into(),
    ]))
}

/// Measures a gel in a separate process.
fn measure_in_process(mesh: BenchMesh) -> Result<BenchRow, CommandError> {
    let program = std::env::current_exe().map_err(|error| start_failure(PathBuf::from("gelfmu"), error))?;
    let size = mesh.n_elements.to_string();
    let arguments =
        ["bench", "--quiet", "--json", "--only", "memory", "--elements", &size, "--element", mesh.kind.as_str()];
    let output =
        Command::new(&program).args(arguments).output().map_err(|error| start_failure(program.clone(), error))?;
    let value: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    let figure = |key: &str| value["memory"]["rows"][0][key].clone();
    if !output.status.success() || figure(KEYS[0]).is_null() {
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(start_failure(program, std::io::Error::other(message)));
    }
    Ok(row(KEYS.map(figure)))
}

fn row(values: [Value; 8]) -> BenchRow {
    let what = format!("memory of {} elements, {}", values[0], values[1].as_str().unwrap_or_default());
    let row = BenchRow::new(what, values[2].as_f64().unwrap_or(f64::NAN), "bytes per element");
    KEYS.into_iter().zip(values).fold(row, |row, (name, value)| row.with(name, value))
}

fn start_failure(path: PathBuf, source: std::io::Error) -> CommandError {
    CommandError::Run(RunError::File { verb: "measure memory with", path, source })
}

/// Returns the resident set of the process, bytes, where the system reports it.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}
