//! A body pressed on the gel by a constant force for a second.

use super::shot::{Space, shot};
use ballistic_gel::algebra::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, EnergyReport, Inputs, Simulation, Wrench};
use std::io::Write as _;
use std::time::Instant;

/// Time in which the force grows to its value, many periods of the gel, s; then it is held.
const GROWTH: f64 = 0.25;
const HELD: f64 = 1.0;
/// Communication step, and the window of the mean force, s.
const STEP: f64 = 1e-3;

/// Noise of the contact force and drift of the accounts in a second of rest.
pub fn study() {
    println!(
        "| body | force, N | depth, mm | noise, first tenth, % of the force | last tenth | slow swing, first tenth, % | last tenth | Δdepth, mm | Δcontact, % of elastic | Δbias | Δintegration | closure | updates | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (body, force) in [("sphere", 0.5), ("sphere", 5.0), ("cylinder", 5.0), ("cylinder on its rim, rounded", 5.0)] {
        row(body, force);
    }
    println!();
}

/// What a second of rest shows.
pub struct Rest {
    /// rms of the change of the mean force from step to step in the first and the last tenth, in parts of the force.
    pub noise: [f64; 2],
    /// rms of the mean force about the force, the same.
    pub swing: [f64; 2],
    /// Depth, m, and energy, when the force has just grown and at the end.
    pub ends: [(f64, EnergyReport); 2],
    pub updates: f64,
}

/// A body of 33 g on coarse cells.
pub fn scene(body: &str, size: f64) -> Scene {
    let keys = [
        ("mesh.size", format!("{size:e}")),
        ("projectile.velocity", "[0.0, 0.0, 0.0]".to_owned()),
        ("scene.end_time", (GROWTH + HELD).to_string()),
        ("scene.communication_step", STEP.to_string()),
    ];
    shot((Space::Spatial, body), [0.0, 0.0], &keys)
}

/// Presses the body of a scene on the gel.
pub fn press(scene: &Scene, force: f64) -> Rest {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (growing, all) = ((GROWTH / STEP).round() as u32, ((GROWTH + HELD) / STEP).round() as u32);
    let mut forces = vec![];
    let mut ends = vec![];
    for step in 0..all {
        if step == growing {
            ends.push(seen(&simulation));
        }
        let inputs = Inputs { wrench: wrench(f64::from(step) * STEP, force), ..simulation.inputs() };
        simulation.step(&inputs, f64::from(step + 1) * STEP).expect("a body at rest");
        forces.push(simulation.exchange().mean_force().z / force);
    }
    ends.push(seen(&simulation));
    let held = &forces[growing as usize..];
    let tenth = held.len() / 10;
    let tenths = [&held[..tenth], &held[held.len() - tenth..]];
    Rest {
        noise: tenths.map(|part| rms(part.windows(2).map(|pair| pair[1] - pair[0]))),
        swing: tenths.map(|part| rms(part.iter().map(|part| part - 1.0))),
        ends: [ends[0], ends[1]],
        updates: simulation.observe().cost.element_updates,
    }
}

fn seen(simulation: &Simulation) -> (f64, EnergyReport) {
    let seen = simulation.observe();
    (seen.depth, seen.energy)
}

/// Down, growing and then constant.
fn wrench(time: f64, force: f64) -> Wrench {
    let down = -Vector3::z() * force;
    let grows = time < GROWTH - 0.5 * STEP;
    let (force, force_rate) = if grows { (down * (time / GROWTH), down / GROWTH) } else { (down, Vector3::zeros()) };
    Wrench { force, force_rate, ..Wrench::default() }
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / n).sqrt()
}

fn row(body: &str, force: f64) {
    let begun = Instant::now();
    let Rest { noise, swing, ends: [(was, before), (now, after)], updates } = press(&scene(body, 1e-2), force);
    let change = |pick: fn(&EnergyReport) -> f64| 100.0 * (pick(&after) - pick(&before)) / after.elastic;
    println!(
        "| {body} | {force} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {:+.4} | {:+.2} | {:+.3} | {:+.3} | {:.0e} | {updates:.1e} | {:.1} |",
        1e3 * now,
        100.0 * noise[0],
        100.0 * noise[1],
        100.0 * swing[0],
        100.0 * swing[1],
        1e3 * (now - was),
        change(|energy| energy.contact),
        change(|energy| energy.contact_bias),
        change(|energy| energy.integration),
        after.energy_error,
        begun.elapsed().as_secs_f64(),
    );
    std::io::stdout().flush().expect("a terminal");
}
