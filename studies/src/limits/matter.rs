//! Matter: incompressibility, stiffness, and meshes of any shape, by a pressure whose effect is known.

use super::gel::{Keys, LENGTH, asked, begun, closes, column, go, nearly_elastic, networks, open};
use super::row::{Row, listed};
use ballistic_gel::simulation::Observation;
use std::f64::consts::PI;

/// Pressure over E′: the second order of the strain is left out by the closed form.
const STRAIN: f64 = 1e-4;
const TOLERANCE: f64 = 1e-3;
/// Young's modulus, Pa.
const YOUNG: f64 = 2e5;

/// Strain over p/E′ where the books close.
fn pressed(elasticity: (f64, f64), more: Keys<'_>) -> f64 {
    let (strain, seen) = rested(elasticity, more);
    assert!(closes(&seen), "{more:?}: books open by {}", open(&seen));
    strain
}

/// Strain over p/E′ of a column that is pressed and damped until it rests, and what is seen then.
fn rested((young, nu): (f64, f64), more: Keys<'_>) -> (f64, Observation) {
    let modulus = young / (1.0 - nu * nu);
    let slowest = 0.5 * PI * (modulus / 1000.0).sqrt() / LENGTH;
    // Modes down to half of that swing, and die as exp(−ωt/2).
    let end = 32.0 / slowest;
    let mut keys = vec![
        ("gel.shear_modulus", format!("{:e}", young / (2.0 * (1.0 + nu)))),
        ("gel.bulk_modulus", format!("{:e}", young / (3.0 * (1.0 - 2.0 * nu)))),
        ("gel.supports", "{ z_min = \"roller\" }".to_owned()),
        ("projectile.active", "false".to_owned()),
        ("integrator.damping", format!("{slowest:e}")),
        ("mesh.size", "0.01".to_owned()),
        ("scene.end_time", format!("{end:e}")),
        ("scene.communication_step", format!("{end:e}")),
    ];
    let load = format!("[{{ on = \"z_max\", pressure = {:e}, ramp = {:e} }}]", STRAIN * modulus, 0.1 * end);
    keys.push(("load", load));
    keys.extend(more.iter().cloned());
    let scene = column(&keys);
    let mut simulation = begun(&scene);
    go(&mut simulation, end).unwrap_or_else(|error| panic!("{keys:?}: {error}"));
    let frame = simulation.frame();
    let top: Vec<f64> = frame
        .points
        .iter()
        .zip(&frame.displacements)
        .filter(|(x, u)| (x.z - u.z).abs() < 1e-9)
        .map(|(_, u)| -u.z / LENGTH)
        .collect();
    (top.iter().sum::<f64>() / top.len() as f64 / STRAIN, simulation.observe())
}

fn viscoelastic() -> Vec<(&'static str, String)> {
    networks("[{ shear_modulus = 7e3, time = 1e-3 }]")
}

