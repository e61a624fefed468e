//! A plate in front of the gel that the projectile must defeat, and the bulge on its back: two masses on one axis.
//!
//! Along the flight, −z, with the advance s of the projectile's nose below the strike face, the height h of the
//! bulge, and the penetration p = s − (h − h₀) of the nose into the material:
//!
//! ```text
//! M s̈ = −R     m ḧ = R − B + Q     R = clip(k (p − pₚ), 0, Y)     B = clip(b (h − hₚ), −Z, Z)
//! ```
//!
//! R is the resistance of the plate, elastic up to its yield force Y, and pₚ the part of p that stays; B is that of
//! the membrane behind it, with hₚ; Q = (bulge impulse of the gel)/H is conjugate to h. The base radius follows the
//! height, r = r₀ + c (h − h₀), so Q takes the impulses on both. Once pₚ is the thickness, the plate is perforated
//! and R is 0 for good: the elastic rest is booked as plastic. The bulge never goes back behind the plate, h ≥ 0.
//! Friction, tilt and offset are not modelled. The default values are illustrative: a plate that a 33 g ball at 20
//! m/s perforates.
//!
//! A soft armour moves with the bulge up to its base: m = m₀ + μ π (r² − r₀²), with the areal density μ, 0 for a
//! plate whose bulge has one mass. The bulge picks up armour at rest, so d(m ḣ)/dt is the sum of the forces. The
//! inelastic impact on that armour takes ½ ṁ ḣ² of its energy, booked as plastic. A bulge that goes back drops no
//! mass.
//!
//! A plate that is perforated has taken E = Y T and what its bulge has: where that is heavy beside the projectile,
//! what is left of the speed is v² = v₀² − 2YT/M, the energy law of a plate without a plug (Recht & Ipson 1963).
//!
//! Inside a step the projectile moves on as M s̈ = −R says, from the state that is given. That is all the plate knows
//! of it, and the mean of R over the step is the force that it gives back. What it gives belongs to the step that it
//! has just made: mean force, bulge at the start, mean rates. So it steps first, if the importer has an order; else
//! the gel is a step behind with all of it alike.

use super::table::{Model, Variable, place};
use std::f64::consts::PI;

/// The partner.
pub const MODEL: Model = Model {
    name: "Armour",
    description: "A lumped plate that the projectile must defeat, with a bulge behind it (illustrative)",
    variables: &VARIABLES,
    start,
    step,
};

