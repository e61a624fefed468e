use super::cpu::seconds;
use super::run::scene;
use ballistic_gel::simulation::{CouplingMode, Observation, RemeshRecord, Simulation};

/// Remeshings, at equal intervals.
const REMESHINGS: u32 = 1000;
/// Of the disc, m/s: a fixed mesh bears it.
const SPEED: f64 = 10.0;
/// Cells, m.
const SIZE: f64 = 4e-3;
/// End of the run, s, and the meshes: a fixed one, those that keep what is good, and those that are all new.
const RIDES: [(f64, &[Option<&str>]); 2] =
    [(0.2, &[None, Some("local"), Some("immersed")]), (0.05, &[None, Some("local")])];

/// A run and what it took.
struct Ride {
    seen: Observation,
    made: Vec<RemeshRecord>,
    /// Mass at the end, kg.
    mass: f64,
    /// If it did not reach its end, when it stopped, s.
    stop: Option<f64>,
    /// CPU time, s.
    cpu: f64,
}

/// A thousand remeshings in a row on a running scene: what they take from it, and how long they take.
pub fn study() {
    println!(
        "| end, ms | mesh | stops | remeshings | least step, µs | attempts | elements | depth, mm | v at the end, m/s | kinetic, elastic, % of E₀ | worst new element | Σ kinetic, % of E₀ | remesh, % of E₀ | integration, % of E₀ | defect, % | closure | Σ mass | mass | Σ momentum, of P₀ | momentum | CPU s | remeshing, % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (end, methods) in RIDES {
        let rides: Vec<Ride> = methods.iter().map(|method| ride(*method, end)).collect();
        for (method, ride) in methods.iter().zip(&rides) {
            let name = method.unwrap_or("fixed");
            println!("| {} | {name} | {} | {} |", 1e3 * end, motion(ride), books(ride, rides[0].cpu));
        }
    }
}

fn ride(method: Option<&str>, end: f64) -> Ride {
    let mut keys = vec![
        ("projectile.velocity", format!("[0, 0, -{SPEED}]")),
        ("mesh.size", SIZE.to_string()),
        ("scene.end_time", end.to_string()),
    ];
    if let Some(method) = method {
        let time = |k: u32| (end * f64::from(k) / f64::from(REMESHINGS + 1)).to_string();
        let times: Vec<String> = (1..=REMESHINGS).map(time).collect();
        keys.extend([("remesh.method", method.to_owned()), ("remesh.times", format!("[{}]", times.join(", ")))]);
    }
    let scene = scene("ball-square", &keys);
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    let end = simulation.step(&inputs, scene.scene.end_time);
    Ride {
        cpu: seconds() - begun,
        stop: end.err().map(|failure| failure.time()),
        mass: simulation.frame().mass,
        seen: simulation.observe(),
        made: simulation.remeshings().to_vec(),
    }
}

/// The columns of what is seen.
fn motion(ride: &Ride) -> String {
    let Ride { seen, made, stop, .. } = ride;
    let share = |energy: f64| percent(energy / seen.energy.initial);
    format!(
        "{} | {} | {:.1} | {} | {} | {:.3} | {:+.3} | {}, {} | {}",
        stop.map_or_else(none, |time| format!("at {:.2}", 1e3 * time)),
        seen.cost.remeshes,
        1e6 * seen.cost.smallest_step,
        made.iter().map(|remeshing| remeshing.attempt).sum::<usize>(),
        seen.cost.elements,
        1e3 * seen.projectile().contact.peak_depth.0,
        seen.projectile().kinematics.velocity.z,
        share(seen.energy.kinetic),
        share(seen.energy.elastic),
        made.iter()
            .map(|remeshing| remeshing.quality.least)
            .reduce(f64::min)
            .map_or_else(none, |least| format!("{least:.2}")),
    )
}

/// The columns of what is kept and of the time; sums are of absolute values.
fn books(ride: &Ride, fixed: f64) -> String {
    let Ride { seen, made, mass, cpu, .. } = ride;
    let sum = |of: &dyn Fn(&RemeshRecord) -> f64| {
        made.iter().map(|remeshing| of(remeshing).abs()).fold(0.0, |sum, of| sum + of)
    };
    let [energy, momentum] = [seen.energy.initial, 2.0 * seen.energy.initial / SPEED];
    format!(
        "{} | {} | {} | {} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {cpu:.1} | {:.0}",
        percent(sum(&|r| r.kinetic[1] - r.kinetic[0]) / energy),
        percent(seen.energy.remesh_net() / energy),
        percent(seen.energy.integration / energy),
        percent(seen.energy.energy_defect),
        seen.energy.energy_error,
        sum(&|r| r.mass),
        (mass / (0.1 * 0.1 * 1030.0) - 1.0).abs(),
        sum(&|r| r.momentum) / momentum,
        seen.momentum_error,
        100.0 * (cpu - fixed) / cpu,
    )
}

fn none() -> String {
    "–".to_owned()
}

/// A share in %; of a run that has exploded its magnitude.
fn percent(share: f64) -> String {
    if share.abs() < 100.0 { format!("{:.2}", 100.0 * share) } else { format!("{:.0e}", 100.0 * share) }
}
