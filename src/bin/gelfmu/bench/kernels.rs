//! Element updates per second of each kernel on each instruction set, in cache and from memory.

use super::Measurement;
use super::settings::Settings;
use super::spent::{Effort, Spent};
use super::stand::{KERNELS, Kernel, Stand, block, levels, section};
use super::table::Row;
use crate::options::SectionName;
use ballistic_gel::fem::Section;
use fearless_simd::Level;
use std::hint::black_box;

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let (n, effort) = (settings.largest(), settings.effort);
    let of = |(name, kernel): (&'static str, Kernel)| Measurement {
        section: SectionName::Kernels,
        what: format!("{name}, {}", if kernel.patched { "patches" } else { "plain" }),
        cost: if settings.quick { 0.5 } else { 16.0 },
        go: Box::new(move || Ok(of_kind(name, kernel, n, effort))),
    };
    let wanted = |(_, kernel): &(&str, Kernel)| settings.kinds.iter().any(|kind| kind.is_patched() == kernel.patched);
    KERNELS.into_iter().filter(wanted).map(of).collect()
}

fn of_kind(name: &'static str, kernel: Kernel, n_elements: usize, effort: Effort) -> Vec<Row> {
    match kernel.section {
        Section::Spatial => rows(name, Stand::new(&block(n_elements), kernel), effort),
        Section::Planar { .. } | Section::Axisymmetric => rows(name, Stand::new(&section(n_elements), kernel), effort),
    }
}

fn rows<const D: usize>(name: &'static str, mut stand: Stand<D>, effort: Effort) -> Vec<Row> {
    let mut rows: Vec<Row> = levels().into_iter().map(|level| in_lanes((name, level), &mut stand, effort)).collect();
    rows.push(reference(name, &mut stand, effort));
    rows
}

fn in_lanes<const D: usize>(
    (name, (instructions, level)): (&'static str, (&'static str, Level)),
    stand: &mut Stand<D>,
    effort: Effort,
) -> Row {
    let (run, n_of_run) = stand.some_run();
    stand.load(run);
    let cached = Spent::per_turn(effort, || stand.sweep(level, run));
    let all = Spent::per_turn(effort, || stand.sweep_all(level));
    stand.forget();
    stand.sweep_all(level);
    let (bytes, n) = (stand.bytes_per_update(), stand.n_elements());
    row((name, instructions), (stand.depth(), n), [(n_of_run, cached), (n, all)])
        .with("bytes_per_update", bytes)
        .with("gigabytes_per_s", bytes * n as f64 / all.cpu / 1e9)
        .and("energy_j", stand.energy())
        .and("bytes_of_nodes_in_cache", stand.bytes_in_cache())
}

fn reference<const D: usize>(name: &'static str, stand: &mut Stand<D>, effort: Effort) -> Row {
    let (n_patches, n) = (stand.n_patches(), stand.n_elements());
    let some = (stand.some_run().1 / stand.depth()).clamp(1, n_patches);
    let cached = Spent::per_turn(effort, || {
        black_box(stand.evaluate(0..some));
    });
    let all = Spent::per_turn(effort, || {
        black_box(stand.evaluate(0..n_patches));
    });
    stand.forget();
    let energy = stand.evaluate(0..n_patches);
    row((name, "reference, scalar"), (stand.depth(), n), [(some * n / n_patches, cached), (n, all)])
        .with("bytes_per_update", serde_json::Value::Null)
        .with("gigabytes_per_s", serde_json::Value::Null)
        .and("energy_j", energy)
}

/// Rates from updates and times in cache and from memory.
fn row((element, form): (&str, &str), (depth, n): (usize, usize), [cached, all]: [(usize, Spent); 2]) -> Row {
    let rate = |n: usize, seconds: f64| n as f64 / seconds / 1e6;
    Row::default()
        .with("element", element)
        .with("in_a_patch", depth)
        .with("form", form)
        .with("in_cache_million_per_cpu_s", rate(cached.0, cached.1.cpu))
        .with("all_million_per_cpu_s", rate(all.0, all.1.cpu))
        .and("in_cache_million_per_wall_s", rate(cached.0, cached.1.wall))
        .and("all_million_per_wall_s", rate(all.0, all.1.wall))
        .and("elements", n)
        .and("elements_in_cache", cached.0)
}
