use super::limits;
use super::rest;
use super::run::{Run, run};
use super::shot::{Space, shot};
use super::touch::Touch;
use ballistic_gel::scene::{self, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::io::Write as _;

/// Mass of the ball over that of the node that it meets first.
const RATIOS: [f64; 9] = [1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6];
/// Speeds, m/s, and durations, s.
const SPEEDS: [(f64, f64); 8] =
    [(0.01, 0.06), (0.1, 0.04), (1.0, 0.02), (10.0, 0.01), (30.0, 0.01), (50.0, 0.01), (100.0, 0.01), (300.0, 0.01)];

/// The table of extremes, then masses and speeds far from the ordinary, a body at rest on the gel, a body inside it.
pub fn study() {
    let cases = [&limits::QUICK[..], &limits::LONG[..]].concat();
    let missed = limits::table(&cases);
    println!("\n{} rows missed what was expected.\n", missed.len());
    masses();
    speeds();
    rest::study();
    inside();
}

/// A ball above a node.
fn ball(speed: f64, end: f64, mass: f64) -> Scene {
    let keys = [
        ("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed)),
        ("projectile.mass", format!("{mass:e}")),
        ("scene.end_time", format!("{end}")),
        ("output.frames", "1".to_owned()),
    ];
    shot((Space::Spatial, "sphere"), [0.0, 0.0], &keys)
}

fn masses() {
    const SPEED: f64 = 0.5;
    const END: f64 = 0.01;
    let touch = Touch::of(&ball(SPEED, END, 0.033));
    let node = touch.whole.nodes[touch.struck()[0]];
    let heavy = ball(SPEED, END, 1.0);
    let mut prescribed = Simulation::new(&heavy, CouplingMode::Prescribed, 0).expect("a scene that can be built");
    let inputs = prescribed.inputs();
    prescribed.step(&inputs, END).expect("a slow push");
    let limit = prescribed.observe().projectile().contact.total_impulse.z;
    println!(
        "| ball/node | lost at first touch: 1/(1 + M/m) | found | J/J of an infinite mass | v at the end/v₀ | closure | defect |"
    );
    println!("|---|---|---|---|---|---|---|");
    for ratio in RATIOS {
        let scene = ball(SPEED, END, ratio * node);
        let first = Touch::of(&scene).loss;
        let Run { last, failure, .. } = run(&scene, 1, |_| {});
        assert!(failure.is_none(), "{failure:?}");
        println!(
            "| {ratio:.0e} | {:.6} | {:.6} | {:.6} | {:+.4} | {:.0e} | {:.1e} |",
            1.0 / (1.0 + ratio),
            first / last.energy.initial,
            last.projectile().contact.total_impulse.z / limit,
            -last.projectile().kinematics.velocity.z / SPEED,
            last.energy.energy_error,
            last.energy.energy_defect,
        );
        std::io::stdout().flush().expect("a terminal");
    }
    println!();
}

fn speeds() {
    println!("| v, m/s | depth, mm | node | least J | v at the end/v₀ | closure | defect | end |");
    println!("|---|---|---|---|---|---|---|---|");
    for (speed, end) in SPEEDS {
        let Run { last, failure, .. } = run(&ball(speed, end, 0.033), 1, |_| {});
        println!(
            "| {speed} | {:.3} | {:.3} | {:.2} | {:+.3} | {:.0e} | {:.1e} | {} |",
            1e3 * last.projectile().contact.peak_depth.0,
            last.projectile().contact.deepest_penetration,
            last.cost.min_jacobian,
            -last.projectile().kinematics.velocity.z / speed,
            last.energy.energy_error,
            last.energy.energy_defect,
            failure.unwrap_or_default().split_inclusive(" s:").next().unwrap_or_default(),
        );
        std::io::stdout().flush().expect("a terminal");
    }
    println!();
}

fn inside() {
    let change = "projectile.position=[0.0, 0.0, 0.008]".parse().expect("a change is key=value");
    let text = scene::resolve(scene::builtin("sphere-block").expect("it is built in"), &[change]).expect("it is TOML");
    let error = scene::read(&text).expect_err("a ball in the gel is refused");
    println!("A ball that starts 2 mm deep: `{error}`.");
}
