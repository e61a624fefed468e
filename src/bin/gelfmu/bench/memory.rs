//! Bytes per element: as the engine counts them, and as the process grows.

use super::Measurement;
use super::scenes::{advance, awake, elements, name_of, scene, simulation, size};
use super::settings::Settings;
use super::spent::Spent;
use super::table::Row;
use crate::failure::Failure;
use crate::options::SectionName;
use serde_json::Value;

/// So far a gel is stepped that all of its memory was touched, s.
const TOUCHED: f64 = 1e-9;

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let subjects = settings.elements.iter().flat_map(|n| [(*n, false), (*n, true)]);
    let of = |(n, patched): (usize, bool)| Measurement {
        section: SectionName::Memory,
        what: format!("{n} elements, {}", name_of(patched)),
        cost: n as f64 * 5e-6,
        go: Box::new(move || Ok(vec![row(n, patched)?])),
    };
    subjects.map(of).collect()
}

fn row(n: usize, patched: bool) -> Result<Row, Failure> {
    let scene = scene("sphere-block", &[awake(), size(n), elements(patched)])?;
    let (before, mut built) = (resident(), None);
    let spent = Spent::on(|| built = Some(simulation(&scene, 1)));
    let mut simulation = built.expect("it was built just now")?;
    advance(&mut simulation, TOUCHED)?;
    let grown = resident().zip(before).map(|(after, before)| after.saturating_sub(before));
    let n_elements = simulation.observe().cost.elements;
    let per_element = |bytes: u64| bytes as f64 / n_elements as f64;
    Ok(Row::default()
        .with("elements", n_elements)
        .with("element", name_of(patched))
        .with("engine_bytes_per_element", per_element(simulation.bytes() as u64))
        .with("process_bytes_per_element", grown.map_or(Value::Null, |bytes| per_element(bytes).into()))
        .with("build_cpu_s", spent.cpu)
        .and("engine_bytes", simulation.bytes())
        .and("process_bytes", grown)
        .and("build_wall_s", spent.wall))
}

/// Resident set of the process, bytes, where the system tells.
fn resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}
