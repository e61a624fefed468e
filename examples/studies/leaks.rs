use super::run::{Run, run, scene};
use super::shot;
use ballistic_gel::scene::Scene;
use std::io::Write as _;

pub fn study() {
    println!(
        "| body | R/h | v, m/s | meets | depth, mm | node, h | mean, h | surface, h | least J | closure | defect | end | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for speed in [5.0, 20.0] {
        for ratio in [1.0, 1.5, 2.0, 3.0, 5.0] {
            for (meets, at) in [("node", [0.0, 0.0]), ("face", [0.5, 1.0 / 6.0])] {
                let h = 0.01 / ratio;
                let keys = keys(h, speed);
                row("sphere", (ratio, meets), &shot::shot("sphere", (0.01, at.map(|x| x * h)), &keys));
            }
        }
        for name in [
            "capsule, tilted",
            "cylinder",
            "cylinder on its rim, sharp",
            "cylinder on its rim, rounded",
            "ogive, sharp",
            "ogive, meplat",
            "cone",
        ] {
            for ratio in [1.5, 3.0] {
                for (meets, at) in [("node", [0.0, 0.0]), ("face", [0.5, 1.0 / 6.0])] {
                    let h = 0.01 / ratio;
                    let keys = keys(h, speed);
                    row(name, (ratio, meets), &shot::shot(name, (0.01, at.map(|x| x * h)), &keys));
                }
            }
        }
    }
}

fn keys(h: f64, speed: f64) -> [(&'static str, String); 5] {
    [
        ("mesh.size", format!("{h:e}")),
        ("mesh.grading", format!("{{core={:e}, growth=1.3, largest=0.01}}", 0.015f64)),
        ("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed)),
        ("output.frames", "1".to_owned()),
        ("scene.end_time", "5e-3".to_owned()),
    ]
}

fn row(name: &str, (ratio, meets): (f64, &str), scene: &Scene) {
    let mut surface: f64 = 0.0;
    let h = scene.mesh.size;
    let Run { last, failure, seconds } =
        run(scene, 40, |now| surface = surface.max(shot::deepest(&now.frame(), scene) / h));
    let v = scene.projectile.velocity[2];
    println!(
        "| {name} | {ratio} | {v} | {meets} | {:.2} | {:.3} | {:.4} | {surface:.3} | {:.3} | {:.0e} | {:.1e} | {} | {seconds:.1} |",
        1e3 * last.contact.peak_depth.0,
        last.contact.deepest_penetration,
        last.contact.mean_standing_penetration,
        last.cost.min_jacobian,
        last.energy.energy_error,
        last.energy.energy_defect,
        failure.unwrap_or_default()
    );

    std::io::stdout().flush().expect("a terminal");
}