const VARIABLES: [Variable; 39] = [
    Variable::parameter("projectile_mass", "kg", &[0.033], "Mass of the projectile, M"),
    Variable::parameter("nose", "m", &[0.010], "Distance of the projectile's nose from its centre of mass"),
    Variable::parameter("thickness", "m", &[5e-3], "Thickness of the plate"),
    Variable::parameter(
        "stand_off",
        "m",
        &[0.0],
        "Height of the plate's back above z = 0, the entry surface of the gel",
    ),
    Variable::parameter("yield_force", "N", &[400.0], "Resistance of the plate to perforation, Y (illustrative)"),
    Variable::parameter("stiffness", "N/m", &[1e6], "Elastic stiffness of the plate under the nose, k (illustrative)"),
    Variable::parameter("bulge_mass", "kg", &[0.020], "Mass that moves with the bulge at the start, m₀ (illustrative)"),
    Variable::parameter("areal_density", "kg/m2", &[0.0], "Mass of the armour per area, which the bulge picks up, μ"),
    Variable::parameter("membrane_yield_force", "N", &[150.0], "Yield force of the membrane, Z (illustrative)"),
    Variable::parameter("membrane_stiffness", "N/m", &[1e6], "Elastic stiffness of the membrane, b (illustrative)"),
    Variable::parameter("initial_height", "m", &[0.0], "Height of the bulge at the start, h₀"),
    Variable::parameter("initial_radius", "m", &[0.015], "Base radius of the bulge at the start, r₀ (illustrative)"),
    Variable::parameter("spread", "1", &[1.0], "Growth of the base radius per height, c (illustrative)"),
    Variable::parameter("longest_substep", "s", &[1e-7], "Step inside a communication step, at most"),
    Variable::input("projectile.position", "m", 3, "Position of the projectile's centre at the start of the step"),
    Variable::input("projectile.velocity", "m/s", 3, "Velocity of the projectile at the start of the step"),
    Variable::input("bulge_height_impulse", "N.s", 1, "Impulse of the gel in the step that works on the height"),
    Variable::input("bulge_radius_impulse", "N.s", 1, "Impulse of the gel in the step that works on the base radius"),
    Variable::output("force", "N", 3, "Mean force on the projectile over the last step"),
    Variable::output("bulge_height", "m", 1, "Height of the bulge at the start of the last step"),
    Variable::output("bulge_radius", "m", 1, "Base radius of the bulge at the start of the last step"),
    Variable::output("bulge_height_rate", "m/s", 1, "Mean rate of the height over the last step"),
    Variable::output("bulge_radius_rate", "m/s", 1, "Mean rate of the base radius over the last step"),
    Variable::output("height", "m", 1, "Height of the bulge"),
    Variable::output("height_rate", "m/s", 1, "Rate of the height"),
    Variable::output("penetration", "m", 1, "Depth of the hole in the plate, pₚ"),
    Variable::output("perforated", "1", 1, "1 once the projectile has gone through the thickness, else 0"),
    Variable::output("moving_mass", "kg", 1, "Mass that moves with the bulge, m"),
    Variable::output("momentum", "N.s", 1, "Momentum of the bulge, along −z"),
    Variable::output("impulse.projectile", "N.s", 1, "Sum of the impulses of the projectile on the plate, along −z"),
    Variable::output("impulse.gel", "N.s", 1, "Sum of the impulses of the gel on the bulge, along −z"),
    Variable::output("impulse.support", "N.s", 1, "Sum of the impulses of the frame on the bulge, along −z"),
    Variable::output("energy.kinetic", "J", 1, "Kinetic energy of the bulge"),
    Variable::output("energy.elastic", "J", 1, "Elastic energy of plate and membrane"),
    Variable::output(
        "energy.plastic",
        "J",
        1,
        "Work that was spent in yielding, rupture, and impact on armour at rest",
    ),
    Variable::output("energy.projectile", "J", 1, "Work of the projectile on the plate"),
    Variable::output("energy.gel", "J", 1, "Work of the gel on the bulge"),
    Variable::output(
        "energy.imbalance",
        "J",
        1,
        "Kinetic + elastic + plastic - work of projectile and gel: left by substeps, and by jumps of the projectile",
    ),
    Variable::local("membrane_set", "m", 1, "Part of the height that stays, hₚ"),
];

