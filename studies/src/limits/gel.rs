//! The gel of the extremes: a column in the plane between sliding walls, and what is known of it.
//!
//! A plate as wide as the column hits its top: until the wave has come back from the bottom, the plate has the speed
//! v₀ exp(−ρcAt/M), after one transit L/c of the wave v₀ exp(−m/M). Pressed by p and free at its sides the column is shorter
//! by p/E′, E′ = E/(1 − ν²) in plane strain, whatever its mesh.

use ballistic_gel::scene::{self, Override, Scene, SceneError};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};

/// Length of the column, m, and its width, m.
pub const LENGTH: f64 = 0.1;
pub const WIDTH: f64 = 0.02;
/// kg/m3 and Pa.
pub const DENSITY: f64 = 1000.0;
pub const SHEAR: f64 = 70e3;
pub const BULK: f64 = 700e3;
/// Of the plate, m/s: far below the speed of the wave.
pub const SPEED: f64 = 1e-2;

const COLUMN: &str = r#"
[scene]
name = "limits"
dimension = "planar"
end_time = 1.0
communication_step = 1e-3
[gel]
shape.block.size = [0.02, 0.1]
material = "neo-hookean"
density = 1000.0
shear_modulus = 70e3
bulk_modulus = 700e3
supports = { x_min = "roller", x_max = "roller" }
[projectile]
shape.plate.size = [0.2, 0.2, 0.04]
mass = 2.0
position = [0.0, 0.0, 0.02]
velocity = [0.0, 0.0, -0.01]
[mesh]
size = 2.5e-3
[output]
frames = 1
"#;

/// Keys and what they become.
pub type Keys<'a> = &'a [(&'a str, String)];

/// The column with some keys replaced, unless that is refused.
pub fn asked(keys: Keys<'_>) -> Result<Scene, SceneError> {
    let overrides: Vec<Override> =
        keys.iter().map(|(key, value)| Override { key: (*key).into(), value: value.clone() }).collect();
    scene::read(&scene::resolve(COLUMN, &overrides)?)
}

/// The column with some keys replaced.
pub fn column(keys: Keys<'_>) -> Scene {
    asked(keys).unwrap_or_else(|error| panic!("{keys:?}: {error}"))
}

/// A scene at its start.
pub fn begun(scene: &Scene) -> Simulation {
    Simulation::new(scene, CouplingMode::Integrated, 1).unwrap_or_else(|error| panic!("{error}"))
}

/// Goes on to a time, s, unless that fails.
pub fn go(simulation: &mut Simulation, end: f64) -> Result<(), String> {
    let inputs = simulation.inputs();
    simulation.step(&inputs, end).map_err(|error| error.to_string())
}

/// A mass of the plate, kg; that of the column is 2 kg.
pub const PLATE: f64 = LENGTH * WIDTH * DENSITY;

/// Speed of a plane wave, m/s.
pub fn wave(shear: f64, bulk: f64) -> f64 {
    ((bulk + 4.0 / 3.0 * shear) / DENSITY).sqrt()
}

/// Runs the plate on the column for so many transits of the wave.
pub fn struck(keys: Keys<'_>, transits: f64) -> Observation {
    let mut simulation = begun(&column(keys));
    go(&mut simulation, transits * LENGTH / wave(SHEAR, BULK)).unwrap_or_else(|error| panic!("{keys:?}: {error}"));
    simulation.observe()
}

/// Downward speed of the plate over that at the start.
pub fn remaining(seen: &Observation) -> f64 {
    -seen.projectile().kinematics.velocity.z / SPEED
}

/// The books close: energy to 1e-10, momentum to 1e-12.
pub fn closes(seen: &Observation) -> bool {
    seen.energy.energy_error <= 1e-10 && seen.momentum_error <= 1e-12 && seen.energy.kinetic.is_finite()
}

/// By how much the books of energy and of momentum do not close, relative to what went through.
pub fn open(seen: &Observation) -> String {
    format!("{:.0e}, {:.0e}", seen.energy.energy_error, seen.momentum_error)
}

/// Keys of a gel of two networks whose branch is a millionth as stiff as its elastic network, whose modulus, Pa, is given: as good as elastic.
pub fn nearly_elastic(shear: f64) -> Vec<(&'static str, String)> {
    networks(&format!(
        "[{{ shear_modulus = {:e}, power_law = {{ stress = {:e}, exponent = 0.8 }} }}]",
        1e-6 * shear,
        1e-6 * shear
    ))
}

/// Keys of a gel of two networks whose branch, as stiff as its elastic network, flows at once.
pub fn flowing() -> Vec<(&'static str, String)> {
    networks(&format!("[{{ shear_modulus = {SHEAR:e}, power_law = {{ stress = 10.0, exponent = 0.8 }} }}]"))
}

/// Keys of a gel of two networks with these branches.
pub fn networks(branches: &str) -> Vec<(&'static str, String)> {
    vec![("gel.material", "two-network".to_owned()), ("gel.branches", branches.to_owned())]
}

/// Stops with a message, stays as it was, says the same again, and goes back to a state from before.
pub fn stops_well(simulation: &mut Simulation, end: f64) -> Result<String, String> {
    let before = simulation.save();
    let early = simulation.time() + 1e-9;
    let Err(first) = go(simulation, end) else { return Err("did not stop".to_owned()) };
    let seen = simulation.observe();
    let again = go(simulation, end + 1.0);
    if again != Err(first.clone()) {
        return Err(format!("said {first}, then {again:?}"));
    }
    if !(closes(&seen) && seen.projectile().kinematics.velocity.norm().is_finite()) {
        return Err(format!("books open by {:.0e}", seen.energy.energy_error));
    }
    simulation.restore(&before).map_err(|error| error.to_string())?;
    go(simulation, early)?;
    Ok(first)
}
