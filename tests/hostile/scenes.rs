//! Scenes that nobody wrote: built-in ones with bytes, numbers, lines and tables changed, read, built and stepped.

use super::random::Random;
use super::tally::Fate;
use super::written;
use ballistic_gel::output::{DriverInterface, OutputError, RunRecorder};
use ballistic_gel::scene::{self, Dimension, GelShape, Override, RemeshSpec, Scene, ScheduleKind};
use ballistic_gel::simulation::{CouplingMode, Observation, Simulation};
use std::sync::atomic::{AtomicU64, Ordering};

/// Larger meshes are read but not built.
const MOST_CELLS: f64 = 3000.0;
/// Larger meshes are not exchanged: that takes longer than all else.
const MOST_REMESHED: f64 = 600.0;
/// Smallest steps that a scene is stepped by.
const STEPS: f64 = 24.0;

/// New meshes in all scenes so far.
pub static REMESHES: AtomicU64 = AtomicU64::new(0);

/// Lines that a scene may have.
const LINES: [&str; 35] = [
    "lattice = \"kuhn\"",
    "lattice = \"centred\"",
    "element = \"patch\"",
    "element = \"plain\"",
    "grading = { core = 5e-3, growth = 1.2, largest = 2e-2 }",
    "tree = { coarsest = 2, core = 2e-3, slope = 0.25 }",
    "material = \"two-network\"",
    "shear_modulus = 0.0",
    "material = \"neo-hookean\"",
    "branches = [{ shear_modulus = 7e3, time = 12e-3 }]",
    "branches = [{ shear_modulus = 4.8e6, power_law = { stress = 640.0, exponent = 0.8 } }]",
    "damage = { critical_stretch = 1.5, delay = 1e-6 }",
    "volume = { tension_limit = 2e6 }",
    "viscosity = { linear = 0.1 }",
    "velocity = [0.0, 0.0, -3.0]",
    "supports.z_min = \"roller\"",
    "supports.side = \"fixed\"",
    "thickness = 0.5",
    "fixed = true",
    "active = false",
    "angular_velocity = [0.0, 20.0, 0.0]",
    "shape.capsule = { radius = 0.02, length = 0.05 }",
    "shape.half-space.normal = [0.0, 0.0, 1.0]",
    "shape.dome = { height = 0.0, radius = 0.03 }",
    "[remesh]",
    "quality = 0.3",
    "times = [1e-6, 1e-5]",
    "[integrator]",
    "schedule = \"queue\"",
    "schedule = \"global\"",
    "cfl = 0.3",
    "[contact]",
    "law = \"reversal\"",
    "[[load]]",
    "[[fragment]]",
];

/// What numbers become.
const VALUES: [&str; 24] = [
    "0",
    "-0.0",
    "-1",
    "1e-300",
    "1e300",
    "nan",
    "inf",
    "-inf",
    "1e15",
    "1e16",
    "1e-15",
    "5e-324",
    "9223372036854775807",
    "-9223372036854775808",
    "1e999",
    "0x10",
    "true",
    "\"x\"",
    "[]",
    "{}",
    "[1, 2]",
    "1979-05-27",
    "''",
    "1e-9",
];

/// The scenes that the others are made from: built in, on coarse meshes.
pub fn seeds() -> Vec<String> {
    let coarse = |name: &str, keys: &[(&str, &str)]| {
        let keys: Vec<Override> =
            keys.iter().map(|(key, value)| Override { key: (*key).into(), value: (*value).into() }).collect();
        scene::resolve(scene::builtin(name).expect("it is built in"), &keys).expect("it is TOML")
    };
    let small = "{ radius = 0.02, height = 0.02 }";
    vec![
        coarse("sphere-block", &[("mesh.size", "10e-3")]),
        coarse("ball-square", &[("mesh.size", "8e-3"), ("remesh.quality", "0.3")]),
        coarse("ball-bounce", &[("mesh.size", "6e-3"), ("gel.shape.cylinder.radius", "0.05")]),
        coarse("bounce-visco", &[("mesh.size", "6e-3"), ("gel.shape.cylinder.radius", "0.05")]),
        coarse("l-beam", &[("mesh.size", "25e-3")]),
        coarse("fbi-bb", &[("mesh.size", "1e-3"), ("gel.shape.cylinder", small), ("mesh.tree.coarsest", "4")]),
        coarse("cavity-exact", &[]),
    ]
}