const PROJECTILE_MASS: usize = place(&VARIABLES, "projectile_mass");
const NOSE: usize = place(&VARIABLES, "nose");
const THICKNESS: usize = place(&VARIABLES, "thickness");
const STAND_OFF: usize = place(&VARIABLES, "stand_off");
const YIELD_FORCE: usize = place(&VARIABLES, "yield_force");
const STIFFNESS: usize = place(&VARIABLES, "stiffness");
const BULGE_MASS: usize = place(&VARIABLES, "bulge_mass");
const AREAL_DENSITY: usize = place(&VARIABLES, "areal_density");
const MEMBRANE_YIELD_FORCE: usize = place(&VARIABLES, "membrane_yield_force");
const MEMBRANE_STIFFNESS: usize = place(&VARIABLES, "membrane_stiffness");
const INITIAL_HEIGHT: usize = place(&VARIABLES, "initial_height");
const INITIAL_RADIUS: usize = place(&VARIABLES, "initial_radius");
const SPREAD: usize = place(&VARIABLES, "spread");
const LONGEST_SUBSTEP: usize = place(&VARIABLES, "longest_substep");
const PROJECTILE_POSITION: usize = place(&VARIABLES, "projectile.position");
const PROJECTILE_VELOCITY: usize = place(&VARIABLES, "projectile.velocity");
const BULGE_HEIGHT_IMPULSE: usize = place(&VARIABLES, "bulge_height_impulse");
const BULGE_RADIUS_IMPULSE: usize = place(&VARIABLES, "bulge_radius_impulse");
const FORCE: usize = place(&VARIABLES, "force");
const BULGE_HEIGHT: usize = place(&VARIABLES, "bulge_height");
const BULGE_RADIUS: usize = place(&VARIABLES, "bulge_radius");
const BULGE_HEIGHT_RATE: usize = place(&VARIABLES, "bulge_height_rate");
const BULGE_RADIUS_RATE: usize = place(&VARIABLES, "bulge_radius_rate");
const HEIGHT: usize = place(&VARIABLES, "height");
const HEIGHT_RATE: usize = place(&VARIABLES, "height_rate");
const PENETRATION: usize = place(&VARIABLES, "penetration");
const PERFORATED: usize = place(&VARIABLES, "perforated");
const MOVING_MASS: usize = place(&VARIABLES, "moving_mass");
const MOMENTUM: usize = place(&VARIABLES, "momentum");
const PROJECTILE_IMPULSE: usize = place(&VARIABLES, "impulse.projectile");
const GEL_IMPULSE: usize = place(&VARIABLES, "impulse.gel");
const SUPPORT_IMPULSE: usize = place(&VARIABLES, "impulse.support");
const KINETIC: usize = place(&VARIABLES, "energy.kinetic");
const ELASTIC: usize = place(&VARIABLES, "energy.elastic");
const PLASTIC: usize = place(&VARIABLES, "energy.plastic");
const PROJECTILE_WORK: usize = place(&VARIABLES, "energy.projectile");
const GEL_WORK: usize = place(&VARIABLES, "energy.gel");
const CLOSURE: usize = place(&VARIABLES, "energy.imbalance");
const MEMBRANE_SET: usize = place(&VARIABLES, "membrane_set");

/// Parameters that must be greater than zero.
const POSITIVE: [usize; 8] = [
    PROJECTILE_MASS,
    THICKNESS,
    YIELD_FORCE,
    STIFFNESS,
    BULGE_MASS,
    MEMBRANE_YIELD_FORCE,
    MEMBRANE_STIFFNESS,
    LONGEST_SUBSTEP,
];
/// Parameters that must not be negative.
const NOT_NEGATIVE: [usize; 6] = [NOSE, STAND_OFF, AREAL_DENSITY, INITIAL_HEIGHT, INITIAL_RADIUS, SPREAD];

/// Most substeps of a communication step: they take a quarter of a second. The default makes 10⁴ of a step of 1 ms.
const MOST_SUBSTEPS: f64 = 1e7;

/// Where the two masses are on their axis, and how fast.
#[derive(Debug, Clone, Copy)]
struct Motion {
    advance: f64,
    advance_rate: f64,
    height: f64,
    height_rate: f64,
}

/// Forces of plate and membrane, N.
#[derive(Debug, Clone, Copy)]
struct Forces {
    plate: f64,
    membrane: f64,
}

fn start(values: &mut [f64]) -> Result<(), String> {
    for index in POSITIVE {
        check(values, index, values[index] > 0.0, "a positive number")?;
    }
    for index in NOT_NEGATIVE {
        check(values, index, values[index] >= 0.0, "a number that is not negative")?;
    }
    values[FORCE..].fill(0.0);
    values[MEMBRANE_SET] = values[INITIAL_HEIGHT];
    values[MOVING_MASS] = values[BULGE_MASS];
    values[HEIGHT] = values[INITIAL_HEIGHT];
    (values[BULGE_HEIGHT], values[BULGE_RADIUS]) = (values[INITIAL_HEIGHT], values[INITIAL_RADIUS]);
    Ok(())
}

fn check(values: &[f64], index: usize, right: bool, expected: &str) -> Result<(), String> {
    if right && values[index].is_finite() {
        return Ok(());
    }
    let name = MODEL.scalars().nth(index).map_or("", |(variable, _)| variable.name);
    Err(format!("{name}: found {}, expected {expected}", values[index]))
}

