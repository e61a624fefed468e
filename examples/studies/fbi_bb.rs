//! The FBI calibration shot by mesh size, grading and speed of the wave.

use super::cpu::seconds;
use super::run::{scene, tell_refusals};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

/// Times at which the nose is compared, ms; Poncelet's law, fitted to the shot, has it at 16, 30, 60 and 83 mm there.
const TIMES: [f64; 4] = [0.1, 0.2, 0.5, 1.0];

/// Keys of a scene and what they are instead.
pub type Keys = [(&'static str, &'static str)];

/// Runs of the shot, and what is changed in each: the mesh, the step and the wave, then the speed.
const RUNS: [(&str, &Keys); 14] = [
    ("as it comes: R/8, growth 0.1", &[]),
    ("cells of R/5", &[("mesh.size", "0.43e-3"), ("remesh.smallest", "0.2e-3")]),
    ("cells of R/12", &[("mesh.size", "0.18e-3"), ("remesh.smallest", "0.09e-3")]),
    ("growth 0.15", &[("remesh.growth", "0.15")]),
    ("growth 0.05", &[("remesh.growth", "0.05")]),
    ("R/12, growth 0.05", &[("mesh.size", "0.18e-3"), ("remesh.smallest", "0.09e-3"), ("remesh.growth", "0.05")]),
    ("half the step", &[("integrator.cfl", "0.4")]),
    ("wave of 1500 m/s", &[("gel.bulk_modulus", "2317.5e6")]),
    ("75 m/s", &[("projectile.velocity", "[0, 0, -75]")]),
    ("100 m/s", &[("projectile.velocity", "[0, 0, -100]")]),
    ("150 m/s", &[("projectile.velocity", "[0, 0, -150]")]),
    ("165 m/s", &[("projectile.velocity", "[0, 0, -165]")]),
    ("195 m/s", &[("projectile.velocity", "[0, 0, -195]")]),
    ("210 m/s", &[("projectile.velocity", "[0, 0, -210]")]),
];

/// Nose, depth, energies.
pub fn study() {
    head();
    for (name, keys) in RUNS {
        row("fbi-bb", name, keys);
    }
    row("sphere-720", "4.8 mm at 720 m/s, not fitted anew", &[]);
}

/// The head of the table.
pub fn head() {
    let times: Vec<String> = TIMES.iter().map(|time| format!(" {time} ms: mm |")).collect();
    println!(
        "| |{} depth, mm | at, ms | meshes | refused | elements | M updates | plastic, % of E₀ | viscous | remesh | of it kinetic | integration | bias | splash | closure | CPU s | exchanging, s |",
        times.concat()
    );
    println!("|---|{}---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|", "---|".repeat(TIMES.len()));
}

/// A run of a scene with some of its keys replaced.
pub fn row(shot: &str, name: &str, keys: &Keys) {
    let keys: Vec<(&str, String)> = keys.iter().map(|(key, value)| (*key, (*value).to_owned())).collect();
    let scene = scene(shot, &keys);
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    let mut seen_at = vec![];
    let mut end = Ok(());
    for time in TIMES.iter().map(|time| 1e-3 * time) {
        end = end.and_then(|()| simulation.step(&inputs, time));
        seen_at.push(format!(" {:.2} |", 1e3 * simulation.depth(0)));
    }
    let end = end.and_then(|()| simulation.step(&inputs, scene.scene.end_time));
    if let Err(why) = end {
        eprintln!("{name}: {why}");
    }
    let (cpu, seen_at) = (seconds() - begun, seen_at.concat());
    let seen: Observation = simulation.observe();
    let (depth, at) = seen.projectile().contact.peak_depth;
    let part = |energy: f64| 100.0 * energy / seen.energy.initial;
    let renewals = simulation.renewals();
    let kinetic: f64 = renewals.iter().map(|renewal| renewal.kinetic[1] - renewal.kinetic[0]).sum();
    tell_refusals(name, &simulation);
    println!(
        "| {name} |{seen_at} {:.2} | {:.3} | {} | {} | {} | {:.1} | {:+.2} | {:+.2} | {:+.2} | {:+.2} | {:+.2} | {:+.2} | {:+.2} | {:.0e} | {cpu:.1} | {:.1} |",
        1e3 * depth,
        1e3 * at,
        seen.cost.remeshes,
        simulation.refusals().len(),
        seen.cost.elements,
        1e-6 * seen.cost.element_updates,
        part(seen.energy.plastic),
        part(seen.energy.viscous),
        part(seen.energy.remesh),
        part(kinetic),
        part(seen.energy.integration),
        part(seen.energy.contact_bias),
        part(seen.energy.splash),
        seen.energy.energy_error,
        renewals.iter().map(|renewal| renewal.seconds).sum::<f64>(),
    );
}