/// Makes a scene and tries it; taken if it could be stepped, with its files written.
pub fn attempt(seeds: &[String], seed: u64) -> Result<Fate, String> {
    let text = text(seeds, seed);
    let files = |name: &str| -> std::io::Result<Vec<u8>> {
        if name.len().is_multiple_of(2) {
            Ok(name.as_bytes().repeat(40))
        } else {
            Err(std::io::ErrorKind::NotFound.into())
        }
    };
    match scene::read_with_files(&text, &files) {
        Err(error) if error.to_string().trim().is_empty() => Err("an error without words".to_owned()),
        Err(_) => Ok(Fate::Refused),
        Ok(scene) if cells(&scene) > MOST_CELLS => Ok(Fate::Taken),
        Ok(scene) => stepped(&scene, &mut Random(seed)),
    }
}

/// The scene of a seed.
pub fn text(seeds: &[String], seed: u64) -> String {
    let mut random = Random(seed);
    let mut text = random.pick(seeds).clone();
    for _ in 0..=random.below(5) {
        text = change(&text, seeds, &mut random);
    }
    text
}

fn change(text: &str, seeds: &[String], random: &mut Random) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return random.pick(&LINES).to_string();
    }
    let at = random.below(lines.len());
    match random.below(12) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[random.below(lines.len())].clone()),
        2 | 3 => lines.insert(at, random.pick(&LINES).to_string()),
        4 => {
            let other: Vec<&str> = random.pick(seeds).lines().collect();
            lines.truncate(at);
            lines.extend(other[random.below(other.len())..].iter().map(ToString::to_string));
        }
        5 => lines[at] = scrambled(&lines[at], random),
        _ => return renumbered(text, random),
    }
    lines.join("\n")
}

/// A character more, less, or another.
fn scrambled(line: &str, random: &mut Random) -> String {
    let mut characters: Vec<char> = line.chars().collect();
    let strange =
        *random.pick(&['"', '\'', '[', ']', '{', '}', '=', '.', ',', '#', '\\', '\u{0}', 'é', '\u{10ffff}', '9', '-']);
    let at = random.below(characters.len() + 1);
    match random.below(3) {
        0 => characters.insert(at, strange),
        1 if at < characters.len() => drop(characters.remove(at)),
        _ if at < characters.len() => characters[at] = strange,
        _ => characters.push(strange),
    }
    characters.into_iter().collect()
}

/// One number of the text becomes another, or something else.
fn renumbered(text: &str, random: &mut Random) -> String {
    let bytes = text.as_bytes();
    let starts = |at: &usize| bytes[*at].is_ascii_digit() && !bytes[at.saturating_sub(1)].is_ascii_alphanumeric();
    let places: Vec<usize> = (1..bytes.len()).filter(starts).collect();
    if places.is_empty() {
        return text.to_owned();
    }
    let from = *random.pick(&places);
    let belongs = |byte: &u8| byte.is_ascii_digit() || b".eE-+_".contains(byte);
    let to = from + bytes[from..].iter().take_while(|byte| belongs(byte)).count();
    let was: f64 = text[from..to].parse().unwrap_or(1.0);
    let now = match random.below(6) {
        0 => random.pick(&VALUES).to_string(),
        1 => format!("{:e}", random.real()),
        _ => format!("{:e}", was * random.factor()),
    };
    format!("{}{now}{}", &text[..from], &text[to..])
}

/// About how many cells a mesh would have.
fn cells(scene: &Scene) -> f64 {
    let size = scene.mesh.size;
    match &scene.gel.shape {
        GelShape::Block { size: edges } => edges.iter().map(|edge| (edge / size).ceil()).product(),
        GelShape::Cylinder { radius, height, .. } if scene.scene.dimension == Dimension::Spatial => {
            (2.0 * radius / size).ceil().powi(2) * (height / size).ceil()
        }
        GelShape::Cylinder { radius, height, .. } => (radius / size).ceil() * (height / size).ceil(),
        GelShape::Shell { inner, outer } => ((outer - inner) / size).ceil() * (4.0 * outer / inner.min(size)).ceil(),
        GelShape::LBeam { leg, thickness, width, .. } => {
            2.0 * [*leg, *thickness, width.unwrap_or(size)].iter().map(|edge| (edge / size).ceil()).product::<f64>()
        }
    }
}