fn step(values: &mut [f64], h: f64) -> Result<(), String> {
    let mut motion = Motion {
        advance: values[STAND_OFF] + values[THICKNESS] + values[NOSE] - values[PROJECTILE_POSITION + 2],
        advance_rate: -values[PROJECTILE_VELOCITY + 2],
        height: values[HEIGHT],
        height_rate: values[HEIGHT_RATE],
    };
    let gel_force = (values[BULGE_HEIGHT_IMPULSE] + values[SPREAD] * values[BULGE_RADIUS_IMPULSE]) / h;
    // A step that importers make of the difference of two times jitters by rounding: the number of substeps should not.
    let n = (h / values[LONGEST_SUBSTEP] - 1e-6).ceil().max(1.0);
    check_substeps(values, n, h)?;
    let before = values[PROJECTILE_IMPULSE];
    for _ in 0..n as usize {
        motion = substep(values, motion, gel_force, h / n);
    }
    if !motion.height.is_finite() {
        return Err(format!("the bulge has no finite height: shorten longest_substep, {} s", values[LONGEST_SUBSTEP]));
    }
    values[FORCE + 2] = (values[PROJECTILE_IMPULSE] - before) / h;
    show_bulge(values, motion, h);
    show_energy(values, motion);
    Ok(())
}

fn check_substeps(values: &[f64], n: f64, h: f64) -> Result<(), String> {
    if n <= MOST_SUBSTEPS {
        return Ok(());
    }
    let (found, shortest) = (values[LONGEST_SUBSTEP], h / MOST_SUBSTEPS);
    Err(format!(
        "longest_substep: found {found:e} s, which makes {n:e} substeps of a step of {h:e} s, expected at most \
         {MOST_SUBSTEPS:e}: set it to {shortest:e} s or more, or shorten the step"
    ))
}

/// Kick, drift, yield, kick, break, and the effect of each on the accounts.
fn substep(values: &mut [f64], from: Motion, gel_force: f64, dt: f64) -> Motion {
    let first = forces(values, from);
    let half = kick(values, from, first, (gel_force, dt / 2.0));
    let drifted =
        Motion { advance: half.advance + dt * half.advance_rate, height: half.height + dt * half.height_rate, ..half };
    give_way(values, drifted);
    let drifted = pick_up(values, drifted);
    let second = forces(values, drifted);
    let plate = f64::midpoint(first.plate, second.plate);
    let membrane = f64::midpoint(first.membrane, second.membrane);
    values[PROJECTILE_IMPULSE] += plate * dt;
    values[GEL_IMPULSE] += gel_force * dt;
    values[SUPPORT_IMPULSE] -= membrane * dt;
    values[PROJECTILE_WORK] += plate * (drifted.advance - from.advance);
    values[GEL_WORK] += gel_force * (drifted.height - from.height);
    let after = kick(values, drifted, second, (gel_force, dt / 2.0));
    rupture(values);
    if after.height < 0.0 { stop(values, after) } else { after }
}

fn kick(values: &[f64], motion: Motion, forces: Forces, (gel_force, dt): (f64, f64)) -> Motion {
    let on_bulge = forces.plate - forces.membrane + gel_force;
    Motion {
        advance_rate: motion.advance_rate - forces.plate / values[PROJECTILE_MASS] * dt,
        height_rate: motion.height_rate + on_bulge / values[MOVING_MASS] * dt,
        ..motion
    }
}

fn forces(values: &[f64], motion: Motion) -> Forces {
    let intact = 1.0 - values[PERFORATED];
    let plate = values[STIFFNESS] * plate_strain(values, motion);
    let membrane = values[MEMBRANE_STIFFNESS] * (motion.height - values[MEMBRANE_SET]);
    let (y, z) = (values[YIELD_FORCE], values[MEMBRANE_YIELD_FORCE]);
    Forces { plate: intact * plate.clamp(0.0, y), membrane: membrane.clamp(-z, z) }
}

/// Elastic part of the penetration, m.
fn plate_strain(values: &[f64], motion: Motion) -> f64 {
    motion.advance - (motion.height - values[INITIAL_HEIGHT]) - values[PENETRATION]
}

