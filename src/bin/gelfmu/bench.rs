//! `gelfmu bench`: element updates per second of this machine, by threads, and the memory of an element.

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::options::BenchOptions;
use crate::progress::ProgressDisplay;
use crate::source;
use crate::text_width::new_table;
use ballistic_gel::fmi2;
use ballistic_gel::scene::{Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use comfy_table::{Table, presets};
use cpu_time::ProcessTime;
use serde_json::{Value, json};
use std::time::Instant;

/// Numbers of elements, and of repetitions of which the least time counts, of a whole and of a quick measurement.
const WHOLE: (usize, usize) = (165_000, 9);
const QUICK: (usize, usize) = (7_000, 3);
/// Time of the measurement, s: at 5 m/s the ball is a millimetre deep.
const IN_CONTACT: f64 = 0.2e-3;
/// Element updates of a repetition.
const UPDATES: usize = 4_000_000;

/// Measured steps by a number of threads.
struct StepTiming {
    threads: usize,
    updates: f64,
    /// Least wall and CPU time, s.
    wall: f64,
    cpu: f64,
    digest: u128,
}

/// Measures the steps of `sphere-block` in mid-contact, all of the gel moving, and prints a table.
pub fn bench(options: &BenchOptions, console: &Console) -> Result<(), CommandError> {
    let (usual, repeats) = if options.quick { QUICK } else { WHOLE };
    let scene = moving_block(options.elements.unwrap_or(usual))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(fmi2::most_threads());
    let most = if options.threads == 0 { cores } else { options.threads };
    let mut counts = vec![1, most];
    counts.dedup();
    let simulations: Result<Vec<Simulation>, CommandError> =
        counts.iter().map(|threads| new_simulation(&scene, *threads)).collect();
    let mut simulations = simulations?;
    let timings = measure(&mut simulations, &counts, repeats, console)?;
    let elements = simulations[0].observe().cost.elements;
    let bytes = simulations[0].bytes() as f64 / elements as f64;
    let value = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "system": std::env::consts::OS,
        "architecture": std::env::consts::ARCH,
        "cores": cores,
        "elements": elements,
        "bytes_per_element": bytes,
        "rows": timings.iter().map(|timing| timing.to_json(&timings[0])).collect::<Vec<_>>(),
    });
    let text = format!(
        "{elements} elements of sphere-block in mid-contact, all of the gel moving; {bytes:.0} bytes for an element.\n\
         Least of {repeats} repetitions; CPU seconds are those of all threads.\n{}",
        table(&timings)
    );
    console.result(&value, &text);
    Ok(())
}

/// Loads a block of about so many elements that drifts slowly towards its ball: every node moves, and no update is
/// skipped.
fn moving_block(n_elements: usize) -> Result<Scene, CommandError> {
    let size = 5e-3 * (51_200.0 / n_elements as f64).cbrt();
    let set = |key: &str, value: String| Override { key: key.to_owned(), value };
    let overrides = [set("mesh.size", format!("{size:e}")), set("gel.velocity", "[0.0, 0.0, 0.01]".to_owned())];
    Ok(source::load("sphere-block", &overrides)?.scene)
}

fn new_simulation(scene: &Scene, threads: usize) -> Result<Simulation, CommandError> {
    Ok(Simulation::new(scene, CouplingMode::Integrated, threads).map_err(RunError::from)?)
}

/// Measures the same steps from the same state by each number of threads in turn, repeatedly.
fn measure(
    simulations: &mut [Simulation],
    counts: &[usize],
    repeats: usize,
    console: &Console,
) -> Result<Vec<StepTiming>, CommandError> {
    let bar = ProgressDisplay::new(console);
    let fastest = simulations.len() - 1;
    step_to(&mut simulations[fastest], IN_CONTACT)?;
    let (saved, cost) = (simulations[fastest].save(), simulations[fastest].observe().cost);
    let steps = (UPDATES / cost.elements).clamp(4, 60) as f64;
    let settled = IN_CONTACT + cost.largest_step;
    let end = settled + steps * cost.largest_step;
    let mut timings: Vec<StepTiming> = vec![];
    for repeat in 0..repeats {
        for (i, simulation) in simulations.iter_mut().enumerate() {
            bar.show_task(&format!("{} threads", counts[i]), repeat as f64 / repeats as f64);
            simulation.restore(&saved).map_err(|error| step_failure("Simulation::restore", &error))?;
            step_to(simulation, settled)?;
            let timing = measure_once(simulation, counts[i], end)?;
            match timings.get_mut(i) {
                None => timings.push(timing),
                Some(best) => (best.wall, best.cpu) = (best.wall.min(timing.wall), best.cpu.min(timing.cpu)),
            }
        }
    }
    bar.clear();
    Ok(timings)
}

fn measure_once(simulation: &mut Simulation, threads: usize, end: f64) -> Result<StepTiming, CommandError> {
    let before = simulation.observe().cost.element_updates;
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    step_to(simulation, end)?;
    let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let updates = simulation.observe().cost.element_updates - before;
    Ok(StepTiming { threads, updates, wall, cpu, digest: simulation.digest() })
}

/// Steps to a time, s, without external loads on the ball.
fn step_to(simulation: &mut Simulation, end: f64) -> Result<(), CommandError> {
    let inputs = simulation.inputs();
    simulation.step(&inputs, end).map_err(|error| step_failure("Simulation::step", &error))
}

fn step_failure(call: &'static str, error: &dyn std::error::Error) -> CommandError {
    CommandError::Run(RunError::Component { call, reason: error.to_string() })
}

impl StepTiming {
    /// Million element updates per second of wall time, and of CPU time.
    fn rates(&self) -> [f64; 2] {
        [self.wall, self.cpu].map(|seconds| 1e-6 * self.updates / seconds)
    }

    fn to_json(&self, one: &Self) -> Value {
        let [wall, cpu] = self.rates();
        json!({
            "threads": self.threads,
            "updates": self.updates,
            "million_per_wall_s": wall,
            "million_per_cpu_s": cpu,
            "times_as_fast_as_one_thread": one.wall / self.wall,
            "same_bits": self.digest == one.digest,
        })
    }
}

fn table(timings: &[StepTiming]) -> Table {
    let mut table = new_table(presets::UTF8_FULL_CONDENSED);
    table.set_header(["threads", "million updates per s", "per CPU s", "as fast as one", "bits"]);
    for timing in timings {
        let [wall, cpu] = timing.rates();
        let is_same = timing.digest == timings[0].digest;
        table.add_row([
            timing.threads.to_string(),
            format!("{wall:.1}"),
            format!("{cpu:.1}"),
            format!("{:.2}", timings[0].wall / timing.wall),
            if is_same { "the same" } else { "OTHER" }.to_owned(),
        ]);
    }
    table
}
