//! The systems: gel and body, and gel, armour and body.

use crate::structure::{Unit, Wire};
use ballistic_gel::fmi2;
use ballistic_gel::scene::{self, Scene};

/// Units of a gel, its FMU in this file, and body.
pub fn gel_and_body(scene: &Scene, file: &'static str) -> Result<Vec<Unit>, String> {
    let watched = vec![("contact.total_impulse", 3, "N.s"), ("projectile.predicted_velocity", 3, "m/s")];
    let gel = Unit { name: "gel", file, starts: vec![], watched };
    let watched = vec![("total_impulse", 3, "N.s")];
    Ok(vec![gel, Unit { name: "body", file: "RigidBody.fmu", starts: projectile(scene)?, watched }])
}

/// Units of armour, gel and body. The plate steps first: what it gives belongs to the step that it has just made.
pub fn gel_armour_and_body(scene: &Scene, file: &'static str) -> Result<Vec<Unit>, String> {
    let mut units = gel_and_body(scene, file)?;
    let mass = units[1].starts.iter().filter(|(name, _)| name == "mass");
    let starts = mass.map(|(_, mass)| ("projectile_mass".to_owned(), *mass)).collect();
    let watched = vec![("penetration", 1, "m"), ("perforated", 1, "1"), ("energy.closure", 1, "J")];
    units.insert(0, Unit { name: "armour", file: "Armour.fmu", starts, watched });
    Ok(units)
}

/// Wires between gel and body.
pub fn gel_and_body_wires() -> Vec<Wire> {
    let wire = |from, to, size, unit| Wire { from, to, size, unit };
    vec![
        wire(("gel", "contact.impulse"), ("body", "impulse"), 3, "N.s"),
        wire(("gel", "contact.angular_impulse"), ("body", "angular_impulse"), 3, "N.m.s"),
        wire(("gel", "contact.impulse_moment"), ("body", "impulse_moment"), 3, "N.s2"),
        wire(("gel", "projectile.predicted_orientation"), ("body", "predicted_orientation"), 4, "1"),
        wire(("body", "position"), ("gel", "projectile.position"), 3, "m"),
        wire(("body", "velocity"), ("gel", "projectile.velocity"), 3, "m/s"),
        wire(("body", "orientation"), ("gel", "projectile.orientation"), 4, "1"),
        wire(("body", "angular_velocity"), ("gel", "projectile.angular_velocity"), 3, "rad/s"),
    ]
}

/// Wires between armour, gel and body. The dome is the gel's first fragment.
pub fn gel_armour_and_body_wires() -> Vec<Wire> {
    let wire = |from, to, size, unit| Wire { from, to, size, unit };
    let mut wires = gel_and_body_wires();
    wires.extend([
        wire(("gel", "projectile.predicted_position"), ("armour", "projectile.position"), 3, "m"),
        wire(("gel", "projectile.predicted_velocity"), ("armour", "projectile.velocity"), 3, "m/s"),
        wire(("armour", "force"), ("gel", "projectile.external_force"), 3, "N"),
        wire(("armour", "force"), ("body", "force"), 3, "N"),
        wire(("armour", "bulge_height"), ("gel", "fragment[1].bulge_height"), 1, "m"),
        wire(("armour", "bulge_radius"), ("gel", "fragment[1].bulge_radius"), 1, "m"),
        wire(("armour", "bulge_height_rate"), ("gel", "fragment[1].bulge_height_rate"), 1, "m/s"),
        wire(("armour", "bulge_radius_rate"), ("gel", "fragment[1].bulge_radius_rate"), 1, "m/s"),
        wire(("gel", "fragment[1].contact.bulge_height_impulse"), ("armour", "bulge_height_impulse"), 1, "N.s"),
        wire(("gel", "fragment[1].contact.bulge_radius_impulse"), ("armour", "bulge_radius_impulse"), 1, "N.s"),
    ]);
    wires
}

/// Parameters of the body: the projectile of the scene.
fn projectile(scene: &Scene) -> Result<Vec<(String, f64)>, String> {
    let table = fmi2::table_of(scene);
    let projectile = table.get("projectile").ok_or("the scene has no [projectile]")?;
    let mass = projectile.get("mass").and_then(toml::Value::as_float).ok_or("projectile.mass: the body needs one")?;
    let mut starts = vec![("mass".to_owned(), mass)];
    let inertia = inertia(projectile, mass)?;
    for (name, key) in [
        ("initial_position", "position"),
        ("initial_velocity", "velocity"),
        ("initial_orientation", "orientation"),
        ("initial_angular_velocity", "angular_velocity"),
    ] {
        let values = projectile.get(key).and_then(toml::Value::as_array).into_iter().flatten();
        let values = values.filter_map(toml::Value::as_float).enumerate();
        starts.extend(values.map(|(i, value)| (format!("{name}[{}]", i + 1), value)));
    }
    starts.extend(inertia.iter().enumerate().map(|(i, value)| (format!("inertia[{}]", i + 1), *value)));
    Ok(starts)
}

/// The scene's inertia, or that of a homogeneous sphere.
fn inertia(projectile: &toml::Value, mass: f64) -> Result<Vec<f64>, String> {
    if let Some(given) = projectile.get("inertia").and_then(toml::Value::as_array) {
        return Ok(given.iter().filter_map(toml::Value::as_float).collect());
    }
    let sphere = projectile.get("shape").and_then(|shape| shape.get("sphere"));
    let radius = sphere.and_then(|sphere| sphere.get("radius")).and_then(toml::Value::as_float);
    let radius =
        radius.ok_or("projectile.inertia: not given, and known here for a sphere alone; give it in the scene")?;
    let i = 0.4 * mass * radius * radius;
    Ok(vec![i, i, i, 0.0, 0.0, 0.0])
}

/// The scene of this name or in this file.
pub fn scene_of(named: &str) -> Result<Scene, String> {
    let text = match scene::builtin(named) {
        Some(text) => text.to_owned(),
        None => std::fs::read_to_string(named).map_err(|error| format!("scene {named}: {error}"))?,
    };
    scene::read(&text).map_err(|error| error.to_string())
}
