//! Impacts: masses, speeds and sizes of the projectile, and a gel that nothing holds.

use super::gel::{
    BULK, DENSITY, Keys, LENGTH, PLATE, SHEAR, asked, begun, closes, column, flowing, go, nearly_elastic, open,
    remaining, stops_well, struck, wave,
};
use super::row::{Row, listed, shortened};
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, Override, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
use std::f64::consts::PI;

/// A built-in scene with some keys replaced.
fn builtin(name: &str, keys: Keys<'_>) -> Scene {
    let overrides: Vec<Override> =
        keys.iter().map(|(key, value)| Override { key: (*key).into(), value: value.clone() }).collect();
    let text = scene::resolve(scene::builtin(name).expect("it is built in"), &overrides).expect("it is TOML");
    scene::read(&text).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn plate(mass: f64) -> (&'static str, String) {
    ("projectile.mass", format!("{mass:e}"))
}

/// Mass of the plate over that of the column: far lighter than a node, and far heavier than all of it.
pub fn masses() -> Vec<Row> {
    let row = |name: &str, more: &[(&'static str, String)]| {
        let of = |ratio: f64| {
            let keys: Vec<_> = more.iter().cloned().chain([plate(ratio * PLATE)]).collect();
            let seen = struck(&keys, 1.0);
            assert!(closes(&seen), "mass ratio {ratio}: {:?}", seen.energy);
            remaining(&seen)
        };
        let light = [1e-6, 1e-4].map(of);
        let heavy = [1.0_f64, 1e2, 1e4, 1e6].map(|ratio| (1.0 - of(ratio)) / -(-1.0 / ratio).exp_m1());
        [
            Row::near(
                format!("plate/column 1e-6 / 1e-4, {name}: v/v₀ after a transit, balances closed"),
                0.0,
                1e-2,
                &light,
            ),
            Row::near(
                format!("plate/column 1 / 1e2 / 1e4 / 1e6, {name}: speed lost over 1 − exp(−m/M)"),
                1.0,
                0.02,
                &heavy,
            ),
        ]
    };
    [row("elastic", &[]), row("two networks, nearly elastic", &nearly_elastic(SHEAR))].into_iter().flatten().collect()
}

/// Slow plates: all is linear, down to numbers below the normal ones.
pub fn slow() -> Vec<Row> {
    let of = |speed: f64| {
        let mut scene = column(&[]);
        scene.projectile.velocity[2] = -speed;
        let mut simulation = begun(&scene);
        go(&mut simulation, LENGTH / wave(SHEAR, BULK)).expect("a slow plate");
        (-simulation.kinematics(0).velocity.z / speed, simulation.observe())
    };
    let got = [1e-6, 1e-3, 1e-1].map(|speed| of(speed).0);
    let tiny = [1e-160, 1e-300, 1e-310, 5e-324].map(|speed| {
        let (rest, seen) = of(speed);
        if rest.is_finite() && seen.energy.energy_error < 1e-10 { rest } else { f64::NAN }
    });
    // Such displacements are lost in the rounding of positions except where a coordinate is 0, as at the surface: what the gel resists with
    // is no more known than that it slows the plate and does not push it back.
    let met = tiny.iter().all(|rest| (0.0..=1.0).contains(rest));
    vec![
        Row::near("speed 1e-6 / 1e-3 / 0.1 m/s: v/v₀ = exp(−m/M)", (-1.0_f64).exp(), 0.01, &got),
        Row::new(
            "speed 1e-160 / 1e-300 / 1e-310 / 5e-324 m/s, denormal numbers: v/v₀",
            "0 to 1, balances closed",
            listed(&tiny, 3),
            met,
        ),
    ]
}

/// Far above the speed of the wave: a fixed elastic mesh stops and says why; the books close there, too.
pub fn fast() -> Vec<Row> {
    let stopped = |speed: f64| {
        let keys = [("mesh.size", "10e-3".to_owned()), ("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed))];
        let mut simulation = begun(&builtin("sphere-block", &keys));
        stops_well(&mut simulation, 10e-3)
    };
    let row = |speed: f64| {
        let case = format!("ball of {speed} m/s on a fixed elastic mesh, wave of 27 m/s");
        let expected = "stops with a reason, repeats it, balances closed, an earlier state restored";
        match stopped(speed) {
            Ok(said) => Row::new(case, expected, shortened(&said), said.contains("element") || said.contains("leaks")),
            Err(wrong) => Row::new(case, expected, wrong, false),
        }
    };
    vec![row(100.0), row(300.0), row(1500.0)]
}

/// The shot at Mach 1.9 of its gel, which flows and is meshed anew.
pub fn supersonic() -> Vec<Row> {
    let (speed, end) = (1500.0, 30e-6);
    let keys = [("projectile.velocity", format!("[0.0, 0.0, {:e}]", -speed)), ("scene.end_time", format!("{end:e}"))];
    let scene = builtin("fbi-bb", &keys);
    let mut simulation = begun(&scene);
    let outcome = go(&mut simulation, end);
    let seen = simulation.observe();
    let (radius, mass) = (2.185e-3_f64, 0.343e-3);
    // v₀/v − 1 = ½ρAC v₀t/M for a drag that goes with the square of the speed.
    let ratio = -speed / seen.projectile().kinematics.velocity.z;
    let drag = (ratio - 1.0) * mass / (0.5 * 1030.0 * PI * radius * radius * speed * simulation.time());
    let case = "fbi-bb at 1500 m/s, Mach 1.9, 30 µs: drag coefficient; balances closed";
    let expected = "between 0.3 and 1.2, or stops with a reason";
    let got = match &outcome {
        Ok(()) => format!("{drag:.2}; {:.0e}", seen.energy.energy_error),
        Err(said) => format!("{drag:.2} until {}", shortened(said)),
    };
    vec![Row::new(case, expected, got, closes(&seen) && (outcome.is_err() || (0.3..=1.2).contains(&drag)))]
}

/// Projectiles larger than the block, smaller than an element, touching, and inside.
pub fn sizes() -> Vec<Row> {
    let large = [
        ("projectile.shape.plate.size", "[2e3, 2e3, 2e2]".to_owned()),
        ("projectile.position", "[0, 0, 1e2]".to_owned()),
    ];
    let said = |keys: Keys<'_>| asked(keys).map_or_else(|error| error.to_string(), |_| "nothing".to_owned());
    let small = said(&[
        ("projectile.shape", "{ sphere = { radius = 1e-3 } }".to_owned()),
        ("projectile.position", "[0, 0, 1e-3]".to_owned()),
    ]);
    let inside = said(&[("projectile.position", "[0.0, 0.0, 0.018]".to_owned())]);
    let middle = said(&[
        ("projectile.shape", "{ sphere = { radius = 5e-3 } }".to_owned()),
        ("projectile.position", "[0, 0, -0.05]".to_owned()),
    ]);
    vec![
        Row::near(
            "plate of 2 km on the column: v/v₀ = exp(−m/M)",
            (-1.0_f64).exp(),
            0.01,
            &[remaining(&struck(&large, 1.0))],
        ),
        Row::said("ball of 1 mm on cells of 2.5 mm", "it would slip through", &small),
        Row::said("plate that starts 2 mm deep", "expected a start outside the gel or just touching it", &inside),
        Row::said("ball in the middle of the gel", "expected a start outside the gel", &middle),
    ]
}

/// Gel that nothing holds and nothing touches flies on as it is.
pub fn free_flight() -> Vec<Row> {
    let row = |name: &str, material: Vec<(&'static str, String)>| {
        const END: f64 = 10.0;
        let velocity = Vector3::new(1.0, 0.0, -2.0);
        let mut keys = material;
        keys.extend([
            ("gel.supports", "{}".to_owned()),
            ("gel.velocity", "[1.0, 0.0, -2.0]".to_owned()),
            ("projectile.active", "false".to_owned()),
            ("mesh.size", "0.01".to_owned()),
        ]);
        let mut simulation = begun(&column(&keys));
        go(&mut simulation, END).expect("a gel in flight");
        let frame = simulation.frame();
        let off = frame.displacements.iter().map(|u| (u - velocity * END).norm()).fold(0.0, f64::max);
        let energy = simulation.observe().energy;
        let strain = energy.elastic / energy.kinetic;
        let case = format!("free {name} gel flies 22 m: |u − vt|, m; elastic/kinetic");
        // A sum over all of the gel is rounded at 1e-16 of the energy that goes by, whichever way.
        Row::new(case, "< 1e-9; ±1e-14", format!("{off:.0e}; {strain:.0e}"), off < 1e-9 && strain.abs() < 1e-14)
    };
    vec![row("elastic", vec![]), row("flowing", flowing())]
}

/// Two million tetrahedra.
pub fn two_million() -> Vec<Row> {
    const CELLS: f64 = 55.0;
    const TRANSITS: f64 = 0.3;
    let keys = [
        ("scene.dimension", "spatial".to_owned()),
        ("gel.shape.block.size", format!("[{LENGTH}, {LENGTH}, {LENGTH}]")),
        (
            "gel.supports",
            "{ x_min = \"roller\", x_max = \"roller\", y_min = \"roller\", y_max = \"roller\" }".to_owned(),
        ),
        ("mesh.size", format!("{:e}", LENGTH / CELLS * (1.0 + 1e-9))),
        plate(LENGTH.powi(3) * DENSITY),
    ];
    let seen = struck(&keys, TRANSITS);
    let case = format!("{:.2} million tetrahedra, 0.3 transits: v/v₀ = exp(−0.3)", 1e-6 * seen.cost.elements as f64);
    let books = "same: imbalance of energy and momentum";
    vec![
        Row::near(case, (-TRANSITS).exp(), 0.01, &[remaining(&seen)]),
        Row::new(books, "< 1e-10, 1e-12", open(&seen), closes(&seen)),
    ]
}

/// A scene beyond what can be built says so.
pub fn too_much() -> Vec<Row> {
    let built = |keys: Keys<'_>| match asked(keys) {
        Err(error) => error.to_string(),
        Ok(scene) => Simulation::new(&scene, CouplingMode::Integrated, 1)
            .map_or_else(|error| error.to_string(), |_| "nothing".into()),
    };
    let fine = built(&[("mesh.size", "1e-6".to_owned())]);
    let stiff = built(&[
        ("gel.bulk_modulus", "1e15".to_owned()),
        ("scene.end_time", "1e9".to_owned()),
        ("scene.communication_step", "1.0".to_owned()),
    ]);
    vec![
        Row::said("cells of 1 µm", "raise mesh.size", &fine),
        Row::said("1e9 s of a gel of 1e15 Pa", "shorten the run", &stiff),
    ]
}
