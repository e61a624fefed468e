//! A rigid body that owns its state and is moved by what the gel gives back, and by a force and torque of its own.
//!
//! Over a step of length H, with the gel's J, A and S of the same step:
//!
//! ```text
//! x₁ = x₀ + v₀ H + ½ F H²/m + S/m        v₁ = v₀ + (F H + J)/m        L₁ = L₀ + T H + A
//! ```
//!
//! and q₁ is the orientation that the gel predicts, for it cannot be rebuilt from A. A zero quaternion says that there is
//! none: then the body turns on with its angular velocity, which is of first order in H.

use super::table::{Model, Variable, place};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// The partner.
pub const MODEL: Model = Model {
    name: "RigidBody",
    description: "A rigid projectile that owns its state and is moved by impulses",
    variables: &VARIABLES,
    start,
    step,
};

/// How far from 1 the norm of an orientation may be, as for the gel.
const NORM_TOLERANCE: f64 = 1e-3;

/// The starts of the parameters are those of the gel's built-in scene `sphere-block`: a homogeneous sphere of 20 mm.
const VARIABLES: [Variable; 18] = [
    Variable::parameter("mass", "kg", &[0.033], "Mass"),
    Variable::parameter(
        "inertia",
        "kg.m2",
        &[1.32e-6, 1.32e-6, 1.32e-6, 0.0, 0.0, 0.0],
        "Inertia tensor about the centre of mass in the body frame: xx yy zz xy xz yz",
    ),
    Variable::parameter("initial_position", "m", &[0.0, 0.0, 0.010], "Position of the centre of mass at the start"),
    Variable::parameter("initial_velocity", "m/s", &[0.0, 0.0, -5.0], "Velocity at the start"),
    Variable::parameter("initial_orientation", "1", &[1.0, 0.0, 0.0, 0.0], "Orientation (w, x, y, z) at the start"),
    Variable::parameter("initial_angular_velocity", "rad/s", &[0.0, 0.0, 0.0], "Angular velocity at the start"),
    Variable::input("impulse", "N.s", 3, "Impulse of the gel on the body in the step"),
    Variable::input("angular_impulse", "N.m.s", 3, "Angular impulse of the gel about the centre of mass in the step"),
    Variable::input("impulse_moment", "N.s2", 3, "First moment of the impulses about the end of the step"),
    Variable::input("predicted_orientation", "1", 4, "Orientation at the end of the step; zero: not known"),
    Variable::input("force", "N", 3, "Every other force on the body, constant over the step"),
    Variable::input("torque", "N.m", 3, "Every other torque on the body, constant over the step"),
    Variable::output("position", "m", 3, "Position of the centre of mass"),
    Variable::output("velocity", "m/s", 3, "Velocity of the centre of mass"),
    Variable::output("orientation", "1", 4, "Orientation (w, x, y, z)"),
    Variable::output("angular_velocity", "rad/s", 3, "Angular velocity in the world frame"),
    Variable::output("total_impulse", "N.s", 3, "Sum of the impulses that moved the body"),
    Variable::local("angular_momentum", "N.m.s", 3, "Angular momentum about the centre of mass"),
];

const MASS: usize = place(&VARIABLES, "mass");
const INERTIA: usize = place(&VARIABLES, "inertia");
const INITIAL_POSITION: usize = place(&VARIABLES, "initial_position");
const INITIAL_VELOCITY: usize = place(&VARIABLES, "initial_velocity");
const INITIAL_ORIENTATION: usize = place(&VARIABLES, "initial_orientation");
const INITIAL_ANGULAR_VELOCITY: usize = place(&VARIABLES, "initial_angular_velocity");
const IMPULSE: usize = place(&VARIABLES, "impulse");
const ANGULAR_IMPULSE: usize = place(&VARIABLES, "angular_impulse");
const IMPULSE_MOMENT: usize = place(&VARIABLES, "impulse_moment");
const PREDICTED_ORIENTATION: usize = place(&VARIABLES, "predicted_orientation");
const FORCE: usize = place(&VARIABLES, "force");
const TORQUE: usize = place(&VARIABLES, "torque");
const POSITION: usize = place(&VARIABLES, "position");
const VELOCITY: usize = place(&VARIABLES, "velocity");
const ORIENTATION: usize = place(&VARIABLES, "orientation");
const ANGULAR_VELOCITY: usize = place(&VARIABLES, "angular_velocity");
const TOTAL_IMPULSE: usize = place(&VARIABLES, "total_impulse");
const ANGULAR_MOMENTUM: usize = place(&VARIABLES, "angular_momentum");

