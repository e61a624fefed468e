//! Start values of the partners from the bodies of a scene, and whether the partners can go with it.

use crate::description::scalar_name;
use crate::table::{Model, place};
use crate::{body, plate};
use serde_json::Value;

/// Name and value of parameters and inputs of a partner.
type Starts = Vec<(String, f64)>;

/// A nose may be this much inside the plate, m: positions and lengths in a scene are rounded numbers.
const ROUND_OFF: f64 = 1e-9;

/// Start values of a rigid body: a body of the scene, the projectile first, as the gel takes it.
pub fn body_starts(bodies: &[Value], body: usize) -> Result<Vec<f64>, String> {
    let described = &bodies[body];
    if described["fixed"] == true {
        let name = if body == 0 { "projectile".to_owned() } else { format!("fragment[{body}]") };
        return Err(format!("{name}.fixed: found true, expected a body that moves: its partner owns the motion"));
    }
    let mut starts = vec![];
    for (name, key) in [
        ("mass", "mass"),
        ("inertia", "inertia"),
        ("initial_position", "position"),
        ("initial_velocity", "velocity"),
        ("initial_orientation", "orientation"),
        ("initial_angular_velocity", "angular_velocity"),
    ] {
        starts.extend(scalars(name, &numbers(&described[key])));
    }
    starts_with(&body::MODEL, body::MODEL.values(), &starts)
}

/// Start values of an armour with these parameters: the projectile that it meets, and the dome that is its back face.
pub fn armour_starts(bodies: &[Value], parameters: Vec<f64>) -> Result<Vec<f64>, String> {
    let (height, radius) = back_face(bodies)?;
    let projectile = &bodies[0];
    let position = numbers(&projectile["position"]);
    // The projectile reaches down from its centre of mass by its nose.
    let nose = -number(&projectile["extent"]["min"][2]);
    let mut starts = scalars("projectile_mass", &numbers(&projectile["mass"]));
    for (name, values) in [
        ("nose", &[nose] as &[f64]),
        ("initial_height", &[height]),
        ("initial_radius", &[radius]),
        ("projectile.position", &position),
        ("projectile.velocity", &numbers(&projectile["velocity"])),
    ] {
        starts.extend(scalars(name, values));
    }
    let starts = starts_with(&plate::MODEL, parameters, &starts)?;
    let thickness = starts[place(plate::MODEL.variables, "thickness")];
    let lowest = position[2] - nose;
    if lowest < thickness - ROUND_OFF {
        return Err(format!(
            "projectile.position: found its lowest point at z = {lowest} m, expected {thickness} m or more: the plate is \
             {thickness} m thick in front of z = 0, and the projectile must not start inside it"
        ));
    }
    Ok(starts)
}

/// Height and base radius of the dome at the start, m.
fn back_face(bodies: &[Value]) -> Result<(f64, f64), String> {
    let expected = "expected a dome with fixed = true, active, upright, its base at z = 0: the back face of the plate";
    let first = bodies.get(1).ok_or_else(|| format!("[[fragment]]: found none, {expected}"))?;
    let dome = &first["shape"]["dome"];
    for (key, is_right) in [
        ("shape", dome.is_object()),
        ("fixed", first["fixed"] == true),
        ("active", first["active"] == true),
        ("position", number(&first["position"][2]) == 0.0),
        ("orientation", numbers(&first["orientation"])[1..3] == [0.0, 0.0]),
    ] {
        if !is_right {
            return Err(format!("fragment[1].{key}: found {}, {expected}", first[key]));
        }
    }
    Ok((number(&dome["height"]), number(&dome["radius"])))
}

/// Returns a number of the description of a body; it says null where there is no finite number.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::INFINITY)
}

/// Returns a number, or a list of them, as a list.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map_or_else(|| vec![number(value)], |list| list.iter().map(number).collect())
}

/// Names the components of a value.
fn scalars(name: &str, values: &[f64]) -> Starts {
    values.iter().enumerate().map(|(i, value)| (scalar_name(name, values.len(), i), *value)).collect()
}

/// Start values of all components of a partner with these among them, if it takes them.
fn starts_with(model: &Model, mut values: Vec<f64>, starts: &Starts) -> Result<Vec<f64>, String> {
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
