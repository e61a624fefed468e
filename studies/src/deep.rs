//! The ball of `sphere-deep` in space, its mesh remade on the way, by mesh size; the same in a quarter of the block, and about an axis.

use super::cpu::seconds;
use super::remesh::pace;
use super::run::{scene, tell_refusals};
use ballistic_gel::integrator::StepError;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::time::Instant;

/// Cells beneath the ball, m: R/1.6, R/2, R/2.5 and R/4.
const SIZES: [f64; 4] = [6.25e-3, 5e-3, 4e-3, 2.5e-3];
/// Cells beneath the ball in a quarter of the block, m: R/1.6 to R/6.3.
const QUARTERS: [f64; 6] = [6.25e-3, 5e-3, 4e-3, 3.2e-3, 2.5e-3, 1.6e-3];
/// The same about an axis, in a cylinder: R/2, R/4 and R/8.
const ABOUT_AN_AXIS: [f64; 3] = [5e-3, 2.5e-3, 1.25e-3];
/// Speeds about an axis on the finer two of these, m/s.
const SPEEDS: [f64; 16] =
    [17.0, 18.0, 18.5, 19.0, 19.5, 19.8, 19.9, 20.0, 20.1, 20.2, 20.5, 21.0, 21.5, 22.0, 23.0, 24.0];
/// Of the worst element, that end a mesh.
const QUALITIES: [f64; 5] = [0.3, 0.2, 0.1, 0.05, 0.02];
/// Times at which the runs are compared, ms.
const TIMES: [f64; 6] = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0];

/// Depth and speed at these times and at the end, and what the books say.
pub fn study() {
    head();
    for size in SIZES {
        row((size, ""), &[]);
    }
    for size in QUARTERS {
        row((size, ", a quarter"), &[("gel.symmetry", "quarter".to_owned())]);
    }
    for size in ABOUT_AN_AXIS {
        row((size, ", about an axis"), &round());
    }
}

/// The same in the whole block by the quality at which a mesh is worn.
pub fn worn() {
    head();
    for size in &SIZES[..2] {
        for quality in QUALITIES {
            row((*size, &format!(", {quality}")), &[("remesh.quality", quality.to_string())]);
        }
    }
}

fn head() {
    let times: Vec<String> = TIMES.iter().map(|t| format!(" {t} ms: mm, m/s |")).collect();
    let times = times.concat();
    println!(
        "| cells, mm |{times} depth, mm | at, ms | end | meshes | elements | kept, % | attempts | least J | remesh, % of E₀ | bias, % | closure | momentum | mass | remeshing, % of the time | 1000 elements/s | CPU s |"
    );
    println!("|---|{}---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|", "---|".repeat(TIMES.len()));
}

/// What puts the ball on the axis of a cylinder.
pub fn round() -> [(&'static str, String); 3] {
    [
        ("scene.dimension", "axisymmetric".to_owned()),
        ("gel.shape", "{ cylinder = { radius = 0.07, height = 0.12 } }".to_owned()),
        ("mesh.tree", "{ coarsest = 4, core = 0.025, slope = 0.2 }".to_owned()),
    ]
}

/// Where a run stopped, if it did.
pub fn told(end: Result<(), StepError>) -> String {
    end.map_or_else(|failure| format!("stops at {:.2} ms", 1e3 * failure.time()), |()| "–".to_owned())
}

/// About an axis, by speed: whether the run reaches its end, and what it took.
pub fn speeds() {
    println!(
        "| m/s | cells, mm | depth, mm | at, ms | end | meshes | least J | eroded, % of the mass | eroded, % of E₀ | remesh, % | integration, % | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in SPEEDS {
        ABOUT_AN_AXIS[1..].iter().for_each(|size| speed_row(speed, *size));
    }
}

fn speed_row(speed: f64, size: f64) {
    let keys = [
        ("mesh.size", size.to_string()),
        ("remesh.smallest", (0.8 * size).to_string()),
        ("projectile.velocity", format!("[0.0, 0.0, {}]", -speed)),
    ];
    let scene = scene("sphere-deep", &[&round()[..], &keys].concat());
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let mass = simulation.frame().mass;
    let end = simulation.step(&simulation.inputs(), scene.scene.end_time);
    let end = told(end);
    let (seen, cpu) = (simulation.observe(), seconds() - begun);
    let (depth, at) = seen.projectile().contact.peak_depth;
    let part = |energy: f64| 100.0 * energy / seen.energy.initial;
    println!(
        "| {speed} | {} | {:.1} | {:.2} | {end} | {} | {:.3} | {:.2} | {:+.1} | {:+.1} | {:+.1} | {cpu:.0} |",
        1e3 * size,
        1e3 * depth,
        1e3 * at,
        seen.cost.remeshes,
        seen.cost.min_jacobian,
        100.0 * seen.cost.eroded_mass / mass,
        part(seen.energy.eroded),
        part(seen.energy.remesh),
        part(seen.energy.integration),
    );
}

/// One run with cells of this size and these keys.
fn row((size, name): (f64, &str), keys: &[(&str, String)]) {
    let sizes = [("mesh.size", size.to_string()), ("remesh.smallest", (0.8 * size).to_string())];
    let scene = scene("sphere-deep", &[keys, &sizes].concat());
    let (begun, clock) = (seconds(), Instant::now());
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (inputs, mass) = (simulation.inputs(), simulation.frame().mass);
    let (mut seen_at, mut end) = (vec![], Ok(()));
    for time in TIMES.iter().map(|t| 1e-3 * t) {
        end = end.and_then(|()| simulation.step(&inputs, time));
        let seen = simulation.observe();
        let place = (1e3 * seen.projectile().depth, seen.projectile().kinematics.velocity.z);
        seen_at.push(if end.is_ok() { format!(" {:.2}, {:+.2} |", place.0, place.1) } else { " – |".to_owned() });
    }
    let end = end.and_then(|()| simulation.step(&inputs, scene.scene.end_time));
    let seen_at = seen_at.concat();
    let (cpu, wall) = (seconds() - begun, clock.elapsed().as_secs_f64());
    let seen = simulation.observe();
    let (depth, at) = seen.projectile().contact.peak_depth;
    let end = told(end);
    let remeshings = simulation.remeshings();
    let n = remeshings.len().max(1) as f64;
    // The sum of nothing is −0.
    let kept = remeshings.iter().map(|remeshing| remeshing.unchanged).sum::<f64>() / n + 0.0;
    let attempts: usize = remeshings.iter().map(|remeshing| remeshing.attempt).sum();
    tell_refusals(&format!("{} mm{name}", 1e3 * size), &simulation);
    println!(
        "| {}{name} |{seen_at} {:.2} | {:.2} | {end} | {} | {} | {:.0} | {attempts} | {:.3} | {:+.2} | {:+.2} | {:.0e} | {:.0e} | {:.0e} | {} | {cpu:.0} |",
        1e3 * size,
        1e3 * depth,
        1e3 * at,
        seen.cost.remeshes,
        seen.cost.elements,
        100.0 * kept,
        seen.cost.min_jacobian,
        100.0 * seen.energy.remesh / seen.energy.initial,
        100.0 * seen.energy.contact_bias / seen.energy.initial,
        seen.energy.energy_error,
        seen.momentum_error,
        ((simulation.frame().mass + seen.cost.eroded_mass) / mass - 1.0).abs(),
        pace(remeshings, wall),
    );
}
