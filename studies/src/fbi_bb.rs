//! The FBI calibration shot by mesh size, grading and speed of the wave.

use super::cpu::seconds;
use super::run::{scene, tell_refusals};
use ballistic_gel::output::{DriverInterface, FinalState, RunRecorder};
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

/// Times at which the nose is compared, ms; Poncelet's law, fitted to the shot, has it at 16, 30, 60 and 83 mm there.
const TIMES: [f64; 4] = [0.1, 0.2, 0.5, 1.0];

/// How often the cavity is looked at, s.
const STEP: f64 = 1e-5;

/// Keys of a scene and what they are instead.
pub type Keys = [(&'static str, &'static str)];

/// Branches of half and of twice the modulus; and by two other powers of the rate, with the same stress at 80 000/s, the speed over the
/// radius of the BB.
const SOFT: &str = "[{ shear_modulus = 2.4e6, power_law = { stress = 640.0, exponent = 0.8 } }]";
const STIFF: &str = "[{ shear_modulus = 9.6e6, power_law = { stress = 640.0, exponent = 0.8 } }]";
const FLAT: &str = "[{ shear_modulus = 4.8e6, power_law = { stress = 1979.0, exponent = 0.7 } }]";
const STEEP: &str = "[{ shear_modulus = 4.8e6, power_law = { stress = 207.0, exponent = 0.9 } }]";

/// Runs of the shot, and what is changed in each: the mesh, the step and the wave, then the networks and their transfer, then the speed.
const RUNS: [(&str, &Keys); 27] = [
    ("scene unchanged: R/8, growth 0.1", &[]),
    ("cells of R/5", &[("mesh.size", "0.43e-3"), ("remesh.smallest", "0.2e-3")]),
    ("cells of R/12", &[("mesh.size", "0.18e-3"), ("remesh.smallest", "0.09e-3")]),
    ("growth 0.15", &[("remesh.growth", "0.15")]),
    ("growth 0.05", &[("remesh.growth", "0.05")]),
    ("R/12, growth 0.05", &[("mesh.size", "0.18e-3"), ("remesh.smallest", "0.09e-3"), ("remesh.growth", "0.05")]),
    ("half the step", &[("integrator.cfl", "0.4")]),
    ("wave of 1500 m/s", &[("gel.bulk_modulus", "2317.5e6")]),
    ("sealed, nothing in the cavity", &[("load", "[{ on = \"z_max\", pressure = -101325.0, depth = 4.37e-3 }]")]),
    ("elastic network of 0.06 MPa", &[("gel.shear_modulus", "0.06e6")]),
    ("elastic network of 0.12 MPa", &[("gel.shear_modulus", "0.12e6")]),
    ("no damage", &[("gel.damage.critical_stretch", "1e3")]),
    ("damage from a stretch of 2.5 on", &[("gel.damage.critical_stretch", "2.5")]),
    ("damage from a stretch of 4 on", &[("gel.damage.critical_stretch", "4.0")]),
    ("damage in 5 µs", &[("gel.damage.delay", "5e-6")]),
    ("damage in 20 µs", &[("gel.damage.delay", "20e-6")]),
    ("branch of 2.4 MPa", &[("gel.branches", SOFT)]),
    ("branch of 9.6 MPa", &[("gel.branches", STIFF)]),
    ("exponent 0.7", &[("gel.branches", FLAT)]),
    ("exponent 0.9", &[("gel.branches", STEEP)]),
    ("averages without the stored energy", &[("remesh.elastic_average", "normalised-mean")]),
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
        "| |{} depth, mm | at, ms | cavity, mm | at, ms | at the end, mm | meshes | refused | elements | M updates | dashpots, % of E₀ | bulk viscosity | damage | remesh | kinetic taken | integration | bias | eroded | closure | CPU s | remeshing, s |",
        times.concat()
    );
    println!(
        "|---|{}---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
        "---|".repeat(TIMES.len())
    );
}

/// A run of a scene with some of its keys replaced.
pub fn row(shot: &str, name: &str, keys: &Keys) {
    let keys: Vec<(&str, String)> = keys.iter().map(|(key, value)| (*key, (*value).to_owned())).collect();
    let scene = scene(shot, &keys);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (seen_at, cavity, cpu) = fly(name, &scene, &mut simulation);
    let seen: Observation = simulation.observe();
    let (depth, at) = seen.projectile().contact.peak_depth;
    let renewals = simulation.renewals();
    let kinetic: f64 = renewals.iter().map(|renewal| renewal.kinetic[1] - renewal.kinetic[0]).sum();
    let energy = &seen.energy;
    let parts = [
        energy.viscous,
        energy.bulk_viscous,
        energy.damage,
        energy.remesh,
        kinetic,
        energy.integration,
        energy.contact_bias,
        energy.eroded,
    ]
    .map(|part| format!(" {:+.2} |", 100.0 * part / energy.initial));
    tell_refusals(name, &simulation);
    println!(
        "| {name} |{seen_at} {:.2} | {:.3} |{cavity} {} | {} | {} | {:.1} |{} {:.0e} | {cpu:.1} | {:.1} |",
        1e3 * depth,
        1e3 * at,
        seen.cost.remeshes,
        simulation.refusals().len(),
        seen.cost.elements,
        1e-6 * seen.cost.element_updates,
        parts.concat(),
        energy.energy_error,
        renewals.iter().map(|renewal| renewal.seconds).sum::<f64>(),
    );
}

/// A shot to its end: where the nose was at the times, the cavity, and the CPU time of the steps, s.
fn fly(name: &str, scene: &Scene, simulation: &mut Simulation) -> (String, String, f64) {
    let folder = tempfile::tempdir().expect("a folder of its own");
    let mut recorder = RunRecorder::create(folder.path(), scene, DriverInterface::Direct, 1).expect("a run's folder");
    recorder.record(simulation).expect("a row of history");
    let inputs = simulation.inputs();
    let (mut seen_at, mut cpu) = (vec![], 0.0);
    for step in 1..=(scene.scene.end_time / STEP).round() as u32 {
        let begun = seconds();
        let end = simulation.step(&inputs, STEP * f64::from(step));
        cpu += seconds() - begun;
        recorder.record(simulation).expect("a row of history");
        if TIMES.iter().any(|time| (1e-3 * time / STEP).round() as u32 == step) {
            seen_at.push(format!(" {:.2} |", 1e3 * simulation.depth(0)));
        }
        if let Err(why) = end {
            eprintln!("{name}: {why}");
            break;
        }
    }
    seen_at.resize(TIMES.len(), " – |".to_owned());
    let (observation, frame) = (&simulation.observe(), &simulation.frame());
    let ending = FinalState { observation, frame, digest: simulation.digest(), failure: None };
    let seen = recorder.conclude(&ending).expect("a summary");
    let cavity = [seen.greatest_cavity_diameter, seen.time_of_greatest_cavity, seen.final_cavity_diameter]
        .map(|figure| format!(" {:.2} |", 1e3 * figure.unwrap_or(f64::NAN)));
    (seen_at.concat(), cavity.concat(), cpu)
}
