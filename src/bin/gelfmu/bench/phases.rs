//! Where the time of a step goes, ns per element update of one thread: differences of what can be run by itself.

use super::Measurement;
use super::settings::Settings;
use super::spent::{Effort, Spent};
use super::stand::{Kernel, Stand, block, levels};
use super::steps::{self, Subject};
use super::table::Row;
use crate::failure::Failure;
use crate::options::{ElementName, SectionName};
use ballistic_gel::fem::{LANES, Section};
use serde_json::Value;

/// The element phase by itself, ns per update.
struct Elements {
    /// Nodes copied to where the kernel finds them.
    load: f64,
    /// Gather, arithmetic and sums at the nodes, in cache.
    cached: f64,
    /// The same where no sum waits for that of a neighbour; of plain elements.
    apart: Option<f64>,
    /// All of it, from memory.
    all: f64,
}

pub fn plan(settings: &Settings) -> Vec<Measurement> {
    let effort = settings.effort;
    let of = |(n, kind): (usize, ElementName)| {
        let subject = Subject::new((n, kind), settings);
        Measurement {
            section: SectionName::Phases,
            what: format!("{n} elements, {}", kind.as_str()),
            cost: if settings.quick { 0.5 } else { 5.0 + n as f64 * 2e-5 },
            go: Box::new(move || Ok(vec![row(&subject, effort)?])),
        }
    };
    settings.subjects().into_iter().map(of).collect()
}

fn row(subject: &Subject, effort: Effort) -> Result<Row, Failure> {
    let patched = subject.kind.is_patched();
    let mut stand = Stand::new(&block(subject.n_elements), Kernel { section: Section::Spatial, patched, flows: false });
    let elements = measure(&mut stand, patched, effort);
    let n_elements = stand.n_elements();
    drop(stand);
    let whole = whole_step(subject, effort)?;
    let without_ball = whole_step(&subject.without_ball(), effort)?;
    let waiting = elements.apart.map_or(Value::Null, |apart| (elements.cached - apart).into());
    Ok(Row::default()
        .with("elements", n_elements)
        .with("element", subject.kind.as_str())
        .with("whole_step_ns", whole)
        .with("load_nodes_ns", elements.load)
        .with("gather_compute_sum_in_cache_ns", elements.cached)
        .with("of_that_waiting_for_sums_ns", waiting)
        .with("memory_and_keeping_sums_ns", elements.all - elements.load - elements.cached)
        .with("contact_ns", whole - without_ball)
        .with("nodes_clocks_books_ns", without_ball - elements.all)
        .and("element_phase_ns", elements.all))
}

/// Of one thread, ns per update.
fn whole_step(subject: &Subject, effort: Effort) -> Result<f64, Failure> {
    let stepped = steps::measure(subject, &[1], effort)?;
    Ok(stepped.iter().map(|it| it.spent.cpu / it.updates * 1e9).sum())
}

fn measure(stand: &mut Stand<3>, patched: bool, effort: Effort) -> Elements {
    let (_, level) = levels()[0];
    let (run, n_of_run) = stand.some_run();
    let ns = |spent: Spent, n: usize| spent.cpu / n as f64 * 1e9;
    stand.load(run);
    let cached = ns(Spent::per_turn(effort, || stand.sweep(level, run)), n_of_run);
    let apart = (!patched).then(|| {
        let (lanes, n) = (stand.apart(), n_of_run / LANES * LANES);
        ns(Spent::per_turn(effort, || stand.sweep_alone(level, &lanes, n)), n)
    });
    let load = ns(Spent::per_turn(effort, || stand.load_all()), stand.n_elements());
    let all = ns(Spent::per_turn(effort, || stand.sweep_all(level)), stand.n_elements());
    Elements { load, cached, apart, all }
}
