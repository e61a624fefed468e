//! Limit of the depth of the calibration shot as its mesh is refined, by damage and by the rule of transfer.

use super::cpu::seconds;
use super::fbi_bb::Keys;
use super::run::scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::io::Write as _;

/// Cells of the scene, R/8, refined by √2 again and again: size, its growth at the start, least size and growth.
const MESHES: [(&str, [&str; 4]); 5] = [
    ("R/8", ["0.27e-3", "0.15", "0.135e-3", "0.1"]),
    ("R/11", ["0.1909e-3", "0.1061", "95.46e-6", "0.07071"]),
    ("R/16", ["0.135e-3", "0.075", "67.5e-6", "0.05"]),
    ("R/23", ["95.46e-6", "0.05303", "47.73e-6", "0.03536"]),
    ("R/32", ["67.5e-6", "0.0375", "33.75e-6", "0.025"]),
];
const REFINED: [&str; 4] = ["mesh.size", "mesh.tree.slope", "remesh.smallest", "remesh.growth"];

/// Damage and transfer: those of the scene; without damage; slower damage; the other rule of the averages; and a wave half as fast. The last
/// number is that of the meshes each is run on.
const LAWS: [(&str, &Keys, usize); 5] = [
    ("scene unchanged", &[], 5),
    ("no damage", &[("gel.damage.critical_stretch", "1e3")], 5),
    ("damage in 20 µs", &[("gel.damage.delay", "20e-6")], 4),
    ("averages without the stored energy", &[("remesh.elastic_average", "normalised-mean")], 4),
    ("wave of 400 m/s", &[("gel.bulk_modulus", "164.8e6")], 4),
];
/// How often the ball is looked at, s.
const LOOK: f64 = 2e-6;
/// Till when: the slowest of the laws stops it by then, s.
const END: f64 = 2.2e-3;

/// Depth, mean forces early and late, by law and mesh.
pub fn study() {
    println!(
        "| law | cells | depth, mm | from 10 to 20 mm: N | from 100 to 60 m/s: N | from 40 to 20 m/s: N | M updates | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (law, keys, meshes) in LAWS {
        for (cells, values) in &MESHES[..meshes] {
            row((law, keys), cells, values);
        }
    }
}

fn row((law, keys): (&str, &Keys), cells: &str, values: &[&str; 4]) {
    let refined = REFINED.iter().zip(values).map(|(key, value)| (*key, (*value).to_owned()));
    let mut keys: Vec<(&str, String)> =
        keys.iter().map(|(key, value)| (*key, (*value).to_owned())).chain(refined).collect();
    keys.push(("scene.end_time", END.to_string()));
    let scene = scene("fbi-bb", &keys);
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let begun = seconds();
    let way = way(&mut simulation);
    let cpu = seconds() - begun;
    let mass = scene.projectile.mass.expect("the scene gives a mass");
    let at = |speed: f64| way.iter().position(|look| look.1 <= speed).unwrap_or(way.len() - 1);
    let below = |depth: f64| way.iter().position(|look| look.0 >= depth).unwrap_or(way.len() - 1);
    let force = |from: usize, to: usize| {
        let (from, to) = (way[from], way[to]);
        0.5 * mass * (from.1.powi(2) - to.1.powi(2)) / (to.0 - from.0)
    };
    println!(
        "| {law} | {cells} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} | {cpu:.1} |",
        1e3 * simulation.observe().projectile().contact.peak_depth.0,
        force(below(10e-3), below(20e-3)),
        force(at(100.0), at(60.0)),
        force(at(40.0), at(20.0)),
        1e-6 * simulation.observe().cost.element_updates,
    );
    std::io::stdout().flush().expect("a terminal");
}

/// Depth of the nose, m, and speed, m/s, until the ball stands.
fn way(simulation: &mut Simulation) -> Vec<(f64, f64)> {
    let inputs = simulation.inputs();
    let mut way = vec![];
    for look in 1..=(END / LOOK).round() as u32 {
        let end = simulation.step(&inputs, LOOK * f64::from(look));
        let speed = -simulation.kinematics(0).velocity.z;
        way.push((simulation.depth(0), speed));
        if end.is_err() || speed <= 0.0 {
            break;
        }
    }
    way
}
