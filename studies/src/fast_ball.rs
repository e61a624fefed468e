use super::run::{Run, run, scene};
use std::io::Write as _;

/// Cells along the edge of 0.1 m of the block.
const CELLS: [u32; 4] = [16, 20, 28, 40];

/// `sphere-block` at 20 m/s: three quarters of the wave speed, nearly through the block and back.
pub fn study() {
    println!(
        "| h, mm | elements | depth, mm | at, ms | v at 10 ms, m/s | least J | closure | defect | updates | of one step for all | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for n in CELLS {
        let size = 0.1 / f64::from(n);
        let keys = [
            ("mesh.size", format!("{size:e}")),
            ("projectile.velocity", "[0.0, 0.0, -20.0]".to_owned()),
            ("output.frames", "1".to_owned()),
        ];
        let Run { last, failure, seconds } = run(&scene("sphere-block", &keys), 1, |_| {});
        assert!(failure.is_none(), "{failure:?}");
        let ((depth, at), cost) = (last.projectile().contact.peak_depth, &last.cost);
        println!(
            "| {:.2} | {} | {:.2} | {:.3} | {:.3} | {:.3} | {:.0e} | {:.1e} | {:.2e} | {:.1} % | {seconds:.1} |",
            1e3 * size,
            cost.elements,
            1e3 * depth,
            1e3 * at,
            last.projectile().kinematics.velocity.z,
            cost.min_jacobian,
            last.energy.energy_error,
            last.energy.energy_defect,
            cost.element_updates,
            100.0 * cost.element_updates / cost.synchronous_updates,
        );
        std::io::stdout().flush().expect("a terminal");
    }
}
