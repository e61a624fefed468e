//! The ball of `sphere-deep` about an axis by speed and mesh size: whether an elastic gel gives back what it has stored, and how much is remade.

use super::run::scene;
use ballistic_gel::integrator::StepError;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Speeds, m/s; each stands for five runs with these differences.
const SPEEDS: [f64; 4] = [5.0, 13.0, 16.0, 20.0];
const DIFFERENCES: [f64; 5] = [-0.02, -0.01, 0.0, 0.01, 0.02];
/// Cells beneath the ball, m.
const SIZES: [f64; 3] = [2.5e-3, 1.25e-3, 0.625e-3];
/// Interval at which the speed is looked at, s.
const STEP: f64 = 50e-6;
/// Slow ball: mass, kg, and speed, m/s.
const SLOW: [f64; 2] = [330.0, 1.0];
/// Depths at which its force is told, m, and the path that the force is the mean of, m.
const DEPTHS: [f64; 6] = [0.010, 0.020, 0.032, 0.040, 0.048, 0.056];
const PATH: f64 = 4e-3;
/// A mesh that ends only by an inverted element.
const FIXED: [(&str, &str); 2] = [("remesh.quality", "0"), ("remesh.min_volume_ratio", "0")];

/// Depth and rebound by speed and mesh size, and the force on a slow ball.
pub fn study() {
    println!("Means of five runs at v and v ± 0.01, ± 0.02 m/s, with their spread.\n");
    println!(
        "| m/s | cells, mm | mesh | depth, mm | rebound, m/s | ends | remeshings | remade elements | remesh, % of E₀ | its sum of sizes, % | remeshing, % of the time | least J |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in SPEEDS {
        for size in SIZES {
            for is_fixed in [true, false] {
                speed_row(speed, size, is_fixed);
            }
        }
    }
    println!("\nA ball of {} kg at {} m/s: force, means over {} mm\n", SLOW[0], SLOW[1], 1e3 * PATH);
    let depths: Vec<String> = DEPTHS.iter().map(|depth| format!(" {} mm: N |", 1e3 * depth)).collect();
    println!("| cells, mm | mesh |{} end | fall of the stored energy, % of its greatest |", depths.concat());
    println!("|---|---|{}---|---|", "---|".repeat(DEPTHS.len()));
    for size in SIZES {
        for is_fixed in [true, false] {
            slow_row(size, is_fixed);
        }
    }
}

