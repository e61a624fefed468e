//! Drag and slam of a ball in a fluid, by mesh size, grading and speed of the wave.

use super::cpu::seconds;
use super::run::{scene, tell_refusals};
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Depths between which the drag is a mean, mm.
const WINDOWS: [(f64, f64); 5] = [(8.0, 16.0), (16.0, 24.0), (24.0, 36.0), (36.0, 60.0), (60.0, 89.0)];

/// Edges beneath the ball, m, growth with the distance, and speed of the wave, m/s.
const RUNS: [(f64, f64, f64); 7] = [
    (0.27e-3, 0.15, 600.0),
    (0.18e-3, 0.1, 600.0),
    (0.18e-3, 0.07, 600.0),
    (0.12e-3, 0.05, 600.0),
    (0.18e-3, 0.07, 1500.0),
    (0.12e-3, 0.05, 1500.0),
    (0.09e-3, 0.0375, 1500.0),
];

/// Force over ½ρv²πR².
pub fn study() {
    let windows: Vec<String> = WINDOWS.iter().map(|(from, to)| format!(" C_d {from:.0}–{to:.0} mm |")).collect();
    println!(
        "| cells, mm | growth | wave, m/s | slam (2 µs) |{} meshes | elements | M updates | CPU s |",
        windows.concat()
    );
    println!("|---|---|---|---|{}---|---|---|---|", "---|".repeat(WINDOWS.len()));
    RUNS.into_iter().for_each(row);
}

fn row((size, growth, wave): (f64, f64, f64)) {
    let keys = [
        ("mesh.size", size.to_string()),
        ("remesh.smallest", (0.5 * size).to_string()),
        ("remesh.growth", growth.to_string()),
        ("gel.bulk_modulus", (1030.0 * wave * wave).to_string()),
    ];
    let scene = scene("hydro-drag", &keys);
    let (speed, radius) = (179.8_f64, 2.185e-3_f64);
    let unit = 0.5 * scene.gel.density * speed * speed * std::f64::consts::PI * radius * radius;
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    let (step, mut seen, mut time) = (scene.scene.communication_step, vec![(0.0, 0.0, 0.0)], 0.0);
    while time < scene.scene.end_time {
        time += step;
        if let Err(why) = simulation.step(&inputs, time) {
            eprintln!("{size}: {why}");
            break;
        }
        seen.push((time, 1e3 * simulation.depth(0), simulation.total_impulse(0).z));
    }
    let cpu = seconds() - begun;
    tell_refusals(&format!("{size}, {growth}, {wave}"), &simulation);
    let slam = seen.windows(2).map(|pair| (pair[1].2 - pair[0].2) / step / unit).fold(0.0, f64::max);
    let drag = |(from, to): (f64, f64)| {
        let mut within = seen.iter().filter(|(_, depth, _)| (from..=to).contains(depth));
        let (first, last) = (within.next(), within.next_back());
        first.zip(last).map_or(f64::NAN, |(a, b)| (b.2 - a.2) / (b.0 - a.0) / unit)
    };
    let drags: Vec<String> = WINDOWS.into_iter().map(|window| format!(" {:.3} |", drag(window))).collect();
    let cost = simulation.cost();
    println!(
        "| {:.2} | {growth} | {wave} | {slam:.2} |{} {} | {} | {:.1} | {cpu:.0} |",
        1e3 * size,
        drags.concat(),
        cost.remeshes,
        cost.elements,
        1e-6 * cost.element_updates,
    );
}