/// Plate and membrane yield where they are strained beyond their limit.
fn give_way(values: &mut [f64], motion: Motion) {
    let (y, z) = (values[YIELD_FORCE], values[MEMBRANE_YIELD_FORCE]);
    let beyond = |strain: f64, limit: f64| (strain.abs() - limit).max(0.0).copysign(strain);
    let membrane = beyond(motion.height - values[MEMBRANE_SET], z / values[MEMBRANE_STIFFNESS]);
    values[MEMBRANE_SET] += membrane;
    values[PLASTIC] += z * membrane.abs();
    if values[PERFORATED] == 1.0 {
        return;
    }
    let plate = beyond(plate_strain(values, motion).max(0.0), y / values[STIFFNESS]);
    values[PENETRATION] += plate;
    values[PLASTIC] += y * plate;
}

/// The bulge picks up the armour that its base has reached: momentum is kept, and the energy of the impact is lost.
fn pick_up(values: &mut [f64], motion: Motion) -> Motion {
    let (first, mass) = (values[INITIAL_RADIUS], values[MOVING_MASS]);
    let area = PI * (base_radius(values, motion.height).powi(2) - first.powi(2));
    let grown = values[BULGE_MASS] + values[AREAL_DENSITY] * area;
    if grown <= mass {
        return motion;
    }
    let height_rate = motion.height_rate * mass / grown;
    values[PLASTIC] += mass * motion.height_rate * (motion.height_rate - height_rate) / 2.0;
    values[MOVING_MASS] = grown;
    Motion { height_rate, ..motion }
}

/// Base radius of a bulge of this height, m.
fn base_radius(values: &[f64], height: f64) -> f64 {
    values[INITIAL_RADIUS] + values[SPREAD] * (height - values[INITIAL_HEIGHT])
}

/// The plate breaks once the hole is as deep as it is thick: after the kicks of a substep, so that both have the same
/// force.
fn rupture(values: &mut [f64]) {
    if values[PERFORATED] == 0.0 && values[PENETRATION] >= values[THICKNESS] {
        values[PERFORATED] = 1.0;
        values[PLASTIC] += values[YIELD_FORCE].powi(2) / values[STIFFNESS] / 2.0;
    }
}

/// The back of the plate is as far as the bulge goes back: it stays there, and what it had is lost.
fn stop(values: &mut [f64], motion: Motion) -> Motion {
    let stopped = Motion { height: 0.0, height_rate: motion.height_rate.max(0.0), ..motion };
    let lost = |values: &[f64], motion| kinetic(values, motion) + elastic(values, motion);
    values[PLASTIC] += lost(values, motion) - lost(values, stopped);
    values[SUPPORT_IMPULSE] += values[MOVING_MASS] * (stopped.height_rate - motion.height_rate);
    stopped
}

fn kinetic(values: &[f64], motion: Motion) -> f64 {
    values[MOVING_MASS] * motion.height_rate.powi(2) / 2.0
}

fn elastic(values: &[f64], motion: Motion) -> f64 {
    let Forces { plate, membrane } = forces(values, motion);
    plate * plate / values[STIFFNESS] / 2.0 + membrane * membrane / values[MEMBRANE_STIFFNESS] / 2.0
}

/// The bulge at the start of a step of length h and its mean rate: the gel moves it on without a gap.
fn show_bulge(values: &mut [f64], end: Motion, h: f64) {
    let (start, spread) = (values[HEIGHT], values[SPREAD]);
    let rate = (end.height - start) / h;
    let radius = base_radius(values, start);
    (values[BULGE_HEIGHT], values[BULGE_RADIUS]) = (start, radius);
    (values[BULGE_HEIGHT_RATE], values[BULGE_RADIUS_RATE]) = (rate, spread * rate);
    (values[HEIGHT], values[HEIGHT_RATE]) = (end.height, end.height_rate);
    values[MOMENTUM] = values[MOVING_MASS] * end.height_rate;
}

fn show_energy(values: &mut [f64], motion: Motion) {
    values[KINETIC] = kinetic(values, motion);
    values[ELASTIC] = elastic(values, motion);
    values[CLOSURE] = values[KINETIC] + values[ELASTIC] + values[PLASTIC] - values[PROJECTILE_WORK] - values[GEL_WORK];
}
