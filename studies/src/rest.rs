//! A body pressed on the gel by a constant force for a second.

use super::shot::{Space, shot};
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, EnergyReport, Simulation, StepInputs, Wrench};
use std::io::Write as _;
use std::time::Instant;

/// Time in which the force grows to its value, many periods of the gel, s; then it is held.
const GROWTH: f64 = 0.25;
const HELD: f64 = 1.0;
/// Communication step, and the window of the mean force, s.
const STEP: f64 = 1e-3;

/// A body of 33 g (a bar of 2.5 kg in the plane) on coarse cells.
pub struct Case {
    /// What is special.
    label: &'static str,
    space: Space,
    body: &'static str,
    /// Where, in cells.
    at: [f64; 2],
    /// Edge of a cell, m.
    size: f64,
    /// N.
    force: f64,
}

/// A second of rest each.
pub const CASES: [Case; 5] = [
    Case { label: "", space: Space::Axisymmetric, body: "sphere", at: [0.0, 0.0], size: 2e-3, force: 5.0 },
    Case { label: "", space: Space::Planar, body: "cylinder", at: [0.0, 0.0], size: 5e-3, force: 200.0 },
    Case { label: "", space: Space::Spatial, body: "cylinder", at: [0.0, 0.0], size: 1e-2, force: 5.0 },
    Case { label: ", between nodes", space: Space::Spatial, body: "sphere", at: [0.5, 0.0], size: 1e-2, force: 5.0 },
    Case { label: ", on a node", space: Space::Spatial, body: "sphere", at: [0.0, 0.0], size: 1e-2, force: 5.0 },
];

/// Noise of the contact force and drift of the accounts in a second of rest.
pub fn study() {
    println!(
        "| body | force, N | depth, mm | noise, % of the force: first tenth | last | swing, %: first tenth | last | Δdepth, mm | aside, mm | Δcontact, % of elastic | Δbias | Δintegration | closure | updates | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for case in CASES {
        row(&case);
    }
    println!();
}

/// What a second of rest shows.
pub struct Rest {
    /// rms of the change of the mean force from step to step in the first and the last tenth, in parts of the force.
    pub noise: [f64; 2],
    /// rms of the mean force about the force, the same.
    pub swing: [f64; 2],
    /// Mean depth in the first and the last tenth, m.
    pub depth: [f64; 2],
    /// When the force has just grown, and at the end.
    pub energy: [EnergyReport; 2],
    updates: f64,
    /// How far it has moved sideways, m.
    aside: f64,
}

fn scene(case: &Case) -> Scene {
    let keys = [
        ("mesh.size", format!("{:e}", case.size)),
        ("projectile.velocity", "[0.0, 0.0, 0.0]".to_owned()),
        ("scene.end_time", (GROWTH + HELD).to_string()),
        ("scene.communication_step", STEP.to_string()),
    ];
    shot((case.space, case.body), case.at.map(|x| x * case.size), &keys)
}

/// Presses the body on the gel and looks at it until the end.
pub fn press(case: &Case) -> Rest {
    let force = case.force;
    let mut simulation = Simulation::new(&scene(case), CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (growing, all) = ((GROWTH / STEP).round() as u32, ((GROWTH + HELD) / STEP).round() as u32);
    let start = simulation.kinematics(0).position;
    let mut forces = vec![];
    let (mut depths, mut energy) = (vec![], vec![]);
    for step in 0..all {
        if step == growing {
            energy.push(simulation.observe().energy);
        }
        let wrench = wrench(f64::from(step) * STEP, force);
        let inputs = simulation.inputs().into_iter().map(|inputs| StepInputs { wrench, ..inputs }).collect::<Vec<_>>();
        simulation.step(&inputs, f64::from(step + 1) * STEP).expect("a body at rest");
        depths.push(simulation.observe().projectile().depth);
        forces.push(simulation.exchanges()[0].mean_force().z / force);
    }
    energy.push(simulation.observe().energy);
    let tenth = (all - growing) as usize / 10;
    let tenths = [growing as usize..growing as usize + tenth, all as usize - tenth..all as usize];
    Rest {
        noise: tenths.clone().map(|part| rms(forces[part].windows(2).map(|pair| pair[1] - pair[0]))),
        swing: tenths.clone().map(|part| rms(forces[part].iter().map(|part| part - 1.0))),
        depth: tenths.map(|part| depths[part].iter().sum::<f64>() / tenth as f64),
        energy: [energy[0], energy[1]],
        aside: (simulation.kinematics(0).position - start).xy().norm(),
        updates: simulation.observe().cost.element_updates,
    }
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

fn row(case: &Case) {
    let begun = Instant::now();
    let Rest { noise, swing, depth: [was, now], energy: [before, after], updates, aside } = press(case);
    let change = |pick: fn(&EnergyReport) -> f64| 100.0 * (pick(&after) - pick(&before)) / after.elastic;
    println!(
        "| {}{}{} | {} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {:+.4} | {:.1e} | {:+.2} | {:+.3} | {:+.3} | {:.0e} | {updates:.1e} | {:.1} |",
        case.space.label(),
        case.body,
        case.label,
        case.force,
        1e3 * now,
        100.0 * noise[0],
        100.0 * noise[1],
        100.0 * swing[0],
        100.0 * swing[1],
        1e3 * (now - was),
        1e3 * aside,
        change(|energy| energy.contact),
        change(|energy| energy.contact_bias),
        change(|energy| energy.integration),
        after.energy_error,
        begun.elapsed().as_secs_f64(),
    );
    std::io::stdout().flush().expect("a terminal");
}
