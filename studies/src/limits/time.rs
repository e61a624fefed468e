//! Time: fractions of the stable step, communication steps, long runs, threads.

use super::gel::{
    DENSITY, LENGTH, PLATE, SHEAR, asked, begun, closes, column, flowing, go, nearly_elastic, networks, remaining,
    struck, wave,
};
use super::row::Row;
use ballistic_gel::simulation::{CouplingMode, Simulation};

/// Error of the plate after one transit: the first cells that it touches lose their energy at once (V5).
const PISTON: f64 = 0.002;

/// Every CFL gives the same; one above 1 is refused.
pub fn cfl() -> Vec<Row> {
    let of = |more: &[(&'static str, String)], cfl: f64| {
        let keys: Vec<_> = more.iter().cloned().chain([("integrator.cfl", cfl.to_string())]).collect();
        remaining(&struck(&keys, 1.0))
    };
    let all = |more: Vec<(&'static str, String)>| [0.1, 0.4, 0.8, 1.0].map(|cfl| of(&more, cfl));
    let refused =
        asked(&[("integrator.cfl", "1.2".to_owned())]).map_or_else(|error| error.to_string(), |_| String::new());
    let expected = (-1.0_f64).exp();
    vec![
        Row::near(
            "CFL 0.1 / 0.4 / 0.8 / 1: v/v₀ = exp(−m/M) of a plate on an elastic column",
            expected,
            PISTON,
            &all(vec![]),
        ),
        Row::near("same, gel of two networks, nearly elastic", expected, PISTON, &all(nearly_elastic(SHEAR))),
        fluid(),
        Row::said("CFL 1.2", "integrator.cfl", &refused),
    ]
}

/// A gel without networks bears pressure alone: its wave has √(K/ρ).
fn fluid() -> Row {
    let slower = wave(0.0, super::gel::BULK) / wave(SHEAR, super::gel::BULK);
    let got = [0.1, 0.4, 0.8, 1.0].map(|cfl| {
        let fluid = networks("[]").into_iter().chain([("gel.shear_modulus", "0.0".to_owned())]);
        let keys: Vec<_> = fluid.chain([("integrator.cfl", cfl.to_string())]).collect();
        remaining(&struck(&keys, 1.0))
    });
    Row::near("same, gel without networks: wave of √(K/ρ)", (-slower).exp(), PISTON, &got)
}

/// Digest after cutting the time to `end` into equal steps.
fn digest(end: f64, steps: u32) -> u128 {
    let mut simulation = begun(&column(&[("mesh.size", "0.01".to_owned())]));
    for i in 1..=steps {
        go(&mut simulation, end * f64::from(i) / f64::from(steps)).expect("a slow plate");
    }
    simulation.digest()
}

/// The state does not depend on how time is cut.
pub fn communication() -> Vec<Row> {
    let short = [1, 10, 100, 1000, 10_000].map(|steps| digest(1e-5, steps));
    let long = [1, 1000].map(|steps| digest(1.0, steps));
    let same = |all: &[u128]| all.iter().all(|one| *one == all[0]);
    let got = |all: &[u128]| if same(all) { "equal".to_owned() } else { format!("{all:x?}") };
    vec![
        Row::new(
            "communication steps of 1e-9 to 1e-5 s: bits of the state at 1e-5 s",
            "equal",
            got(&short),
            same(&short),
        ),
        Row::new("communication steps of 1e-3 and 1 s: bits of the state at 1 s", "equal", got(&long), same(&long)),
    ]
}

/// A hundred thousand communication steps.
pub fn many_steps() -> Vec<Row> {
    vec![steps(100_000)]
}

/// Ten million.
pub fn most_steps() -> Vec<Row> {
    vec![steps(10_000_000)]
}

fn steps(n: u32) -> Row {
    let end = 1e-9 * f64::from(n);
    let same = digest(end, n) == digest(end, 1);
    let case = format!("{n} communication steps of 1e-9 s: bits of the state");
    Row::new(case, "those of one step", if same { "those" } else { "others" }, same)
}

/// Two hundred transits of the wave.
pub fn long_run() -> Vec<Row> {
    vec![transits((200, "5e-3"), &[]), transits((200, "5e-3"), &nearly_elastic(SHEAR))]
}

/// Ten thousand, on coarser cells.
pub fn longest_run() -> Vec<Row> {
    vec![transits((10_000, "10e-3"), &[]), transits((10_000, "10e-3"), &nearly_elastic(SHEAR))]
}

/// A free column that was struck flies and swings on: its energy stays.
fn transits((n, size): (u32, &str), material: &[(&'static str, String)]) -> Row {
    let keys: Vec<_> = material.iter().cloned().chain([("mesh.size", size.to_owned())]).collect();
    let mut simulation = begun(&column(&keys));
    let transit = LENGTH / wave(SHEAR, super::gel::BULK);
    let (mut after, mut worst) = (0.0, 0.0_f64);
    for i in 1..=100 {
        go(&mut simulation, transit * f64::from(n) * f64::from(i) / 100.0).expect("a slow plate");
        let energy = simulation.observe().energy;
        let whole = energy.integration / energy.initial;
        after = if i == 1 { whole } else { after };
        worst = worst.max((whole - after).abs());
    }
    let seen = simulation.observe();
    let met = worst < 1e-3 && closes(&seen);
    let name = if material.is_empty() { "elastic" } else { "two networks, nearly elastic" };
    let case =
        format!("{n} transits of the wave in a free column, {name}: change of the energy since the first hundredth/E₀");
    Row::new(case, "< 1e-3, balances closed to 1e-10", format!("{worst:.1e}, {:.0e}", seen.energy.energy_error), met)
}

/// Any number of threads gives the same bits.
pub fn threads() -> Vec<Row> {
    let row = |name: &str, more: Vec<(&'static str, String)>| {
        let keys: Vec<_> = more.into_iter().chain([("mesh.size", "1.25e-3".to_owned())]).collect();
        let scene = column(&keys);
        let digest = |threads: usize| {
            let mut simulation =
                Simulation::new(&scene, CouplingMode::Integrated, threads).expect("a scene that can be built");
            go(&mut simulation, 1e-3).expect("a slow plate");
            simulation.digest()
        };
        let all = [1, 2, 3, 4, 7, 16, 64].map(digest);
        let same = all.iter().all(|one| *one == all[0]);
        let got = if same { "equal".to_owned() } else { format!("{all:x?}") };
        Row::new(format!("1, 2, 3, 4, 7, 16 and 64 threads, {name}: bits of the state"), "equal", got, same)
    };
    vec![row("elastic", vec![]), row("flowing", flowing())]
}

/// Gravity on the projectile is a force that the importer gives; falling, it meets z₀ − ½gt², however time is cut.
pub fn gravity() -> Vec<Row> {
    const G: f64 = 9.81;
    const END: f64 = 0.5;
    let keys =
        [("projectile.position", "[0.0, 0.0, 2.0]".to_owned()), ("projectile.velocity", "[0.0, 0.0, 0.0]".to_owned())];
    let missed = [1_u32, 7, 1000].map(|steps| {
        let mut simulation = begun(&column(&keys));
        for i in 1..=steps {
            let mut inputs = simulation.inputs();
            inputs[0].wrench.force.z = -PLATE * G;
            simulation.step(&inputs, END * f64::from(i) / f64::from(steps)).expect("a falling plate");
        }
        (simulation.kinematics(0).position.z - (2.0 - 0.5 * G * END * END)).abs()
    });
    let got = missed.map(|missed| format!("{missed:.0e}")).join(" / ");
    let met = missed.iter().all(|missed| *missed < 1e-12);
    let none = asked(&[("gel.gravity", "9.81".to_owned())]).map_or_else(|error| error.to_string(), |_| String::new());
    vec![
        Row::new("plate under external_force −Mg, 1 / 7 / 1000 steps: |z − (z₀ − ½gt²)|, m", "< 1e-12", got, met),
        Row::said("gravity on the gel", "unknown key", &none),
    ]
}

/// What presses from the first instant on accelerates plate and free column as one body, but for their vibration.
pub fn pressed() -> Vec<Row> {
    const FORCE: f64 = 1.0;
    const TRANSITS: f64 = 100.0;
    let mass = LENGTH * super::gel::WIDTH * DENSITY;
    let keys = [("projectile.velocity", "[0.0, 0.0, 0.0]".to_owned()), ("mesh.size", "5e-3".to_owned())];
    let mut simulation = begun(&column(&keys));
    let end = TRANSITS * LENGTH / wave(SHEAR, super::gel::BULK);
    let mut inputs = simulation.inputs();
    inputs[0].wrench.force.z = -FORCE;
    simulation.step(&inputs, end).expect("a plate at rest");
    let seen = simulation.observe();
    let speed = -seen.projectile().kinematics.velocity.z / (FORCE * end / (PLATE + mass));
    let mut row = Row::near(
        "plate that starts in contact, pushed for 100 transits: v/(Ft/(M + m)), free column",
        1.0,
        0.03,
        &[speed],
    );
    if !closes(&seen) {
        row = Row::new(
            "plate that starts in contact",
            "balances closed",
            format!("{:.0e}", seen.energy.energy_error),
            false,
        );
    }
    vec![row]
}
