//! What the partners need to know of a scene, and whether they can go with it.

use crate::description::scalar_name;
use crate::table::{Model, place};
use crate::{body, plate};
use ballistic_gel::fmi2;
use ballistic_gel::geometry::SignedDistance;
use ballistic_gel::math::Vector3;
use ballistic_gel::scene::{self, BodyShape, Scene};
use ballistic_gel::simulation::Simulation;
use nalgebra::{Quaternion, UnitQuaternion};
use std::path::Path;

/// Name and value of parameters and inputs of a partner.
type Starts = Vec<(String, f64)>;

/// A nose may be this much inside the plate, m: positions and lengths in a scene are rounded numbers.
const ROUND_OFF: f64 = 1e-9;

/// The scene of this name or in this file, with the files that it names.
pub fn read(named: &str) -> Result<Scene, String> {
    let text = match scene::builtin(named) {
        Some(text) => text.to_owned(),
        None => std::fs::read_to_string(named).map_err(|error| format!("scene {named}: {error}"))?,
    };
    let folder = Path::new(named).parent().unwrap_or(Path::new(""));
    scene::read_with_files(&text, &fmi2::scene_file_reader(folder)).map_err(|error| format!("scene {named}: {error}"))
}

/// Start values of the body: the projectile of the scene, as the gel takes it.
pub fn body_starts(scene: &Scene) -> Result<Vec<f64>, String> {
    let projectile = &scene.projectile;
    if projectile.fixed {
        return Err(
            "projectile.fixed: found true, expected a projectile that moves: the body owns its motion".to_owned()
        );
    }
    let simulation = Simulation::new(scene, scene.coupling.mode, 1).map_err(|error| error.to_string())?;
    let (mass, inertia) = simulation.inertia(0);
    let mut starts = vec![("mass".to_owned(), mass)];
    for (name, values) in [
        ("inertia", inertia.as_slice()),
        ("initial_position", &projectile.position),
        ("initial_velocity", &projectile.velocity),
        ("initial_orientation", &projectile.orientation),
        ("initial_angular_velocity", &projectile.angular_velocity),
    ] {
        starts.extend(values.iter().enumerate().map(|(i, value)| (scalar_name(name, values.len(), i), *value)));
    }
    starts_with(&body::MODEL, &starts)
}

/// Start values of the armour: the projectile that it meets, and the dome that is its back face.
pub fn armour_starts(scene: &Scene) -> Result<Vec<f64>, String> {
    let (height, radius) = back_face(scene)?;
    let mass = Simulation::new(scene, scene.coupling.mode, 1).map_err(|error| error.to_string())?.inertia(0).0;
    let nose = nose(scene);
    let starts = [("projectile_mass", mass), ("nose", nose), ("initial_height", height), ("initial_radius", radius)];
    let mut starts: Starts = starts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    for (name, values) in
        [("projectile.position", scene.projectile.position), ("projectile.velocity", scene.projectile.velocity)]
    {
        starts.extend(values.iter().enumerate().map(|(i, value)| (scalar_name(name, values.len(), i), *value)));
    }
    let starts = starts_with(&plate::MODEL, &starts)?;
    let thickness = starts[place(plate::MODEL.variables, "thickness")];
    let lowest = scene.projectile.position[2] - nose;
    if lowest < thickness - ROUND_OFF {
        return Err(format!(
            "projectile.position: found its lowest point at z = {lowest} m, expected {thickness} m or more: the plate is \
             {thickness} m thick in front of z = 0, and the projectile must not start inside it"
        ));
    }
    Ok(starts)
}

/// Height and base radius of the dome at the start, m.
fn back_face(scene: &Scene) -> Result<(f64, f64), String> {
    let expected = "expected a dome with fixed = true, active, upright, its base at z = 0: the back face of the plate";
    let first = scene.fragment.first().ok_or_else(|| format!("[[fragment]]: found none, {expected}"))?;
    let BodyShape::Dome { height, radius } = first.shape else {
        return Err(format!("fragment[1].shape: found {:?}, {expected}", first.shape));
    };
    let [w, x, y, _] = first.orientation;
    for (key, found, right) in [
        ("fixed", first.fixed.to_string(), first.fixed),
        ("active", first.active.to_string(), first.active),
        ("position", format!("{:?}", first.position), first.position[2] == 0.0),
        ("orientation", format!("{:?}", first.orientation), x == 0.0 && y == 0.0 && w.is_finite()),
    ] {
        if !right {
            return Err(format!("fragment[1].{key}: found {found}, {expected}"));
        }
    }
    Ok((height, radius))
}

/// How far the projectile reaches down from its centre of mass at the start, m.
fn nose(scene: &Scene) -> f64 {
    let [w, x, y, z] = scene.projectile.orientation;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    scene.shape(0).reach(&(turn.inverse() * -Vector3::z()))
}

/// Start values of all components of a partner with these among them, if it takes them.
fn starts_with(model: &Model, starts: &Starts) -> Result<Vec<f64>, String> {
    let mut values = model.values();
    for ((variable, at), value) in model.scalars().zip(&mut values) {
        let name = scalar_name(variable.name, variable.start.len(), at);
        if let Some((_, start)) = starts.iter().find(|(known, _)| *known == name) {
            *value = *start;
        }
    }
    let started = (model.start)(&mut values.clone());
    started.map_err(|error| format!("{} does not take this scene: {error}", model.name))?;
    Ok(values)
}
