//! A layer of skin on gelatin: its strength by one perforation threshold, and what it then says of two others.

use super::run::scene;
use ballistic_gel::scene::{LayerSpec, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::io::Write as _;

/// Strength of the layer relative to gelatin of 10 %, fitted to the threshold of the smallest pellet.
const STRENGTH: f64 = 27.0;
/// Thickness of the layer, m: assumed for the skin of a thigh.
const THICKNESS: f64 = 2e-3;
/// Density of the layer, kg/m³: assumed.
const DENSITY: f64 = 1100.0;
/// Speeds between which a threshold is sought, m/s, and how near it is told.
const SPEEDS: [f64; 2] = [5.0, 165.0];
const RESOLUTION: f64 = 2.5;

/// Projectile as a sphere, with the speed at which half of its shots perforate the skin of a human thigh.
struct Shot {
    name: &'static str,
    radius: f64,
    mass: f64,
    measured: f64,
}

/// Thresholds of DiMaio and others (1982).
const SHOTS: [Shot; 3] = [
    Shot { name: ".177 pellet, fitted", radius: 2.25e-3, mass: 0.535e-3, measured: 101.0 },
    Shot { name: ".22 pellet", radius: 2.8e-3, mass: 1.07e-3, measured: 75.0 },
    Shot { name: ".38 lead bullet", radius: 4.55e-3, mass: 7.32e-3, measured: 58.0 },
];

/// Prints the measured and the computed threshold of each projectile.
pub fn study() {
    println!(
        "| projectile | diameter, mm | mass, g | measured, m/s | computed, m/s | off, % | without skin, m/s | energy, J/cm² |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    std::thread::scope(|scope| {
        let runs =
            SHOTS.map(|shot| scope.spawn(move || (threshold(&shot, Some(STRENGTH)), threshold(&shot, None), shot)));
        for run in runs {
            let (computed, bare, Shot { name, radius, mass, measured }) = run.join().expect("a run");
            let energy = 0.5e-4 * mass * computed * computed / (std::f64::consts::PI * radius * radius);
            println!(
                "| {name} | {:.1} | {:.2} | {measured:.0} | {computed:.0} | {:+.0} | {bare:.0} | {energy:.1} |",
                2e3 * radius,
                1e3 * mass,
                100.0 * (computed / measured - 1.0),
            );
            std::io::stdout().flush().expect("a terminal");
        }
    });
}

/// Speed above which a projectile is after 8 ms more than its diameter below a layer of this strength, or of the gel, m/s, by
/// bisection.
fn threshold(shot: &Shot, strength: Option<f64>) -> f64 {
    let [mut low, mut high] = SPEEDS;
    let perforates = |speed: f64| end_depth(shot, strength, speed) > THICKNESS + 2.0 * shot.radius;
    assert!(!perforates(low) && perforates(high), "the threshold lies between {low} and {high} m/s");
    while high - low > 2.0 * RESOLUTION {
        let middle = 0.5 * (low + high);
        if perforates(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Depth of the foremost point of a projectile after 8 ms, m.
fn end_depth(shot: &Shot, strength: Option<f64>, speed: f64) -> f64 {
    let mut simulation =
        Simulation::new(&skin(shot, strength, speed), CouplingMode::Integrated, 1).expect("a scene that can be built");
    let end = 8e-3;
    for step in 1..=80 {
        let inputs = simulation.inputs();
        simulation.step(&inputs, end * f64::from(step) / 80.0).unwrap_or_else(|error| panic!("{error}"));
    }
    simulation.observe().projectile().depth
}

/// The gel of `fbi-bb` beneath the layer.
fn skin(shot: &Shot, strength: Option<f64>, speed: f64) -> Scene {
    let numbers = [("mesh.size", 0.5e-3), ("remesh.smallest", 0.25e-3), ("mesh.tree.coarsest", 8.0)];
    let cells = numbers.map(|(key, value)| (key, format!("{value}")));
    let mut scene = scene("fbi-bb", &[&cells[..], &[("mesh.tree.slope", "0.3".to_owned())]].concat());
    let constants = LayerSpec {
        name: None,
        thickness: THICKNESS,
        preset: None,
        density: Some(DENSITY),
        strength_scale: strength,
        bulk_modulus: None,
        shear_modulus: None,
    };
    scene.layer = strength.map(|_| constants).into_iter().collect();
    scene.projectile.shape = ballistic_gel::scene::BodyShape::Sphere { radius: shot.radius };
    scene.projectile.mass = Some(shot.mass);
    scene.projectile.position = [0.0, 0.0, shot.radius];
    scene.projectile.velocity = [0.0, 0.0, -speed];
    scene
}
