//! Asynchronous steps over the range of gels and speeds, against one step for all.

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
    let (mut shares, mut pairs) = (vec![], vec![]);
    for shot in 0..SHOTS {
        if let Some(share) = gained(&drawn(shot, "bins"), shot) {
            shares.push(share);
            let alone = (shot % 10 == 0).then(|| gained(&drawn(shot, "global"), shot)).flatten();
            pairs.extend(alone.map(|alone| (share, alone)));
        }
        eprint!("\r{} of {SHOTS}", shot + 1);
        std::io::stderr().flush().expect("a terminal");
    }
    eprintln!();
    println!("| steps | shots | stopped | integration, % of E₀: median | greatest |");
    println!("|---|---|---|---|---|");
    row("asynchronous", SHOTS as usize, &shares);
    row("asynchronous, each tenth", pairs.len(), &pairs.iter().map(|pair| pair.0).collect::<Vec<f64>>());
    row("one for all, each tenth", pairs.len(), &pairs.iter().map(|pair| pair.1).collect::<Vec<f64>>());
}

/// Prints a row: how many of the shots have stopped, and what integration has gained or lost in the others.
fn row(steps: &str, shots: usize, shares: &[f64]) {
    let mut shares = shares.to_vec();
    shares.sort_by(f64::total_cmp);
    let [median, greatest] =
        [shares.get(shares.len() / 2), shares.last()].map(|share| 100.0 * share.unwrap_or(&f64::NAN));
    println!("| {steps} | {shots} | {} | {median:.2} | {greatest:.2} |", shots - shares.len());
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
    // A third of the dashpots does not saturate: they bear the stress at the rate.
    let law = if 3.0 * van_der_corput(shot + 1, 19) < 1.0 {
        let exponent = 0.2 * exponent;
        format!("{{ stress = {:e}, exponent = {exponent:e} }}", stress / rate.powf(exponent))
    } else {
        format!("{{ stress = {stress:e}, rate = {rate:e}, exponent = {exponent:e} }}")
    };
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
