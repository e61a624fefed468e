//! Time of a step by phase, ns per element update on one thread: differences of separately measured parts.

use super::Measurement;
use super::settings::{BenchMesh, BenchSettings};
use super::spent::{MeasuredTime, RepeatPolicy};
use super::stand::{self, Kernel, Stand, levels};
use super::steps::{self, MeasuredBlock};
use super::table::BenchRow;
use crate::failure::CommandError;
use crate::options::SectionName;
use ballistic_gel::fem::{LANES, Section};
use serde_json::Value;

/// Times of the element phase, ns per update.
struct ElementPhaseTimes {
    /// Copies of nodal data to the kernel's cache.
    load: f64,
    /// Gather, arithmetic and nodal sums, in cache.
    cached: f64,
    /// Time in cache without waiting for the nodal sums of a neighbour; plain elements only.
    unshared: Option<f64>,
    /// Whole element phase, from memory.
    all: f64,
}

/// Plans one measurement for each mesh.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let policy = settings.policy;
    let measurement = |mesh: BenchMesh| {
        let block = MeasuredBlock::new(mesh, settings);
        Measurement {
            section: SectionName::Phases,
            what: mesh.describe(),
            cost: if settings.quick { 0.5 } else { 5.0 + mesh.n_elements as f64 * 2e-5 },
            go: Box::new(move || Ok(vec![measure(&block, policy)?])),
        }
    };
    settings.meshes().into_iter().map(measurement).collect()
}

fn measure(block: &MeasuredBlock, policy: RepeatPolicy) -> Result<BenchRow, CommandError> {
    let patched = block.kind.is_patch();
    let mut stand =
        Stand::new(&stand::block(block.n_elements), Kernel { section: Section::Spatial, patched, flows: false });
    let elements = measure_elements(&mut stand, patched, policy);
    let n_elements = stand.n_elements();
    drop(stand);
    let whole = measure_whole_step(block, policy)?;
    let without_ball = measure_whole_step(&block.without_ball(), policy)?;
    let waiting = elements.unshared.map_or(Value::Null, |unshared| (elements.cached - unshared).into());
    Ok(BenchRow::default()
        .with("elements", n_elements)
        .with("element", block.kind.as_str())
        .with("whole_step_ns", whole)
        .with("load_nodes_ns", elements.load)
        .with("gather_compute_sum_in_cache_ns", elements.cached)
        .with("of_that_waiting_for_sums_ns", waiting)
        .with("memory_and_keeping_sums_ns", elements.all - elements.load - elements.cached)
        .with("contact_ns", whole - without_ball)
        .with("nodes_clocks_books_ns", without_ball - elements.all)
        .and("element_phase_ns", elements.all))
}

/// Measures the whole step on one thread, ns per update.
fn measure_whole_step(block: &MeasuredBlock, policy: RepeatPolicy) -> Result<f64, CommandError> {
    let timings = steps::measure(block, &[1], policy)?;
    Ok(timings.iter().map(|timing| timing.spent.cpu / timing.updates * 1e9).sum())
}

/// Measures the parts of the element phase.
fn measure_elements(stand: &mut Stand<3>, patched: bool, policy: RepeatPolicy) -> ElementPhaseTimes {
    let (_, level) = levels()[0];
    let (run, n_in_cache) = stand.some_run();
    let ns = |spent: MeasuredTime, n: usize| spent.cpu / n as f64 * 1e9;
    stand.load(run);
    let cached = ns(MeasuredTime::per_turn(policy, || stand.sweep(level, run)), n_in_cache);
    let unshared = (!patched).then(|| {
        let (lanes, n) = (stand.apart(), n_in_cache / LANES * LANES);
        ns(MeasuredTime::per_turn(policy, || stand.sweep_alone(level, &lanes, n)), n)
    });
    let load = ns(MeasuredTime::per_turn(policy, || stand.load_all()), stand.n_elements());
    let all = ns(MeasuredTime::per_turn(policy, || stand.sweep_all(level)), stand.n_elements());
    ElementPhaseTimes { load, cached, unshared, all }
}
