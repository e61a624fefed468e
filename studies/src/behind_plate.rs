use super::plate;
use super::run::scene;
use super::table::{Model, place};
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::io::Write as _;

/// Radius, m, mass, kg, and speed, m/s, of `fbi-bb`.
const RADIUS: f64 = 2.185e-3;
const MASS: f64 = 0.343e-3;
const SPEED: f64 = 179.8;
/// The plate: thickness, and height of its back above the gel, m: the BB is through it before it touches the gel.
const THICKNESS: f64 = 1e-3;
const STAND_OFF: f64 = 10e-3;
/// Its yield forces, N (illustrative).
const YIELD_FORCES: [f64; 3] = [500.0, 1500.0, 3000.0];
/// Communication step, and the longer runs that the way to the gel asks for, s.
const STEP: f64 = 1e-6;
const END: f64 = 1.6e-3;

/// What is left of the BB behind a plate, and how deep that goes.
struct Shot {
    speed: f64,
    depth: f64,
}

/// `fbi-bb` behind the plate of `Armour.fmu`, as a master steps them one after the other, and shots at the speed that was left.
pub fn study() {
    println!(
        "| yield force, N | v law, m/s | v behind the plate, m/s | depth behind it, mm | depth of a direct shot, mm | difference, % |"
    );
    println!("|---|---|---|---|---|---|");
    std::thread::scope(|scope| {
        let runs = YIELD_FORCES.map(|force| (force, scope.spawn(move || both(force))));
        for (force, run) in runs {
            let (behind, direct) = run.join().expect("a run");
            let law = (SPEED * SPEED - 2.0 * force * THICKNESS / MASS).sqrt();
            println!(
                "| {force} | {law:.3} | {:.3} | {:.2} | {:.2} | {:+.2} |",
                behind.speed,
                1e3 * behind.depth,
                1e3 * direct,
                100.0 * (behind.depth / direct - 1.0),
            );
            std::io::stdout().flush().expect("a terminal");
        }
    });
}

fn both(force: f64) -> (Shot, f64) {
    let behind = behind_plate(force);
    let direct = shot(&bb(0.0, behind.speed), |_| Vector3::zeros());
    (behind, direct)
}

/// The BB with its foremost point so high above the gel, m, at this speed, m/s; cells of R/5.
fn bb(height: f64, speed: f64) -> Scene {
    let mut scene =
        scene("fbi-bb", &[("mesh.size", "0.437e-3".to_owned()), ("remesh.smallest", "0.2185e-3".to_owned())]);
    scene.scene.end_time = END;
    scene.projectile.position = [0.0, 0.0, height + RADIUS];
    scene.projectile.velocity = [0.0, 0.0, -speed];
    scene
}

/// The greatest depth of a shot under an external force that is given for each step from where the BB is, m.
fn shot(scene: &Scene, mut force: impl FnMut(&Simulation) -> Vector3) -> f64 {
    let mut simulation = Simulation::new(scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    for k in 1..=(END / STEP).round() as u32 {
        let mut inputs = simulation.inputs();
        inputs[0].wrench.force = force(&simulation);
        simulation.step(&inputs, f64::from(k) * STEP).unwrap_or_else(|error| panic!("{error}"));
    }
    simulation.contact(0).peak_depth.0
}

/// The plate steps first: the mean force of its step acts on the BB in the same one.
fn behind_plate(yield_force: f64) -> Shot {
    const PLATE: Model = plate::MODEL;
    const fn at(name: &str) -> usize {
        place(PLATE.variables, name)
    }
    let mut values = PLATE.values();
    for (name, value) in [
        ("projectile_mass", MASS),
        ("nose", RADIUS),
        ("thickness", THICKNESS),
        ("stand_off", STAND_OFF),
        ("yield_force", yield_force),
        ("stiffness", 1e9),
        ("longest_substep", 1e-9),
    ] {
        values[at(name)] = value;
    }
    (PLATE.start)(&mut values).expect("a plate");
    let mut speed = SPEED;
    let depth = shot(&bb(STAND_OFF + THICKNESS, SPEED), |simulation| {
        let bb = simulation.kinematics(0);
        values[at("projectile.position") + 2] = bb.position.z;
        values[at("projectile.velocity") + 2] = bb.velocity.z;
        if simulation.contact(0).first.is_none() {
            speed = -bb.velocity.z;
        }
        (PLATE.step)(&mut values, STEP).expect("a step of the plate");
        Vector3::new(0.0, 0.0, values[at("force") + 2])
    });
    assert!(values[at("perforated")] == 1.0, "a plate that the BB goes through");
    Shot { speed, depth }
}