/// Keys that put the ball on the axis of a cylinder.
fn round() -> [(&'static str, String); 3] {
    [
        ("scene.dimension", "axisymmetric".to_owned()),
        ("gel.shape", "{ cylinder = { radius = 0.07, height = 0.12 } }".to_owned()),
        ("mesh.tree", "{ coarsest = 4, core = 0.025, slope = 0.2 }".to_owned()),
    ]
}

/// Text of the time at which a run stopped; a dash if it did not.
fn told(end: Result<(), StepError>) -> String {
    end.map_or_else(|failure| format!("stops at {:.2} ms", 1e3 * failure.time()), |()| "–".to_owned())
}

/// The scene about an axis with these cells.
fn about_an_axis(size: f64, is_fixed: bool, more: &[(&str, String)]) -> Scene {
    let sizes = [("mesh.size", size.to_string()), ("remesh.smallest", (0.8 * size).to_string())];
    let fixed = FIXED.iter().filter(|_| is_fixed).map(|(key, value)| (*key, (*value).to_owned()));
    scene("sphere-deep", &[&round()[..], &sizes, &fixed.collect::<Vec<_>>(), more].concat())
}

/// A finished shot.
struct Shot {
    depth: f64,
    rebound: f64,
    end: String,
    /// Remeshings, remade elements, net and gross energy by remeshing, % of E₀, its share of the time, %, least J.
    figures: [f64; 6],
}

fn shot(scene: &Scene) -> Shot {
    let begun = std::time::Instant::now();
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (inputs, mut rebound, mut end) = (simulation.inputs(), 0.0_f64, Ok(()));
    for step in 1..=(scene.scene.end_time / STEP).round() as u32 {
        end = simulation.step(&inputs, STEP * f64::from(step));
        if end.is_err() {
            break;
        }
        rebound = rebound.max(simulation.kinematics(0).velocity.z);
    }
    let (wall, seen, remeshings) = (begun.elapsed().as_secs_f64(), simulation.observe(), simulation.remeshings());
    let percent = |energy: f64| 100.0 * energy / seen.energy.initial;
    let remade =
        remeshings.iter().map(|remeshing| remeshing.elements as f64 * (1.0 - remeshing.unchanged)).sum::<f64>();
    let gross = remeshings.iter().map(|remeshing| remeshing.energy.abs()).sum::<f64>();
    let seconds = remeshings.iter().map(|remeshing| remeshing.seconds).sum::<f64>();
    let n = remeshings.len() as f64;
    let figures =
        [n, remade, percent(seen.energy.remesh_net()), percent(gross), 100.0 * seconds / wall, seen.cost.min_jacobian];
    Shot { depth: seen.projectile().contact.peak_depth.0, rebound, end: told(end), figures }
}

fn speed_row(speed: f64, size: f64, is_fixed: bool) {
    let fly = |difference: &f64| {
        let velocity = format!("[0.0, 0.0, {}]", -(speed + difference));
        shot(&about_an_axis(size, is_fixed, &[("projectile.velocity", velocity)]))
    };
    let shots: Vec<Shot> = DIFFERENCES.iter().map(fly).collect();
    let spread = |of: &dyn Fn(&Shot) -> f64| {
        let values: Vec<f64> = shots.iter().map(of).collect();
        let [least, most] =
            [values.iter().copied().fold(f64::MAX, f64::min), values.iter().copied().fold(f64::MIN, f64::max)];
        format!("{:.2} ± {:.2}", values.iter().sum::<f64>() / values.len() as f64, 0.5 * (most - least))
    };
    let mean = |i: usize| shots.iter().map(|shot| shot.figures[i]).sum::<f64>() / shots.len() as f64 + 0.0;
    let mut ends: Vec<&str> = shots.iter().map(|shot| shot.end.as_str()).filter(|end| *end != "–").collect();
    ends.sort_unstable();
    println!(
        "| {speed} | {} | {} | {} | {} | {} | {:.0} | {:.0} | {:+.2} | {:.2} | {:.0} | {:.3} |",
        1e3 * size,
        if is_fixed { "fixed" } else { "remeshed" },
        spread(&|shot| 1e3 * shot.depth),
        spread(&|shot| shot.rebound),
        if ends.is_empty() { "all".to_owned() } else { format!("{} of 5, {}", 5 - ends.len(), ends[0]) },
        mean(0),
        mean(1),
        mean(2),
        mean(3),
        mean(4),
        shots.iter().map(|shot| shot.figures[5]).fold(f64::MAX, f64::min),
    );
}

fn slow_row(size: f64, is_fixed: bool) {
    let keys = [
        ("projectile.mass", SLOW[0].to_string()),
        ("projectile.velocity", format!("[0.0, 0.0, {}]", -SLOW[1])),
        ("scene.end_time", "60e-3".to_owned()),
    ];
    let scene = about_an_axis(size, is_fixed, &keys);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (inputs, mut end) = (simulation.inputs(), Ok(()));
    let (mut way, mut most, mut fall) = (vec![], 0.0_f64, 0.0_f64);
    for step in 1..=(scene.scene.end_time / STEP).round() as u32 {
        end = simulation.step(&inputs, STEP * f64::from(step));
        if end.is_err() {
            break;
        }
        way.push([simulation.depth(0), simulation.time(), simulation.kinematics(0).velocity.z]);
        let stored = simulation.books().energy.elastic;
        most = most.max(stored);
        fall = fall.max(most - stored);
    }
    let force = |depth: f64| {
        let at = |depth: f64| way.iter().find(|[z, ..]| *z >= depth);
        let (Some([_, from, before]), Some([_, to, after])) = (at(depth - 0.5 * PATH), at(depth + 0.5 * PATH)) else {
            return " – |".to_owned();
        };
        format!(" {:.1} |", SLOW[0] * (after - before) / (to - from))
    };
    let forces: String = DEPTHS.iter().map(|depth| force(*depth)).collect();
    println!(
        "| {} | {} |{forces} {} | {:.1} |",
        1e3 * size,
        if is_fixed { "fixed" } else { "remeshed" },
        told(end),
        100.0 * fall / most
    );
}
