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

/// Strengths that do not know the pressure and stop the BB as deep: by the power 0.23 of the rate, and by 0.95.
pub const SLOW: &str =
    "{ yield_stress = 0.138e6, rate_exponent = 0.23, cap = 1.6e6, confined = { pressure = 1.0, factor = 1.0 } }";
const STEEP: &str = "{ yield_stress = 66.5e3, reference_rate = 500.0, rate_exponent = 0.95, cap = 4.2e6, confined = { pressure = 1.0, factor = 1.0 } }";

/// Runs of the shot, and what is changed in each: the mesh, the step and the wave, then the law of the strength, then the speed.
const RUNS: [(&str, &Keys); 28] = [
    ("scene unchanged: R/8, growth 0.1", &[]),
    ("cells of R/5", &[("mesh.size", "0.43e-3"), ("remesh.smallest", "0.2e-3")]),
    ("cells of R/12", &[("mesh.size", "0.18e-3"), ("remesh.smallest", "0.09e-3")]),
    ("growth 0.15", &[("remesh.growth", "0.15")]),
    ("growth 0.05", &[("remesh.growth", "0.05")]),
    ("R/12, growth 0.05", &[("mesh.size", "0.18e-3"), ("remesh.smallest", "0.09e-3"), ("remesh.growth", "0.05")]),
    ("half the step", &[("integrator.cfl", "0.4")]),
    ("wave of 1500 m/s", &[("gel.bulk_modulus", "2317.5e6")]),
    ("sealed, nothing in the cavity", &[("load", "[{ on = \"z_max\", pressure = -101325.0, depth = 4.37e-3 }]")]),
    ("confined at 0.1 MPa", &[("gel.strength.confined.pressure", "0.1e6")]),
    ("confined at 1 MPa", &[("gel.strength.confined.pressure", "1e6")]),
    ("no delay", &[("gel.strength.confined.time", "0.0")]),
    ("no delay, wave of 1500 m/s", &[("gel.strength.confined.time", "0.0"), ("gel.bulk_modulus", "2317.5e6")]),
    ("delay of 10 µs", &[("gel.strength.confined.time", "10e-6")]),
    (
        "12.5 kPa, 12 times",
        &[
            ("gel.strength.yield_stress", "12.5e3"),
            ("gel.strength.cap", "0.2e6"),
            ("gel.strength.confined.factor", "12.0"),
        ],
    ),
    (
        "7.5 kPa, 20 times",
        &[
            ("gel.strength.yield_stress", "7.5e3"),
            ("gel.strength.cap", "0.12e6"),
            ("gel.strength.confined.factor", "20.0"),
        ],
    ),
    ("softened in 0.1 ms", &[("gel.softening", "{ strain = 0.5, residual = 0.1, time = 1e-4 }")]),
    ("not confined, power 0.23", &[("gel.strength", SLOW)]),
    ("the same, softened at once", &[("gel.strength", SLOW), ("gel.softening", "{ strain = 0.3, residual = 0.05 }")]),
    (
        "softened in 50 µs",
        &[("gel.strength", SLOW), ("gel.softening", "{ strain = 0.3, residual = 0.05, time = 50e-6 }")],
    ),
    ("not confined, power 0.95", &[("gel.strength", STEEP)]),
    (
        "not confined, power 0.7",
        &[(
            "gel.strength",
            "{ yield_stress = 0.0012e6, rate_exponent = 0.7, cap = 20e6, confined = { pressure = 1.0, factor = 1.0 } }",
        )],
    ),
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
        "| |{} depth, mm | at, ms | cavity, mm | at, ms | at the end, mm | meshes | refused | elements | M updates | plastic, % of E₀ | damage | viscous | remesh | kinetic taken | integration | bias | eroded | closure | CPU s | remeshing, s |",
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
        energy.plastic,
        energy.damage,
        energy.viscous,
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
