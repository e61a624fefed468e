use super::cpu::seconds;
use super::run::scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// A fixed mesh, and meshes that are exchanged.
const MESHES: [(&str, &[(&str, &str)]); 2] = [("fixed", &[]), ("exchanged", &[("remesh.quality", "0.3")])];
const SPEEDS: [f64; 5] = [10.0, 20.0, 30.0, 36.0, 42.0];
const SIZES: [f64; 3] = [2.5e-3, 1.25e-3, 0.625e-3];

/// The disc of `ball-square` by speed and by mesh size, on a fixed mesh and on meshes that are exchanged.
pub fn study() {
    println!(
        "| v, m/s | cells, mm | mesh | end, ms | meshes | elements | depth, mm | v at the end, m/s | least J | remesh, % of E₀ | defect, % | closure | momentum | mass | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in SPEEDS {
        for mesh in &MESHES {
            row(speed, SIZES[1], mesh);
        }
    }
    for size in SIZES {
        row(36.0, size, &MESHES[1]);
    }
}

fn row(speed: f64, size: f64, (mesh, more): &(&str, &[(&str, &str)])) {
    let own = [("projectile.velocity", format!("[0, 0, -{speed}]")), ("mesh.size", size.to_string())];
    let more = more.iter().map(|(key, value)| (*key, (*value).to_owned()));
    let keys: Vec<(&str, String)> = own.into_iter().chain(more).collect();
    let scene = scene("ball-square", &keys);
    let begun = seconds();
    let mut simulation = Simulation::new(&scene, CouplingMode::Integrated, 1).expect("a scene that can be built");
    let inputs = simulation.inputs();
    let end = simulation.step(&inputs, scene.scene.end_time);
    let cpu = seconds() - begun;
    let seen = simulation.observe();
    let end = end.map_or_else(|failure| format!("stops at {:.2}", 1e3 * failure.time()), |()| "–".to_owned());
    let mass = 0.1 * 0.1 * scene.gel.density;
    println!(
        "| {speed} | {} | {mesh} | {end} | {} | {} | {:.2} | {:+.2} | {:.3} | {:+.2} | {:.2} | {:.0e} | {:.0e} | {:.0e} | {cpu:.1} |",
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
    );
}
