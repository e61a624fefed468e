//! `gelfmu bench`: how fast this machine steps a gel, how much memory an element takes, and what the calls of the FMU cost.

mod calls;
mod memory;
mod options;
mod scenes;
mod settings;
mod spent;
mod steps;
mod table;
mod threads;

use crate::console::Console;
use crate::failure::CommandError;
use crate::interrupt;
use crate::pack::{PackedLibraries, own_platform};
use crate::progress::ProgressDisplay;
use ballistic_gel::fmi2;
pub use options::BenchOptions;
use options::SectionName;
use serde_json::{Map, Value, json};
use settings::BenchSettings;
use table::BenchRow;

/// One thing to measure.
struct Measurement {
    section: SectionName,
    /// Name for the progress.
    what: String,
    /// Expected duration, s, by which the progress advances.
    cost: f64,
    go: Box<dyn FnOnce() -> Result<Vec<BenchRow>, CommandError>>,
}

/// Measurements of one section.
struct BenchSection {
    name: SectionName,
    rows: Vec<BenchRow>,
}

const WAITING: &str =
    "interrupted: what was measured so far is printed after this measurement; Ctrl-C again ends at once";

/// Measures, prints, and says with which status to end.
pub fn bench(options: &BenchOptions, console: &Console) -> Result<u8, CommandError> {
    let settings = BenchSettings::of(options);
    if let Err(error) = interrupt::listen(WAITING, console.listener()) {
        console.note(&format!("Ctrl-C will print nothing: {error}"));
    }
    let mut plan = plan(&settings);
    let wanted = settings.wants(SectionName::Calls) && !settings.is_named(SectionName::Calls);
    if wanted && let Err(error) = PackedLibraries::find(&[own_platform().to_owned()]) {
        plan.retain(|measurement| measurement.section != SectionName::Calls);
        console.note(&format!("calls are left out: {error}"));
    }
    let sections = measure(plan, console)?;
    console.result(&to_json(&settings, &sections), &to_text(&settings, &sections));
    if interrupt::asked() { Ok(interrupt::INTERRUPTED) } else { Ok(0) }
}

/// Everything that is wanted, in order. Memory comes first: what other sections leave behind would hide its growth.
fn plan(settings: &BenchSettings) -> Vec<Measurement> {
    let all = [memory::plan, steps::plan, calls::plan];
    let wanted = |measurement: &Measurement| settings.wants(measurement.section);
    all.into_iter().flat_map(|plan| plan(settings)).filter(wanted).collect()
}

fn measure(plan: Vec<Measurement>, console: &Console) -> Result<Vec<BenchSection>, CommandError> {
    let bar = ProgressDisplay::new(console);
    let (all, mut done) = (plan.iter().map(|measurement| measurement.cost).sum::<f64>(), 0.0);
    let mut sections: Vec<BenchSection> = vec![];
    for Measurement { section, what, cost, go } in plan {
        if interrupt::asked() {
            break;
        }
        bar.show_task(&format!("{}: {what}", section.as_str()), done / all);
        let rows = go()?;
        match sections.last_mut() {
            Some(last) if last.name == section => last.rows.extend(rows),
            Some(_) | None => sections.push(BenchSection { name: section, rows }),
        }
        done += cost;
    }
    bar.clear();
    Ok(sections)
}

fn to_json(settings: &BenchSettings, sections: &[BenchSection]) -> Value {
    let of = |section: &BenchSection| {
        let rows: Vec<Value> = section.rows.iter().map(BenchRow::to_json).collect();
        (section.name.as_str().to_owned(), json!({ "about": section.name.about(), "rows": rows }))
    };
    let mut all: Map<String, Value> = sections.iter().map(of).collect();
    all.insert("settings".to_owned(), settings.to_json());
    Value::Object(all)
}

fn to_text(settings: &BenchSettings, sections: &[BenchSection]) -> String {
    format!("{}\n\n{}", settings.describe(), table::text(sections.iter().flat_map(|section| &section.rows)))
}

/// Threads that are meant: 0 is all cores.
fn n_threads(asked: usize) -> usize {
    if asked > 0 {
        asked
    } else {
        std::thread::available_parallelism().map_or(1, usize::from).min(fmi2::most_threads())
    }
}
