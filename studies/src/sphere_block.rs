use super::richardson::{MeshValue, RefinementLimit, extrapolate_limit};
use super::run::{Run, run, scene};
use std::io::Write as _;

/// Cells along the edge of 0.1 m of the block; its height of 0.05 m has half as many. With fewer than 16 the ball of 20 mm
/// sinks between nodes and the run stops with a leak.
const CELLS: [u32; 4] = [20, 28, 40, 56];

/// Depth and rebound of `sphere-block` on ever finer meshes.
pub fn study() {
    println!("| lattice | h, mm | elements | depth, mm | at, ms | v at 10 ms, m/s | defect | updates | seconds |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let centred: Vec<Figures> = CELLS.iter().map(|n| row("centred", *n)).collect();
    for n in [20, 38] {
        row("kuhn", n);
    }
    println!("\n| from h, mm | quantity | observed order | extrapolated |");
    println!("|---|---|---|---|");
    for three in centred.windows(3) {
        for (name, pick) in [("depth, mm", 0), ("v at 10 ms, m/s", 1)] {
            let values = [three[0], three[1], three[2]].map(|f| MeshValue { size: f.size, value: f.values[pick] });
            let sizes = values.map(|v| format!("{:.2}", 1e3 * v.size)).join(" ");
            match extrapolate_limit(values, None) {
                Ok(RefinementLimit { order, value, .. }) => println!("| {sizes} | {name} | {order:.2} | {value:.3} |"),
                Err(why) => println!("| {sizes} | {name} | {why} | – |"),
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Figures {
    size: f64,
    /// Depth, mm, and velocity at the end, m/s.
    values: [f64; 2],
}

fn row(lattice: &str, n: u32) -> Figures {
    let size = 0.1 / f64::from(n);
    let keys =
        [("mesh.size", format!("{size:e}")), ("mesh.lattice", lattice.to_owned()), ("output.frames", "1".to_owned())];
    let Run { last, failure, seconds } = run(&scene("sphere-block", &keys), 1, |_| {});
    assert!(failure.is_none(), "{failure:?}");
    let (depth, at) = last.projectile().contact.peak_depth;
    let v = last.projectile().kinematics.velocity.z;
    println!(
        "| {lattice} | {:.2} | {} | {:.3} | {:.3} | {v:.4} | {:.1e} | {:.2e} | {seconds:.1} |",
        1e3 * size,
        last.cost.elements,
        1e3 * depth,
        1e3 * at,
        last.energy.energy_defect,
        last.cost.element_updates,
    );
    std::io::stdout().flush().expect("a terminal");
    Figures { size, values: [1e3 * depth, v] }
}