/// Builds a scene that was read, steps it, with new meshes on the way, and writes what a run writes.
fn stepped(scene: &Scene, random: &mut Random) -> Result<Fate, String> {
    let Ok(whole) = Simulation::new(scene, CouplingMode::Integrated, 1) else { return Ok(Fate::Refused) };
    let seen = whole.observe();
    sound(&seen)?;
    let end = (STEPS * seen.cost.smallest_step).min(scene.scene.end_time);
    drop(whole);
    let scene = shortened(scene, end, random);
    let Ok(mut simulation) = Simulation::new(&scene, CouplingMode::Integrated, 1) else { return Ok(Fate::Refused) };
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let folder = folder.path().join("run");
    let said = |error: OutputError| error.to_string();
    let mut recorder = RunRecorder::create(&folder, &scene, DriverInterface::Direct, 1).map_err(said)?;
    recorder.record(&simulation).map_err(said)?;
    let fate = advance(&mut simulation, &mut recorder, end)?;
    recorder.finish(&simulation, simulation.diagnosis().as_deref()).map_err(said)?;
    REMESHES.fetch_add(simulation.observe().cost.remeshes, Ordering::Relaxed);
    written::defect(&folder)?;
    Ok(fate)
}

/// A scene that ends after its first steps, with a few frames, and every other one that may be with new meshes.
fn shortened(scene: &Scene, end: f64, random: &mut Random) -> Scene {
    let mut scene = scene.clone();
    (scene.scene.end_time, scene.scene.communication_step) = (end, end / 4.0);
    scene.output.frames = scene.output.frames.min(3);
    scene.output.force_window = scene.output.force_window.min(end);
    // As the reader of a scene has it: there is no instant for a new mesh in a queue.
    let can_be = scene.integrator.schedule != ScheduleKind::Queue;
    if let Some(remesh) = &mut scene.remesh {
        remesh.times.retain(|time| *time <= end);
    }
    if can_be && cells(&scene) <= MOST_REMESHED && random.once_in(2) {
        let times = vec![0.3 * end, 0.7 * end];
        scene.remesh = Some(RemeshSpec { times, ..scene.remesh.unwrap_or_default() });
    }
    scene
}

/// Steps to the end, or to the step that fails, and records each step.
fn advance(simulation: &mut Simulation, recorder: &mut RunRecorder, end: f64) -> Result<Fate, String> {
    for i in 1..=4 {
        let inputs = simulation.inputs();
        let outcome = simulation.step(&inputs, end * f64::from(i) / 4.0);
        sound(&simulation.observe())?;
        if outcome.is_err() {
            return Ok(Fate::Refused);
        }
        recorder.record(simulation).map_err(|error| error.to_string())?;
    }
    Ok(Fate::Taken)
}

/// The books close, and what is seen are numbers.
fn sound(seen: &Observation) -> Result<(), String> {
    /// Rounding at the edges of what is allowed (1e±15): far above 1e-10, far below what a wrong sign would make.
    const ROUND_OFF: f64 = 1e-6;
    let energy = seen.energy;
    let body = seen.projectile().kinematics;
    let moved = body.position.iter().chain(&body.velocity).chain(&body.angular_velocity);
    let numbers =
        [energy.kinetic, energy.elastic, energy.contact, energy.imbalance, energy.energy_error, seen.momentum_error];
    if !moved.chain(&numbers).all(|number| number.is_finite()) {
        return Err(format!("not a number is seen: {numbers:?} {body:?}"));
    }
    if energy.energy_error > ROUND_OFF || seen.momentum_error > ROUND_OFF {
        return Err(format!(
            "the books do not close: energy {:e}, momentum {:e}",
            energy.energy_error, seen.momentum_error
        ));
    }
    Ok(())
}
