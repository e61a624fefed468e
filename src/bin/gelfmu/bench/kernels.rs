//! Element updates per second of each kernel on each instruction set, in cache and from memory.

use super::Measurement;
use super::settings::BenchSettings;
use super::spent::{MeasuredTime, RepeatPolicy};
use super::stand::{KERNELS, Kernel, Stand, block, levels, section};
use super::table::BenchRow;
use crate::options::SectionName;
use ballistic_gel::fem::Section;
use fearless_simd::Level;
use std::hint::black_box;

/// Plans one measurement for each kernel.
pub fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let (n, policy) = (settings.largest(), settings.policy);
    let measurement = |(name, kernel): (&'static str, Kernel)| Measurement {
        section: SectionName::Kernels,
        what: format!("{name}, {}", if kernel.patched { "patches" } else { "plain" }),
        cost: if settings.quick { 0.5 } else { 16.0 },
        go: Box::new(move || Ok(measure_kernel(name, kernel, n, policy))),
    };
    let is_wanted = |(_, kernel): &(&str, Kernel)| settings.kinds.iter().any(|kind| kind.is_patch() == kernel.patched);
    KERNELS.into_iter().filter(is_wanted).map(measurement).collect()
}

fn measure_kernel(name: &'static str, kernel: Kernel, n_elements: usize, policy: RepeatPolicy) -> Vec<BenchRow> {
    match kernel.section {
        Section::Spatial => rows(name, Stand::new(&block(n_elements), kernel), policy),
        Section::Planar { .. } | Section::Axisymmetric => rows(name, Stand::new(&section(n_elements), kernel), policy),
    }
}

/// Measures a kernel on every instruction set, and its reference implementation.
fn rows<const D: usize>(name: &'static str, mut stand: Stand<D>, policy: RepeatPolicy) -> Vec<BenchRow> {
    let simd = |(instructions, level)| measure_simd(name, instructions, level, &mut stand, policy);
    let mut rows: Vec<BenchRow> = levels().into_iter().map(simd).collect();
    rows.push(measure_reference(name, &mut stand, policy));
    rows
}

/// Measures the SIMD kernel on one instruction set.
fn measure_simd<const D: usize>(
    name: &'static str,
    instructions: &'static str,
    level: Level,
    stand: &mut Stand<D>,
    policy: RepeatPolicy,
) -> BenchRow {
    let (run, n_in_cache) = stand.some_run();
    stand.load(run);
    let cached = MeasuredTime::per_turn(policy, || stand.sweep(level, run));
    let all = MeasuredTime::per_turn(policy, || stand.sweep_all(level));
    stand.forget();
    stand.sweep_all(level);
    let (bytes, n) = (stand.bytes_per_update(), stand.n_elements());
    let (cached, all) = (SweepTime::new(n_in_cache, cached), SweepTime::new(n, all));
    row(name, instructions, stand.depth(), cached, all)
        .with("bytes_per_update", bytes)
        .with("gigabytes_per_s", bytes * n as f64 / all.spent.cpu / 1e9)
        .and("energy_j", stand.energy())
        .and("bytes_of_nodes_in_cache", stand.bytes_in_cache())
}

/// Measures the scalar reference implementation.
fn measure_reference<const D: usize>(name: &'static str, stand: &mut Stand<D>, policy: RepeatPolicy) -> BenchRow {
    let (n_patches, n) = (stand.n_patches(), stand.n_elements());
    let some = (stand.some_run().1 / stand.depth()).clamp(1, n_patches);
    let cached = MeasuredTime::per_turn(policy, || {
        black_box(stand.evaluate(0..some));
    });
    let all = MeasuredTime::per_turn(policy, || {
        black_box(stand.evaluate(0..n_patches));
    });
    stand.forget();
    let energy = stand.evaluate(0..n_patches);
    let (cached, all) = (SweepTime::new(some * n / n_patches, cached), SweepTime::new(n, all));
    row(name, "reference, scalar", stand.depth(), cached, all)
        .with("bytes_per_update", serde_json::Value::Null)
        .with("gigabytes_per_s", serde_json::Value::Null)
        .and("energy_j", energy)
}

/// Time to update a number of elements.
#[derive(Debug, Clone, Copy)]
struct SweepTime {
    n_elements: usize,
    spent: MeasuredTime,
}

impl SweepTime {
    fn new(n_elements: usize, spent: MeasuredTime) -> Self {
        Self { n_elements, spent }
    }

    /// Returns 10⁶ updates per second for a time of all updates, s.
    fn rate(&self, seconds: f64) -> f64 {
        self.n_elements as f64 / seconds / 1e6
    }
}

/// Returns a row with the rates in cache and from memory.
fn row(element: &str, form: &str, depth: usize, cached: SweepTime, all: SweepTime) -> BenchRow {
    BenchRow::default()
        .with("element", element)
        .with("in_a_patch", depth)
        .with("form", form)
        .with("in_cache_million_per_cpu_s", cached.rate(cached.spent.cpu))
        .with("all_million_per_cpu_s", all.rate(all.spent.cpu))
        .and("in_cache_million_per_wall_s", cached.rate(cached.spent.wall))
        .and("all_million_per_wall_s", all.rate(all.spent.wall))
        .and("elements", all.n_elements)
        .and("elements_in_cache", cached.n_elements)
}
