use super::run::scene;
use ballistic_gel::scene::{BodyShape, Scene};
use ballistic_gel::simulation::{CouplingMode, SensorReport, ShapeMotion, Simulation, StepInputs};
use std::io::Write as _;
use std::time::Instant;

/// Between two looks at the sensors, s.
const LOOK: f64 = 2e-6;
/// Looks of the shorter mean, 20 µs: about what a transducer in gel resolves, and long beside the steps of the elements.
const MEAN: usize = 10;
/// A bulge that is given over time: its height in the end, m, and when it is fastest, s: h = H (1 − (1 + t/τ) e^(−t/τ)), ḣ ≤ H/(eτ), 55 m/s.
const BULGE: (f64, f64) = (30e-3, 0.2e-3);
/// Its base radius at the start, m; it grows as the height does.
const BASE: f64 = 20e-3;

/// Who dents the gel.
#[derive(Clone, Copy, PartialEq)]
enum Dent {
    Cap,
    Bulge,
    Baton,
}

/// What a run has shown.
struct Found {
    /// Time reached, s.
    end: f64,
    /// Greatest depth of the body, m, and when, s.
    depth: (f64, f64),
    /// VC_max of the entry surface on the axis and of the body, m/s.
    criteria: [f64; 2],
    /// At each sensor below the surface: greatest pressure, the same of means, Pa, and greatest rise, Pa/s.
    pressures: Vec<[f64; 3]>,
    /// Given to the gel, J.
    work: f64,
    updates: f64,
    error: f64,
    seconds: f64,
}

/// Pressures, dents and viscous criteria of `backface-dent`, of a bulge that is given over time and of a baton.
pub fn study() {
    let cases = [
        (Dent::Cap, 4e-3),
        (Dent::Cap, 3e-3),
        (Dent::Cap, 2e-3),
        (Dent::Bulge, 3e-3),
        (Dent::Bulge, 2e-3),
        (Dent::Baton, 3e-3),
    ];
    println!(
        "| body | h, mm | end, ms | depth, mm | at, ms | VC gel, m/s | VC body, m/s | p 50 mm, MPa | mean, 20 µs | dp/dt, MPa/µs | p 100 mm, MPa | mean, 20 µs | dp/dt, MPa/µs | work, J | updates | closure | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    std::thread::scope(|scope| {
        let runs: Vec<_> = cases.iter().map(|case| (case, scope.spawn(|| found(*case)))).collect();
        for ((who, size), run) in runs {
            row((*who, *size), &run.join().expect("a run"));
        }
    });
}

fn row((who, size): (Dent, f64), found: &Found) {
    let name = match who {
        Dent::Cap => "cap of 68 g, 51.3 m/s",
        Dent::Bulge => "bulge to 30 mm",
        Dent::Baton => "baton of 140 g, 20 m/s",
    };
    let pressures =
        |[peak, mean, rate]: &[f64; 3]| format!("{:.3} | {:.3} | {:.3}", 1e-6 * peak, 1e-6 * mean, 1e-12 * rate);
    let pressures: Vec<String> = found.pressures.iter().map(pressures).collect();
    let (depth, at) = found.depth;
    println!(
        "| {name} | {} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {} | {:.1} | {:.1e} | {:.0e} | {:.0} |",
        1e3 * size,
        1e3 * found.end,
        1e3 * depth,
        1e3 * at,
        found.criteria[0],
        found.criteria[1],
        pressures.join(" | "),
        found.work,
        found.updates,
        found.error,
        found.seconds,
    );
    std::io::stdout().flush().expect("a terminal");
}

/// The scene with another body.
fn dented((who, size): (Dent, f64)) -> Scene {
    let mut scene = scene("backface-dent", &[("mesh.size", format!("{size:?}"))]);
    let body = &mut scene.projectile;
    match who {
        Dent::Cap => {}
        Dent::Bulge => {
            body.shape = BodyShape::Dome { height: 0.0, radius: BASE };
            (body.fixed, body.mass, body.inertia) = (true, None, None);
            (body.position, body.velocity) = ([0.0; 3], [0.0; 3]);
        }
        Dent::Baton => {
            body.shape = BodyShape::Cylinder { radius: 18.5e-3, length: 0.1, edge_radius: 5e-3 };
            (body.mass, body.inertia) = (Some(0.140), None);
            (body.position, body.velocity) = ([0.0, 0.0, 50e-3], [0.0, 0.0, -20.0]);
        }
    }
    scene
}

/// Height of the bulge, m.
fn height(time: f64) -> f64 {
    let (height, fastest) = BULGE;
    let x = time / fastest;
    height * (1.0 - (1.0 + x) * (-x).exp())
}

/// The inputs of a step: mean rates, so that the bulge moves without a gap.
fn moved(who: Dent, simulation: &Simulation) -> Vec<StepInputs> {
    let mut inputs = simulation.inputs();
    if let (Dent::Bulge, Some(ShapeMotion::Bulge(bulge))) = (who, &mut inputs[0].shape_motion) {
        let (now, then) = (height(simulation.time()), height(simulation.time() + LOOK));
        bulge.size = [now, BASE + now].into();
        bulge.rate = [(then - now) / LOOK; 2].into();
    }
    inputs
}

fn found(case: (Dent, f64)) -> Found {
    let (scene, begun) = (dented(case), Instant::now());
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let (mut depths, mut seen) = (vec![simulation.depth(0)], vec![simulation.sensors()]);
    for k in 1..=(scene.scene.end_time / LOOK).round() as u32 {
        let inputs = moved(case.0, &simulation);
        if simulation.step(&inputs, f64::from(k) * LOOK).is_err() {
            break;
        }
        depths.push(simulation.depth(0));
        seen.push(simulation.sensors());
    }
    let (deepest, depth) =
        depths.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).expect("it was looked at");
    let books = simulation.books().energy;
    Found {
        end: simulation.time(),
        depth: (depth, deepest as f64 * LOOK),
        criteria: criteria(&depths, &seen),
        pressures: (1..seen[0].len()).map(|i| pressures(&seen, i)).collect(),
        work: books.initial + books.external - books.projectile,
        updates: simulation.updates(),
        error: books.energy_error,
        seconds: begun.elapsed().as_secs_f64(),
    }
}

/// max V C of the entry surface and of the body: C is the depth as a part of the height of the gel, 0.2 m.
fn criteria(depths: &[f64], seen: &[Vec<SensorReport>]) -> [f64; 2] {
    let gel = seen.iter().map(|sensors| -sensors[0].displacement.z * (-sensors[0].velocity.z).max(0.0));
    let body = depths.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]) * ((pair[1] - pair[0]) / LOOK).max(0.0));
    [gel.fold(0.0, f64::max) / 0.2, body.fold(0.0, f64::max) / 0.2]
}

/// Greatest pressure of a sensor, of its means and of its rise.
fn pressures(seen: &[Vec<SensorReport>], sensor: usize) -> [f64; 3] {
    let all: Vec<f64> = seen.iter().map(|sensors| sensors[sensor].pressure).collect();
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    [
        most(&mut all.iter().copied()),
        most(&mut all.windows(MEAN).map(|window| window.iter().sum::<f64>() / MEAN as f64)),
        most(&mut all.windows(2).map(|pair| (pair[1] - pair[0]) / LOOK)),
    ]
}
