use super::run::{Run, run, scene};
use ballistic_gel::scene::Scene;
use std::io::Write as _;

/// Shots with asynchronous steps; each tenth is repeated with one step for all.
const SHOTS: u32 = 100;
/// Speeds, m/s, and the way that is run, m: the crown of the splash has opened and closes.
const SPEEDS: [f64; 2] = [200.0, 1150.0];
const WAY: f64 = 0.14;
/// Stress, Pa, and rate, 1/s, at which the dashpot saturates, its exponent, and the moduli of the networks, Pa.
const RANGES: [[f64; 2]; 5] = [[0.4e6, 3e6], [3e2, 1e4], [0.3, 5.0], [2e6, 12e6], [10e3, 100e3]];
/// Frictions of contact.
const FRICTIONS: [f64; 2] = [0.0, 0.3];

/// Stability of asynchronous steps: shots over the range of speeds and of the gel, against one step for all.
pub fn study() {
    println!("| shots | stopped | integration, % of E₀: median | greatest | of one step for all: median | greatest ratio |");
    println!("|---|---|---|---|---|---|");
    let (mut shares, mut ratios, mut stopped) = (vec![], vec![], 0);
    for shot in 0..SHOTS {
        let Some(share) = gained(&drawn(shot, "bins"), shot) else {
            stopped += 1;
            continue;
        };
        shares.push(share);
        if shot % 10 == 0 {
            ratios.extend(gained(&drawn(shot, "global"), shot).map(|alone| share / alone));
        }
        eprint!("\r{} of {SHOTS}", shot + 1);
        std::io::stderr().flush().expect("a terminal");
    }
    shares.sort_by(f64::total_cmp);
    ratios.sort_by(f64::total_cmp);
    let greatest = |of: &[f64]| of.last().copied().unwrap_or(f64::NAN);
    let median = |of: &[f64]| of.get(of.len() / 2).copied().unwrap_or(f64::NAN);
    println!(
        "\r| {SHOTS} | {stopped} | {:.2} | {:.2} | {:.2} | {:.2} |",
        100.0 * median(&shares),
        100.0 * greatest(&shares),
        median(&ratios),
        greatest(&ratios),
    );
}

/// Returns the share of the initial energy that integration has gained or lost; none if the run has stopped.
fn gained(scene: &Scene, shot: u32) -> Option<f64> {
    let Run { last, failure, .. } = run(scene, 1, |_| {});
    if let Some(failure) = failure {
        eprintln!("\rshot {shot}: {failure}");
        return None;
    }
    Some(last.energy.integration.abs() / last.energy.initial)
}

/// Returns a shot of a sequence that fills speeds and gels evenly (Halton 1960).
fn drawn(shot: u32, schedule: &str) -> Scene {
    let [stress, rate, exponent, branch, elastic] =
        std::array::from_fn(|k| logarithmic(RANGES[k], van_der_corput(shot + 1, [3, 5, 7, 11, 13][k])));
    let speed = logarithmic(SPEEDS, van_der_corput(shot + 1, 2));
    let law = format!("{{ stress = {stress:e}, rate = {rate:e}, exponent = {exponent:e} }}");
    let coarse = [
        ("mesh.size", "0.0004243"),
        ("mesh.tree.slope", "0.2121"),
        ("remesh.smallest", "0.0002121"),
        ("remesh.growth", "0.2121"),
    ];
    let mut keys: Vec<(&str, String)> = coarse.map(|(key, value)| (key, value.to_owned())).into();
    keys.extend([
        ("scene.end_time", format!("{:e}", WAY / speed)),
        ("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed)),
        ("gel.branches", format!("[{{ shear_modulus = {branch:e}, power_law = {law} }}]")),
        ("gel.shear_modulus", format!("{elastic:e}")),
        ("contact.friction", FRICTIONS[usize::from(van_der_corput(shot + 1, 17) < 0.5)].to_string()),
        ("integrator.schedule", schedule.to_owned()),
    ]);
    scene("sphere-720", &keys)
}

/// Returns the point of an interval at a part of it, by logarithms.
fn logarithmic([from, to]: [f64; 2], part: f64) -> f64 {
    from * (to / from).powf(part)
}

/// Returns the radical inverse of a number: its digits behind the point, in reverse.
fn van_der_corput(mut number: u32, base: u32) -> f64 {
    let (mut sum, mut digit) = (0.0, 1.0);
    while number > 0 {
        digit /= f64::from(base);
        sum += digit * f64::from(number % base);
        number /= base;
    }
    sum
}
