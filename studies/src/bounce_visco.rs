use super::run::{Run, run, scene};
use std::f64::consts::PI;
use std::io::Write as _;

/// μ, Pa, and speed, m/s, of `bounce-visco`.
const SHEAR: f64 = 35e3;
const SPEED: f64 = 0.05;
/// tan δ of a standard linear solid at ωτ = 1, ω = π/t_c, and what viscosity leaves of the speed by an independent computation of such a foundation.
const SOLIDS: [(f64, f64); 4] = [(1.0 / 41.0, 0.975), (1.0 / 21.0, 0.953), (1.0 / 11.0, 0.911), (1.0 / 6.0, 0.844)];
/// A dashpot, Pa·s, beside the spring, as a branch of this time, s, and what an independent axisymmetric code found with the dashpot:
/// 0.8115 of 0.9592.
const DASHPOT: (f64, f64, f64) = (42.0, 0.5e-3, 0.846);
/// Springs of the foundation to the greatest radius, and steps in a contact.
const SPRINGS: usize = 400;
const STEPS: f64 = 40_000.0;

/// Restitution of `bounce-visco` against that of the elastic gel times that of a foundation of springs.
pub fn study() {
    println!(
        "| h, mm | branch, Pa | its time, ms | tan δ | e elastic | foundation | reference | product | e | error | viscous, J | defect | seconds |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for size in [2e-3, 1e-3] {
        let Bounce { restitution: elastic, contact, .. } = bounce(size, None);
        for (loss, reference) in SOLIDS {
            let branch = (2.0 * loss / (1.0 - loss) * SHEAR, contact / PI);
            row((size, elastic, contact), branch, reference);
        }
        let (viscosity, time, reference) = DASHPOT;
        row((size, elastic, contact), (viscosity / time, time), reference);
    }
}

/// A run: restitution, time of contact, s, what viscosity took, J, defect, and wall time, s.
struct Bounce {
    restitution: f64,
    contact: f64,
    viscous: f64,
    defect: f64,
    seconds: f64,
}

fn bounce(size: f64, branch: Option<(f64, f64)>) -> Bounce {
    let material = match branch {
        Some((modulus, time)) => ("gel.branches", format!("[{{ shear_modulus = {modulus:?}, time = {time:?} }}]")),
        None => ("gel.material", "neo-hookean".to_owned()),
    };
    let mut keys = vec![("mesh.size", format!("{size:?}")), material];
    if branch.is_none() {
        keys.push(("gel.branches", "[]".to_owned()));
    }
    let Run { last, failure, seconds } = run(&scene("bounce-visco", &keys), 1, |_| {});
    assert!(failure.is_none(), "a ball bounces: {failure:?}");
    let touched = &last.projectile().contact;
    let contact = touched.last.zip(touched.first).map_or(0.0, |(last, first)| last - first);
    Bounce {
        restitution: last.projectile().kinematics.velocity.z / SPEED,
        contact,
        viscous: last.energy.viscous,
        defect: last.energy.energy_defect,
        seconds,
    }
}

fn row((size, elastic, contact): (f64, f64, f64), branch: (f64, f64), reference: f64) {
    let Bounce { restitution: e, viscous, defect, seconds, .. } = bounce(size, Some(branch));
    let (modulus, time) = branch;
    let phase = PI / contact * time;
    let lossy = modulus / SHEAR * phase / (1.0 + phase * phase);
    let loss = lossy / (1.0 + lossy * phase);
    let foundation = foundation((modulus / SHEAR, phase));
    println!(
        "| {} | {modulus:.0} | {:.2} | {loss:.3} | {elastic:.4} | {foundation:.4} | {reference} | {:.4} | {e:.4} | {:+.4} | {viscous:.2e} | {defect:.1e} | {seconds:.1} |",
        1e3 * size,
        1e3 * time,
        elastic * foundation,
        e - elastic * foundation,
    );
    std::io::stdout().flush().expect("a terminal");
}

/// Restitution of a mass of 1 that comes at a speed of 1 down on a row of springs at the heights x², each with a branch of `ratio` times
/// its stiffness and of the time τ, ωτ = `phase`, ω = π/t_c of the springs alone: what a sphere does on a half-space without
/// waves (the method of dimensionality reduction: 2∫(δ − x²)dx = 4/3 δ^(3/2), t_c = 2.9432 δ, δ^(5/2) = 15/16).
fn foundation((ratio, phase): (f64, f64)) -> f64 {
    let deepest = (15.0_f64 / 16.0).powf(0.4);
    let contact = 2.943_2 * deepest;
    let (step, time) = (contact / STEPS, phase * contact / PI);
    let (left, width) = ((-step / time).exp(), deepest.sqrt() / SPRINGS as f64);
    let through = (-0.5 * step / time).exp();
    let mut pulls = [0.0; SPRINGS];
    let mut is_gone = [false; SPRINGS];
    let (mut depth, mut speed) = (0.0, 1.0);
    loop {
        let before: f64 = depth;
        depth += step * speed;
        let mut force = 0.0;
        for (i, (pull, is_gone)) in pulls.iter_mut().zip(&mut is_gone).enumerate() {
            let x = (i as f64 + 0.5) * width;
            let strain = depth - x * x;
            let moved = strain.max(0.0) - (before - x * x).max(0.0);
            *pull = left * *pull + through * ratio * moved;
            *is_gone |= moved < 0.0 && strain + *pull <= 0.0;
            if strain > 0.0 && !*is_gone {
                force += 2.0 * width * (strain + *pull);
            }
        }
        speed -= step * force;
        if force <= 0.0 && speed < 0.0 {
            return -speed;
        }
    }
}
