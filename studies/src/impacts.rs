//! Offset, oblique and spinning impacts on a gel that nobody holds: everything is conserved.

use super::run::{Run, run};
use super::shot::{Space, shot};
use super::touch;
use super::whole::Whole;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::io::Write as _;

const BODIES: [&str; 4] = ["sphere", "cylinder on its rim, rounded", "cylinder", "ogive, meplat"];
/// What is special, velocity, m/s, spin, rad/s, and offset from the middle, m.
type Flight = (&'static str, [f64; 3], [f64; 3], [f64; 2]);

const MOTIONS: [Flight; 3] = [
    ("offset", [0.0, 0.0, -5.0], [0.0; 3], [0.011, -0.017]),
    ("oblique", [3.0, 1.0, -4.0], [0.0; 3], [-0.01, 0.0]),
    ("all, spinning", [3.0, 1.0, -4.0], [150.0, -80.0, 600.0], [0.003, 0.011]),
];

/// Closure of the books, and conservation without them; then single hits and the loss at first touch.
pub fn study() {
    println!("| body | impact | μ | contact, % | friction, % | P | L | P, ledger | L, ledger | E, ledger | defect |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for body in BODIES {
        for motion in MOTIONS {
            for friction in [0.0, 0.3] {
                row(body, motion, friction);
            }
        }
    }
    println!();
    touch::study();
}

fn row(body: &str, (name, velocity, spin, at): Flight, friction: f64) {
    let keys = [
        ("gel.supports.z_min", "free".to_owned()),
        ("projectile.velocity", format!("{velocity:?}")),
        ("projectile.angular_velocity", format!("{spin:?}")),
        ("contact.friction", friction.to_string()),
        ("output.frames", "1".to_owned()),
    ];
    let scene = shot((Space::Spatial, body), at, &keys);
    let begun = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let whole = Whole::of(&begun, scene.gel.density);
    let start = whole.momenta(&begun.frame());
    let mut drift: (f64, f64) = (0.0, 0.0);
    let Run { last, failure, .. } = run(&scene, 20, |now| {
        let seen = whole.momenta(&now.frame()).drift(&start);
        drift = (drift.0.max(seen.0), drift.1.max(seen.1));
    });
    if let Some(f) = failure {
        println!("{body} {name} {f}");
    }
    let energy = &last.energy;
    println!(
        "| {body} | {name} | {friction} | {:+.2} | {:+.2} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.0e} | {:.1e} |",
        100.0 * energy.contact / energy.initial,
        100.0 * energy.friction / energy.initial,
        drift.0,
        drift.1,
        last.momentum_error,
        last.angular_momentum_error,
        energy.energy_error,
        energy.energy_defect,
    );
    std::io::stdout().flush().expect("a terminal");
}