fn start(values: &mut [f64]) -> Result<(), String> {
    let mass = values[MASS];
    if !(mass.is_finite() && mass > 0.0) {
        return Err(format!("mass: found {mass} kg, expected a positive number; set it to the gel's effective_mass"));
    }
    if inertia(values).cholesky().is_none() {
        let found = &values[INERTIA..][..6];
        return Err(format!("inertia: found {found:?} kg.m2, expected a positive definite tensor xx yy zz xy xz yz"));
    }
    let q = orientation(values, INITIAL_ORIENTATION)?
        .ok_or("initial_orientation: found zero, expected a unit quaternion (w, x, y, z)")?;
    let spin = inertia_in_world(values, q) * three(values, INITIAL_ANGULAR_VELOCITY);
    put(values, POSITION, three(values, INITIAL_POSITION));
    put(values, VELOCITY, three(values, INITIAL_VELOCITY));
    put(values, TOTAL_IMPULSE, Vector3::zeros());
    turn(values, q, spin);
    Ok(())
}

fn step(values: &mut [f64], h: f64) -> Result<(), String> {
    let m = values[MASS];
    let (x, v) = (three(values, POSITION), three(values, VELOCITY));
    let (j, s, f) = (three(values, IMPULSE), three(values, IMPULSE_MOMENT), three(values, FORCE));
    let l = three(values, ANGULAR_MOMENTUM) + three(values, TORQUE) * h + three(values, ANGULAR_IMPULSE);
    let predicted = orientation(values, PREDICTED_ORIENTATION)?;
    let q = predicted.map_or_else(|| turned_on(values, h), Ok)?;
    put(values, POSITION, x + v * h + (f * (h * h / 2.0) + s) / m);
    put(values, VELOCITY, v + (f * h + j) / m);
    put(values, TOTAL_IMPULSE, three(values, TOTAL_IMPULSE) + j);
    turn(values, q, l);
    Ok(())
}

/// Orientation after turning with the present angular velocity for a time h.
fn turned_on(values: &[f64], h: f64) -> Result<UnitQuaternion<f64>, String> {
    let present = orientation(values, ORIENTATION)?.ok_or("the body has no orientation yet: it was not initialised")?;
    Ok(UnitQuaternion::from_scaled_axis(three(values, ANGULAR_VELOCITY) * h) * present)
}

/// Writes orientation, angular momentum and the angular velocity that goes with them.
fn turn(values: &mut [f64], q: UnitQuaternion<f64>, l: Vector3<f64>) {
    values[ORIENTATION..][..4].copy_from_slice(&[q.w, q.i, q.j, q.k]);
    put(values, ANGULAR_MOMENTUM, l);
    let body = q.inverse() * l;
    let spin = inertia(values).cholesky().map_or(Vector3::zeros(), |inertia| inertia.solve(&body));
    put(values, ANGULAR_VELOCITY, q * spin);
}

/// The unit quaternion at a place; none if it is zero.
fn orientation(values: &[f64], at: usize) -> Result<Option<UnitQuaternion<f64>>, String> {
    let [w, x, y, z] = std::array::from_fn(|i| values[at + i]);
    let q = Quaternion::new(w, x, y, z);
    if q.norm() == 0.0 {
        return Ok(None);
    }
    if (q.norm() - 1.0).abs() <= NORM_TOLERANCE {
        return Ok(Some(UnitQuaternion::new_normalize(q)));
    }
    Err(format!(
        "orientation: found ({w}, {x}, {y}, {z}) of norm {}, expected a unit quaternion (w, x, y, z)",
        q.norm()
    ))
}

fn inertia(values: &[f64]) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|i| values[INERTIA + i]);
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

fn inertia_in_world(values: &[f64], q: UnitQuaternion<f64>) -> Matrix3<f64> {
    let r = q.to_rotation_matrix();
    r * inertia(values) * r.transpose()
}

fn three(values: &[f64], at: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&values[at..][..3])
}

fn put(values: &mut [f64], at: usize, vector: Vector3<f64>) {
    values[at..][..3].copy_from_slice(vector.as_slice());
}
