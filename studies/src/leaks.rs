use super::deepest::deepest;
use super::run::{Run, run};
use super::shot::{RADIUS, Space, shot};
use std::io::Write as _;

const ROUND: [f64; 7] = [1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0];
const SHARP: [&str; 9] = [
    "capsule, tilted",
    "cylinder",
    "cylinder on its rim, sharp",
    "cylinder on its rim, rounded",
    "ogive, sharp",
    "ogive, meplat",
    "cone",
    "ogive of triangles",
    "cylinder of triangles on its rim",
];
/// In the plane and about the axis.
const FLAT: [(Space, &str); 6] = [
    (Space::Planar, "sphere"),
    (Space::Planar, "cylinder on its rim, sharp"),
    (Space::Planar, "ogive, sharp"),
    (Space::Planar, "cone"),
    (Space::Axisymmetric, "sphere"),
    (Space::Axisymmetric, "cone"),
];
/// From this ratio on a row is run with one point of entry, and a core of the mesh of half of the body's radius.
const FINE: f64 = 10.0;

/// Deepest penetration of nodes and of the whole surface, by shape of the body, mesh size and speed.
pub fn study() {
    println!("| body | R/h | v, m/s | depth, mm | node | mean | surface | least J | closure | defect | end |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in [5.0, 20.0] {
        let finest = if speed > 5.0 { 5.0 } else { f64::INFINITY };
        for ratio in ROUND.into_iter().filter(|ratio| *ratio < finest) {
            row((Space::Spatial, "sphere"), ratio, speed);
        }
        for name in SHARP {
            for ratio in [1.5, 3.0] {
                row((Space::Spatial, name), ratio, speed);
            }
        }
        for what in FLAT {
            for ratio in [1.5, 5.0, 20.0] {
                row(what, ratio, speed);
            }
        }
    }
}

/// The worst of what was seen with the body above a node and above the middle of a facet.
#[derive(Default)]
struct Worst {
    depth: f64,
    node: f64,
    mean: f64,
    surface: f64,
    jacobian: f64,
    closure: f64,
    defect: f64,
    ends: Vec<String>,
}

fn row(what: (Space, &str), ratio: f64, speed: f64) {
    let (space, name) = what;
    let h = RADIUS / ratio;
    let mut worst = Worst { jacobian: 1.0, ..Worst::default() };
    let most = if ratio < FINE || space != Space::Spatial { usize::MAX } else { 1 };
    for at in space.entries().iter().take(most) {
        shoot(&mut worst, what, (h, at.map(|x| x * h)), speed);
    }
    let Worst { depth, node, mean, surface, jacobian, closure, defect, ends } = worst;
    println!(
        "| {}{name} | {ratio} | {speed} | {:.1} | {node:.3} | {mean:.3} | {surface:.2} | {jacobian:.2} | {closure:.0e} | {defect:.1e} | {} |",
        space.label(),
        1e3 * depth,
        ends.join("; "),
    );
    std::io::stdout().flush().expect("a terminal");
}

fn shoot(worst: &mut Worst, (space, name): (Space, &str), (h, at): (f64, [f64; 2]), speed: f64) {
    let (core, growth) = if RADIUS / h < FINE { (1.5 * RADIUS, 1.3) } else { (0.5 * RADIUS, 1.5) };
    let keys = [
        ("mesh.size", format!("{h:e}")),
        ("mesh.grading", format!("{{core={core:e}, growth={growth}, largest=0.01}}")),
        ("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed)),
        ("output.frames", "1".to_owned()),
        ("scene.end_time", "5e-3".to_owned()),
    ];
    let scene = shot((space, name), at, &keys);
    let mut surface: f64 = 0.0;
    let Run { last, failure, .. } = run(&scene, 40, |now| surface = surface.max(deepest(&now.frame(), &scene, 6) / h));
    let (contact, energy) = (&last.projectile().contact, &last.energy);
    worst.depth = worst.depth.max(contact.peak_depth.0);
    worst.node = worst.node.max(contact.deepest_penetration);
    worst.mean = worst.mean.max(contact.mean_standing_penetration);
    worst.surface = worst.surface.max(surface);
    worst.jacobian = worst.jacobian.min(last.cost.min_jacobian);
    worst.closure = worst.closure.max(energy.energy_error);
    worst.defect = worst.defect.max(energy.energy_defect);
    if let Some(failure) = failure {
        let what = if failure.contains("leaks") { "leaks" } else { "inverted" };
        worst.ends.push(format!("{what} {:.1} mm deep", 1e3 * contact.peak_depth.0));
    }
}
