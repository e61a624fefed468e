//! Rheology of the gel of fbi-bb by itself: compression at a constant rate and small oscillating shear, incompressible,
//! without damage.

use ballistic_gel::scene::{self, BranchSpec, GelSpec};

/// Nominal strain of the compression.
const STRAIN: f64 = 0.45;
/// Rates of the compression, 1/s, and published nominal stresses, kPa.
const COMPRESSIONS: [(f64, &str); 4] = [(1e-3, "3 to 30"), (1.0, "–"), (1e3, "hundreds"), (3e3, "6000, recalled")];
/// Amplitude of the shear, and its frequencies, Hz; tan δ of 0.05 to 0.15 is published for 1 to 1000 Hz.
const SHEAR: f64 = 0.01;
const FREQUENCIES: [f64; 3] = [1.0, 100.0, 1000.0];
/// Steps of a compression, and of a period.
const STEPS: u32 = 4000;
/// Halvings of an interval.
const HALVINGS: usize = 60;

/// Stresses, moduli and loss angles beside published ones.
pub fn study() {
    let scene = scene::read(scene::builtin("fbi-bb").expect("a built-in scene")).expect("a valid scene");
    let gel = &scene.gel;
    println!("| | computed | published |");
    println!("|---|---|---|");
    println!("| Young's modulus at rest, kPa | {:.0} | 18 to 60, to 110 |", 3e-3 * gel.shear_modulus);
    for (rate, published) in COMPRESSIONS {
        let stress = 1e-3 * compression(gel, rate);
        println!("| nominal stress at {:.0} % and {rate}/s, kPa | {stress:.0} | {published} |", 100.0 * STRAIN);
    }
    for frequency in FREQUENCIES {
        println!("| tan δ at {frequency} Hz and 1 % | {:.2e} | 0.05 to 0.15 |", loss(gel, frequency));
    }
}

/// Nominal stress, Pa, at the end of a compression of nominal `rate`, 1/s.
fn compression(gel: &GelSpec, rate: f64) -> f64 {
    let step = STRAIN / rate / f64::from(STEPS);
    let mut elastic = vec![0.0; gel.branches.len()];
    let (mut before, mut stretch) = (0.0, 1.0_f64);
    for i in 1..=STEPS {
        stretch = 1.0 - STRAIN * f64::from(i) / f64::from(STEPS);
        let strain = -stretch.ln();
        for (branch, elastic) in gel.branches.iter().zip(&mut elastic) {
            *elastic = returned(*elastic + strain - before, step, |e| flow(branch, stress(branch, e)));
        }
        before = strain;
    }
    let branches: f64 = gel.branches.iter().zip(&elastic).map(|(branch, e)| stress(branch, *e)).sum();
    (gel.shear_modulus * (1.0 / stretch - stretch * stretch) + branches) / (1.0 - STRAIN)
}

/// Equivalent stress of a branch at the logarithmic elastic strain of a compression, Pa.
fn stress(branch: &BranchSpec, elastic: f64) -> f64 {
    branch.shear_modulus * (elastic.exp() - (-2.0 * elastic).exp())
}

/// Viscous rate of a branch at an equivalent stress, 1/s; infinite above the stress that saturates.
fn flow(branch: &BranchSpec, stress: f64) -> f64 {
    match (branch.power_law, branch.time) {
        (Some(spec), _) if spec.rate.is_some() && stress > spec.stress => f64::INFINITY,
        (Some(spec), _) => spec.law().rate_at(stress),
        (None, Some(time)) => stress / (3.0 * branch.shear_modulus * time),
        (None, None) => 0.0,
    }
}

/// Elastic part of a trial strain after a `step`, s, of flow at a rate that grows with it: implicit Euler.
fn returned(trial: f64, step: f64, rate: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, trial.abs());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle + step * rate(middle) > trial.abs() { high = middle } else { low = middle }
    }
    low.copysign(trial)
}

/// tan δ of a simple shear, over the third period.
fn loss(gel: &GelSpec, frequency: f64) -> f64 {
    let step = 1.0 / frequency / f64::from(STEPS);
    let mut elastic = vec![0.0; gel.branches.len()];
    let (mut before, mut with, mut across) = (0.0, 0.0, 0.0);
    for i in 1..=3 * STEPS {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(STEPS)).sin_cos();
        let shear = SHEAR * sin;
        let mut force = gel.shear_modulus * shear;
        for (branch, elastic) in gel.branches.iter().zip(&mut elastic) {
            let root = 3.0_f64.sqrt();
            let rate = |e: f64| root * flow(branch, root * branch.shear_modulus * e);
            *elastic = returned(*elastic + shear - before, step, rate);
            force += branch.shear_modulus * *elastic;
        }
        before = shear;
        if i > 2 * STEPS {
            (with, across) = (with + force * sin, across + force * cos);
        }
    }
    across / with
}
