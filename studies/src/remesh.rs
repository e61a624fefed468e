use super::cpu::seconds;
use super::run::scene;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, RemeshRecord, Simulation};
use std::time::Instant;

/// A fixed mesh, and meshes that are remade.
const MESHES: [(&str, &[(&str, &str)]); 2] = [("fixed", &[]), ("remeshed", &[("remesh.quality", "0.3")])];
const SPEEDS: [f64; 5] = [10.0, 20.0, 30.0, 36.0, 42.0];
const SIZES: [f64; 3] = [2.5e-3, 1.25e-3, 0.625e-3];

/// The disc of `ball-square` by speed and by mesh size, on a fixed mesh and on meshes that are remade.
pub fn study() {
    println!(
        "| v, m/s | cells, mm | mesh | end, ms | meshes | elements | depth, mm | v at the end, m/s | least J | remesh, % of E₀ | defect, % | closure | momentum | mass | CPU s | remeshing, % of the time | 1000 elements/s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in SPEEDS {
        for mesh in &MESHES {
            row(speed, SIZES[1], mesh);
        }
    }
    for size in SIZES {
        row(36.0, size, &MESHES[1]);
    }
    methods();
    steps();
}

/// A run: its scene, when it stopped if it did, CPU time and time of the clock, s.
struct Ride {
    scene: Scene,
    simulation: Simulation,
    end: String,
    cpu: f64,
    wall: f64,
}

/// The disc at this speed on cells of this size.
fn ridden(speed: f64, size: f64, more: &[(&str, &str)]) -> Ride {
    let own = [("projectile.velocity", format!("[0, 0, -{speed}]")), ("mesh.size", size.to_string())];
    let more = more.iter().map(|(key, value)| (*key, (*value).to_owned()));
    let keys: Vec<(&str, String)> = own.into_iter().chain(more).collect();
    let scene = scene("ball-square", &keys);
    let (begun, clock) = (seconds(), Instant::now());
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    let end = simulation.step(&inputs, scene.scene.end_time);
    let (cpu, wall) = (seconds() - begun, clock.elapsed().as_secs_f64());
    let end = end.map_or_else(|failure| format!("stops at {:.2}", 1e3 * failure.time()), |()| "–".to_owned());
    Ride { scene, simulation, end, cpu, wall }
}

/// The part of the time, %, that remeshings took, and the elements of their new meshes, thousands per second of them: from the old mesh to
/// the new engine, refused attempts included.
pub(super) fn pace(made: &[RemeshRecord], wall: f64) -> String {
    if made.is_empty() {
        return "0 | –".to_owned();
    }
    let remeshing: f64 = made.iter().map(|remeshing| remeshing.seconds).sum();
    let elements: usize = made.iter().map(|remeshing| remeshing.elements).sum();
    format!("{:.0} | {:.0}", 100.0 * remeshing / wall, 1e-3 * elements as f64 / remeshing)
}

fn row(speed: f64, size: f64, (mesh, more): &(&str, &[(&str, &str)])) {
    let Ride { scene, simulation, end, cpu, wall } = ridden(speed, size, more);
    let seen = simulation.observe();
    let mass = 0.1 * 0.1 * scene.gel.density;
    println!(
        "| {speed} | {} | {mesh} | {end} | {} | {} | {:.2} | {:+.2} | {:.3} | {:+.2} | {:.2} | {:.0e} | {:.0e} | {:.0e} | {cpu:.1} | {} |",
        1e3 * size,
        seen.cost.remeshes,
        seen.cost.elements,
        1e3 * seen.projectile().contact.peak_depth.0,
        seen.projectile().kinematics.velocity.z,
        seen.cost.min_jacobian,
        100.0 * seen.energy.remesh / seen.energy.initial,
        100.0 * seen.energy.energy_defect,
        seen.energy.energy_error,
        seen.momentum_error,
        (simulation.frame().mass / mass - 1.0).abs(),
        pace(simulation.remeshings(), wall),
    );
}

type Keys = &'static [(&'static str, &'static str)];

/// Four remeshings at fixed intervals, whatever becomes of the mesh and without adaptivity (figure 7 of the paper), and meshes that
/// are remade where they are distorted: by both methods.
const METHODS: [(&str, Keys); 5] = [
    ("fixed", &[]),
    ("four times, local", &[FOUR, UNIFORM, NEVER[0], NEVER[1], ("remesh.method", "local")]),
    ("four times, immersed", &[FOUR, UNIFORM, NEVER[0], NEVER[1], ("remesh.method", "immersed")]),
    ("distorted, local", &[("remesh.method", "local")]),
    ("distorted, immersed", &[("remesh.method", "immersed")]),
];
const FOUR: (&str, &str) = ("remesh.times", "[0.4e-3, 0.8e-3, 1.2e-3, 1.6e-3]");
const UNIFORM: (&str, &str) = ("remesh.adaptive", "false");
/// Only an element that is turned inside out wears such a mesh out.
const NEVER: [(&str, &str); 2] = [("remesh.quality", "0"), ("remesh.min_volume_ratio", "0")];

