mod case;
mod engine;
mod slivers;

use super::cpu;
use ballistic_gel::contact::ImpulseExchange;
use ballistic_gel::fem::Simplices;
use ballistic_gel::integrator::{Engine, SteppingSchedule};
use case::{Case, cases};
use engine::engine;
use std::io::Write as _;

/// The schedules, first the one that the others are compared with: one stable step for all, that of the assembled system.
const SCHEDULES: [(&str, SteppingSchedule); 3] =
    [("global", SteppingSchedule::Global), ("bins", SteppingSchedule::Bins), ("queue", SteppingSchedule::Queue)];
/// Times at which the unrounded steps are looked at.
const LOOKS: u32 = 40;

/// What steps of their own save, by mesh: updates and CPU seconds of the schedules at one CFL number, and what each gives.
pub fn study() {
    println!("| mesh | elements | fine or flat, % | stable steps, µs | Σ T/Δt at rest |");
    println!("|---|---|---|---|---|");
    cases().for_each(|case| describe(&case));
    println!(
        "\n| mesh | schedule | updates | of Σ T/Δt | of Σ ∫dt/Δt | gain | over the least | CPU s | gain | updates/s | depth, mm | error, % | v at the end, m/s | defect | closure |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    cases().for_each(|case| compare(&case));
}

fn describe(case: &Case) {
    let steps = engine(case, SteppingSchedule::Bins).stable_steps();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let most = steps.iter().copied().fold(0.0, f64::max);
    println!(
        "| {} | {} | {:.1} | {:.3} to {:.2} | {:.3e} |",
        case.name,
        case.mesh.elements.len(),
        100.0 * case.fine,
        1e6 * least,
        1e6 * most,
        case.scene.scene.end_time * steps.iter().map(|step| 1.0 / step).sum::<f64>(),
    );
}

/// A finished run of one schedule.
struct Outcome {
    engine: Engine<3, Simplices<3>>,
    updates: f64,
    /// CPU time, s.
    seconds: f64,
    /// Σ_K T/Δt_K with one step for each element, the longest that is stable at all looks.
    constant: f64,
    /// Σ_K ∫ dt/Δt_K with the step that is stable at each instant.
    ideal: f64,
    /// The same with the least of these steps for all elements: one step that would also be raised at once.
    least: f64,
}

fn compare(case: &Case) {
    let mut global = None;
    for (schedule, kind) in SCHEDULES {
        let outcome = run(case, kind);
        let cost = (outcome.updates, outcome.seconds);
        row(case, (schedule, &outcome), *global.get_or_insert(cost));
    }
}

fn row(case: &Case, (schedule, outcome): (&str, &Outcome), global: (f64, f64)) {
    let Outcome { engine, updates, seconds, constant, ideal, least } = outcome;
    let totals = engine.totals(case.scene.scene.end_time);
    let books = totals.ledger.energy;
    let depth = 1e3 * engine.state().record.contacts[0].peak_depth.0;
    println!(
        "| {} | {schedule} | {updates:.3e} | {:.2} | {:.2} | {:.2} | {:.2} | {seconds:.1} | {:.2} | {:.2e} | {depth:.3} | {} | {:+.4} | {:.1e} | {:.0e} |",
        case.name,
        updates / constant,
        updates / ideal,
        global.0 / updates,
        least / updates,
        global.1 / seconds,
        updates / seconds,
        case.depth.map_or("–".to_owned(), |limit| format!("{:+.2}", 100.0 * (depth / limit - 1.0))),
        engine.state().bodies[0].velocity.z,
        (books.integration.abs() + books.contact_bias.abs()) / totals.initial_energy,
        totals.energy_imbalance.1,
    );
    std::io::stdout().flush().expect("a terminal");
}

/// Runs a case to its end on one thread.
fn run(case: &Case, schedule: SteppingSchedule) -> Outcome {
    let mut engine = engine(case, schedule);
    let end = case.scene.scene.end_time;
    let slice = end / f64::from(LOOKS);
    let mut lasting = engine.stable_steps();
    let (mut seconds, mut sums, mut before) = (0.0, [0.0; 2], rates(&lasting));
    for look in 1..=LOOKS {
        let begun = cpu::seconds();
        engine
            .advance_to(slice * f64::from(look), &mut [ImpulseExchange::default()])
            .expect("a run that comes to its end");
        seconds += cpu::seconds() - begun;
        let steps = engine.stable_steps();
        lasting.iter_mut().zip(&steps).for_each(|(lasting, step)| *lasting = lasting.min(*step));
        let now = rates(&steps);
        for ((sum, before), now) in sums.iter_mut().zip(before).zip(now) {
            *sum += 0.5 * slice * (before + now);
        }
        before = now;
    }
    let ([ideal, least], [constant, _]) = (sums, rates(&lasting).map(|rate| end * rate));
    Outcome { updates: engine.state().record.updates as f64, engine, seconds, constant, ideal, least }
}

/// Updates in a second, 1/s, if every element took its own step of these, Σ_K 1/Δt_K, and if all took the least, N/min Δt_K.
fn rates(steps: &[f64]) -> [f64; 2] {
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    [steps.iter().map(|step| 1.0 / step).sum(), steps.len() as f64 / least]
}
