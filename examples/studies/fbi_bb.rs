//! The FBI calibration shot by mesh size, grading and speed of the wave.

use super::cpu::seconds;
use super::run::scene;
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

/// Times at which the nose is compared, ms; Poncelet's law, fitted to the shot, has it at 16, 30, 60 and 83 mm there.
const TIMES: [f64; 4] = [0.1, 0.2, 0.5, 1.0];

/// Runs of the shot, and what is changed in each.
const RUNS: [(&str, &[(&str, &str)]); 1] = [("h = R/8", &[])];

/// Nose, depth, energies.
pub fn study() {
    let times: Vec<String> = TIMES.iter().map(|time| format!(" {time} ms: mm |")).collect();
    println!(
        "| |{} depth, mm | at, ms | meshes | refused | elements | M updates | plastic, % of E₀ | viscous | remesh | of it kinetic | integration | bias | splash | closure | CPU s | exchanging, s |",
        times.concat()
    );
    println!("|---|{}---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|", "---|".repeat(TIMES.len()));
    for (name, keys) in RUNS {
        row(name, keys);
    }
}

fn row(name: &str, keys: &[(&str, &str)]) {
    let keys: Vec<(&str, String)> = keys.iter().map(|(key, value)| (*key, (*value).to_owned())).collect();
    let scene = scene("fbi-bb", &keys);
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    let mut seen_at = String::new();
    let mut end = Ok(());
    for time in TIMES.iter().map(|time| 1e-3 * time) {
        end = end.and_then(|()| simulation.step(&inputs, time));
        seen_at += &format!(" {:.2} |", 1e3 * simulation.depth(0));
    }
    let end = end.and_then(|()| simulation.step(&inputs, scene.scene.end_time));
    if let Err(why) = end {
        eprintln!("{name}: {why}");
    }
    let cpu = seconds() - begun;
    let seen: Observation = simulation.observe();
    let (depth, at) = seen.projectile().contact.peak_depth;
    let part = |energy: f64| 100.0 * energy / seen.energy.initial;
    let renewals = simulation.renewals();
    let kinetic: f64 = renewals.iter().map(|renewal| renewal.kinetic[1] - renewal.kinetic[0]).sum();
    for (time, why) in simulation.refusals() {
        eprintln!(
            "{name}: no mesh at {:.4} ms: {}",
            1e3 * time,
            why.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
        );
    }
    if std::env::var_os("VERBOSE").is_some() {
        for r in renewals {
            eprintln!(
                "{:.4} ms attempt {} unchanged {:.3} kinetic {:+.2e} of {:.3e} all {:+.2e} change {:+.1e} q {:.3} mass {:.1e} P {:.1e} {:.3} s",
                1e3 * r.time,
                r.attempt,
                r.unchanged,
                r.kinetic[1] - r.kinetic[0],
                r.kinetic[0],
                r.energy,
                r.quality.change,
                r.quality.least,
                r.mass,
                r.momentum,
                r.seconds
            );
        }
    }
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