/// Costs and changes by each method of remeshing: sums of absolute values over all remeshings, before any correction.
fn methods() {
    println!(
        "\n| v, m/s | cells, mm | mesh | end, ms | elements | depth, mm | v at the end, m/s | least J | remeshings | attempts | worst new element | Σ kinetic, % of E₀ | Σ momentum, of P₀ | Σ mass | Σ area, % | remesh, % of E₀ | defect, % | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in [20.0, 30.0, 36.0] {
        for mesh in &METHODS {
            method_row(speed, SIZES[1], mesh);
        }
    }
    for size in [SIZES[0], SIZES[2]] {
        for mesh in &METHODS[3..] {
            method_row(36.0, size, mesh);
        }
    }
}

/// Elements by their step in the middle of a run, and what the smallest steps do not cost: small elements at a surface that was cut
/// out set their own step, not everyone's.
fn steps() {
    println!(
        "\n| scene | mesh | elements | steps, ns | elements by step, each bar twice the last, % | updates, % of one step for all |"
    );
    println!("|---|---|---|---|---|---|");
    for (name, own) in [("ball-square", SQUARE), ("sphere-deep", DEEP)] {
        for method in ["local", "immersed"].into_iter().take(if name == "ball-square" { 2 } else { 1 }) {
            let keys: Vec<(&str, String)> =
                own.iter().chain(&[("remesh.method", method)]).map(|(k, v)| (*k, (*v).to_owned())).collect();
            step_row(&scene(name, &keys), (name, method));
        }
    }
}

const SQUARE: Keys = &[
    ("projectile.velocity", "[0, 0, -36]"),
    ("mesh.size", "1.25e-3"),
    ("scene.end_time", "1e-3"),
    ("remesh.quality", "0.3"),
];
const DEEP: Keys = &[("scene.end_time", "1.5e-3"), ("mesh.size", "4e-3"), ("remesh.smallest", "3.2e-3")];

fn step_row(scene: &Scene, (name, method): (&str, &str)) {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    simulation.step(&inputs, scene.scene.end_time).expect("a run that goes on");
    let (seen, steps) = (simulation.observe(), simulation.frame().cells.step);
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let octave = |step: &f64| (step / least).log2().round() as usize;
    let mut counts = vec![0_usize; 1 + steps.iter().map(octave).max().unwrap_or(0)];
    for step in &steps {
        counts[octave(step)] += 1;
    }
    let bars: Vec<String> = counts.iter().map(|n| format!("{:.2}", 100.0 * *n as f64 / steps.len() as f64)).collect();
    println!(
        "| {name} | {method} | {} | {:.0} to {:.0} | {} | {:.1} |",
        steps.len(),
        1e9 * least,
        1e9 * steps.iter().copied().fold(0.0, f64::max),
        bars.join(" "),
        100.0 * seen.cost.element_updates / seen.cost.synchronous_updates,
    );
}

fn method_row(speed: f64, size: f64, (mesh, more): &(&str, Keys)) {
    let Ride { scene, simulation, end, cpu, .. } = ridden(speed, size, more);
    let seen = simulation.observe();
    println!(
        "| {speed} | {} | {mesh} | {end} | {} | {:.2} | {:+.2} | {:.3} | {} | {:+.2} | {:.2} | {cpu:.1} |",
        1e3 * size,
        seen.cost.elements,
        1e3 * seen.projectile().contact.peak_depth.0,
        seen.projectile().kinematics.velocity.z,
        seen.cost.min_jacobian,
        changes(simulation.remeshings(), (seen.energy.initial, scene.projectile.mass.unwrap_or(f64::NAN) * speed)),
        100.0 * seen.energy.remesh / seen.energy.initial,
        100.0 * seen.energy.energy_defect,
    );
}

/// The columns of all remeshings: how many, in how many attempts, the worst shape, and sums of what changed, of the energy and of
/// the momentum that there was.
fn changes(made: &[RemeshRecord], (energy, momentum): (f64, f64)) -> String {
    if made.is_empty() {
        return "0 | – | – | – | – | – | –".to_owned();
    }
    let sum = |of: &dyn Fn(&RemeshRecord) -> f64| made.iter().map(|remeshing| of(remeshing).abs()).sum::<f64>();
    format!(
        "{} | {} | {:.2} | {:.2} | {:.0e} | {:.0e} | {:.4}",
        made.len(),
        made.iter().map(|remeshing| remeshing.attempt).sum::<usize>(),
        made.iter().map(|remeshing| remeshing.quality.least).fold(f64::INFINITY, f64::min),
        100.0 * sum(&|r| r.kinetic[1] - r.kinetic[0]) / energy,
        sum(&|r| r.momentum) / momentum,
        sum(&|r| r.mass),
        100.0 * sum(&|r| r.quality.change),
    )
}
