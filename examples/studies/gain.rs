mod case;
mod engine;
mod slivers;

use super::cpu;
use ballistic_gel::avi::{Engine, Kind};
use ballistic_gel::contact::Exchange;
use ballistic_gel::element::Simplices;
use case::{Case, cases};
use engine::engine;
use std::io::Write as _;

/// The schedules, first the one that the others are compared with: one stable step for all, that of the assembled system.
const SCHEDULES: [(&str, Kind); 3] = [("global", Kind::Global), ("bins", Kind::Bins), ("queue", Kind::Queue)];
/// Times at which the unrounded steps are looked at.
const LOOKS: u32 = 40;
/// What `sphere-block` tends to on ever finer meshes, by the study of that name, mm.
const DEPTH: f64 = 14.58;

/// What steps of their own save, by mesh: updates and CPU seconds of the schedules at one CFL number, and what each gives.
pub fn study() {
    println!("| mesh | elements | fine or flat, % | stable steps, µs | Σ T/Δt | at rest |");
    println!("|---|---|---|---|---|---|");
    let rows: Vec<String> = cases().map(|case| compare(&case)).collect();
    println!(
        "\n| mesh | schedule | updates | of Σ T/Δt | of one step for all | CPU s | updates/s | depth, mm | error, % | v at the end, m/s | defect | closure |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    rows.iter().for_each(|rows| print!("{rows}"));
}

/// A finished run of one schedule.
struct Outcome {
    engine: Engine<3, Simplices<3>>,
    /// CPU time, s.
    seconds: f64,
    /// Σ_K ∫ dt/Δt_K.
    ideal: f64,
    failure: Option<String>,
}

/// Prints the row of a mesh; the rows of its schedules.
fn compare(case: &Case) -> String {
    let runs = SCHEDULES.map(|(name, kind)| (name, run(case, kind)));
    let steps = engine(case, Kind::Bins).stable_steps();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let most = steps.iter().copied().fold(0.0, f64::max);
    println!(
        "| {} | {} | {:.1} | {:.3} … {:.2} | {:.3e} | {:.3e} |",
        case.name,
        case.mesh.elements.len(),
        100.0 * case.fine,
        1e6 * least,
        1e6 * most,
        runs[0].1.ideal,
        case.scene.scene.end_time * steps.iter().map(|step| 1.0 / step).sum::<f64>(),
    );
    std::io::stdout().flush().expect("a terminal");
    runs.iter().map(|(name, outcome)| row(case, name, outcome)).collect()
}

fn row(case: &Case, schedule: &str, outcome: &Outcome) -> String {
    let Outcome { engine, seconds, ideal, failure } = outcome;
    let (end, record) = (case.scene.scene.end_time, &engine.state().record);
    let updates = record.updates as f64;
    let totals = engine.totals(end);
    let books = totals.ledger.energy;
    let depth = 1e3 * record.contacts[0].peak_depth.0;
    format!(
        "| {} | {schedule} | {updates:.3e} | {:.2} | 1/{:.2} | {seconds:.1} | {:.2e} | {depth:.3} | {:+.2} | {:+.4} | {:.1e} | {:.0e} | {}\n",
        case.name,
        updates / ideal,
        engine.synchronous_updates(end) / updates,
        updates / seconds,
        100.0 * (depth / DEPTH - 1.0),
        engine.state().bodies[0].velocity.z,
        (books.integration.abs() + books.contact_bias.abs()) / totals.initial_energy,
        totals.energy_closure.1,
        failure.as_ref().map(|failure| format!("{failure} |")).unwrap_or_default(),
    )
}

fn run(case: &Case, schedule: Kind) -> Outcome {
    let mut engine = engine(case, schedule);
    let slice = case.scene.scene.end_time / f64::from(LOOKS);
    let (mut seconds, mut ideal, mut rate) = (0.0, 0.0, rate(&engine));
    for look in 1..=LOOKS {
        let (t, begun) = (slice * f64::from(look), cpu::seconds());
        let advanced = engine.advance_to(t, &mut [Exchange::default()]);
        seconds += cpu::seconds() - begun;
        if let Err(error) = advanced {
            return Outcome { engine, seconds, ideal, failure: Some(error.to_string()) };
        }
        let next = rate(&engine);
        ideal += 0.5 * slice * (rate + next);
        rate = next;
    }
    Outcome { engine, seconds, ideal, failure: None }
}