/// Poisson's ratio from 0 to 0.4999.
pub fn poisson() -> Vec<Row> {
    let row = |name: &str, more: &[(&'static str, String)]| {
        // The volume of a gel must resist more than its shear, branches included.
        let least = if more.iter().any(|(key, _)| *key == "gel.branches") { 0.1 } else { 0.0 };
        let got = [least, 0.3, 0.49, 0.4999].map(|nu| pressed((YOUNG, nu), more));
        Row::near(
            format!("ν = {least} / 0.3 / 0.49 / 0.4999, {name}: strain under a pressure/(p/E′)"),
            1.0,
            TOLERANCE,
            &got,
        )
    };
    let limit =
        asked(&[("gel.bulk_modulus", "inf".to_owned())]).map_or_else(|error| error.to_string(), |_| String::new());
    vec![
        row("elastic", &[]),
        row("elastic, patches", &[("mesh.element", "patch".to_owned())]),
        row("two networks, nearly elastic", &nearly_elastic(0.5 * YOUNG)),
        row("viscoelastic, in the long run", &viscoelastic()),
        Row::said("K infinite", "a positive modulus", &limit),
    ]
}

/// Young's modulus from 1 Pa to 1 GPa.
pub fn stiffness() -> Vec<Row> {
    let moduli = [1.0, 1e3, 1e6, 1e9];
    let row = |name: &str, more: &dyn Fn(f64) -> Vec<(&'static str, String)>| {
        let got = moduli.map(|young| pressed((young, 0.45), &more(young)));
        Row::near(format!("E = 1 Pa / 1 kPa / 1 MPa / 1 GPa, {name}: strain/(p/E′)"), 1.0, TOLERANCE, &got)
    };
    vec![row("elastic", &|_| vec![]), row("two networks, nearly elastic", &|young| nearly_elastic(0.5 * young))]
}

/// A wide block whose cells grow a hundredfold along each axis by itself: slivers at the walls of the fine stripes.
fn graded(ratio: f64) -> Vec<(&'static str, String)> {
    let size = 0.05 / ratio;
    vec![
        ("gel.shape.block.size", "[0.2, 0.1]".to_owned()),
        ("projectile.position", "[0.0, 0.0, 1.0]".to_owned()),
        ("mesh.size", format!("{size:e}")),
        ("mesh.grading", format!("{{ core = {size:e}, growth = 2.0, largest = 0.05 }}")),
    ]
}

/// Grading and slivers of 1:100.
pub fn slivers() -> Vec<Row> {
    sliver(100.0)
}

/// Grading and slivers of 1:1000.
pub fn worst_slivers() -> Vec<Row> {
    sliver(1000.0)
}

fn sliver(ratio: f64) -> Vec<Row> {
    let runs = [vec![], nearly_elastic(0.5 * YOUNG)].map(|material| {
        let keys: Vec<_> = graded(ratio).into_iter().chain(material).collect();
        rested((YOUNG, 0.45), &keys)
    });
    let case = format!("cells 1:{ratio}, slivers of that aspect, elastic / two networks: strain/(p/E′)");
    let books = "same: imbalance of energy and momentum, relative to their throughput";
    let errors = runs.each_ref().map(|(_, seen)| open(seen)).join(" / ");
    vec![
        Row::near(case, 1.0, TOLERANCE, &runs.each_ref().map(|(strain, _)| *strain)),
        Row::new(books, "< 1e-10, 1e-12", errors, runs.iter().all(|(_, seen)| closes(seen))),
    ]
}

/// Cells of 1:100 under a plate, stepped at CFL 1: no resonance.
pub fn resonance() -> Vec<Row> {
    vec![resonant(100.0, 2000)]
}

/// Cells of 1:1000.
pub fn worst_resonance() -> Vec<Row> {
    vec![resonant(1000.0, 1000)]
}

/// Slivers share nodes with elements whose own step is hundreds of times longer: stepped at that, the nodes would resonate
/// (method 1.3). The nodal rule keeps every element below 2/ω of its nodes.
fn resonant(ratio: f64, longest: u32) -> Row {
    let keys: Vec<_> = graded(ratio).into_iter().chain([("integrator.cfl", "1.0".to_owned())]).collect();
    let mut scene = column(&keys);
    scene.projectile.position[2] = 0.02;
    let mut simulation = begun(&scene);
    let seen = simulation.observe();
    let [least, most] = [seen.cost.smallest_step, seen.cost.largest_step];
    let mut fifths = [0.0_f64; 5];
    for i in 0..50 {
        go(&mut simulation, most * f64::from(longest) * f64::from(i + 1) / 50.0).expect("a slow plate");
        let energy = simulation.observe().energy;
        let worst = &mut fifths[i as usize / 10];
        *worst = worst.max(energy.integration.abs() / energy.initial);
    }
    let [first, .., last] = fifths;
    let case = format!(
        "resonance: plate on cells 1:{ratio} at CFL 1, steps 1:{:.0}, {longest} longest steps: greatest |integration|/E₀ in the first and the last fifth",
        most / least
    );
    let met = last < 1.5 * first && last < 0.1 && closes(&simulation.observe());
    Row::new(case, "< 0.1, no more than 1.5 times as much", format!("{first:.1e}, {last:.1e}"), met)
}

/// One cell: two triangles, four, and a patch.
pub fn one_cell() -> Vec<Row> {
    let whole = [
        ("gel.shape.block.size", "[0.1, 0.1]".to_owned()),
        ("mesh.size", "0.1".to_owned()),
        ("projectile.shape.plate.size", "[0.4, 0.4, 0.4]".to_owned()),
    ];
    let of =
        |more: (&'static str, &str)| pressed((YOUNG, 0.45), &[&whole[..], &[(more.0, more.1.to_owned())]].concat());
    let got = [("mesh.lattice", "kuhn"), ("mesh.lattice", "centred"), ("mesh.element", "patch")].map(of);
    let met = got.iter().all(|got| (got - 1.0).abs() < TOLERANCE);
    let case = "one cell of 2 triangles / 4 triangles / 4 in patches: strain/(p/E′)";
    vec![Row::new(case, format!("1 ± {TOLERANCE}"), listed(&got, 4), met)]
}
