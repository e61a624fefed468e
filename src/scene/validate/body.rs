//! Validation of a projectile: shape, mass, inertia and initial position.

use super::domain::{CheckResult, all_finite, positive, require};
use super::{expansion, shape};
use crate::geometry::SignedDistance;
use crate::math::{Tensor3, Vector3};
use crate::scene::{BodyShape, GelShape, ProjectileSpec, Scene, SceneError};
use nalgebra::{Quaternion, UnitQuaternion};

pub(super) fn check(scene: &Scene) -> CheckResult {
    let body = &scene.projectile;
    shape::check(&body.shape, scene.scene.dimension)?;
    expansion::check(body, scene.scene.dimension)?;
    all_finite("projectile.position", &body.position)?;
    all_finite("projectile.velocity", &body.velocity)?;
    all_finite("projectile.angular_velocity", &body.angular_velocity)?;
    check_orientation(body.orientation)?;
    if body.fixed {
        check_fixed(body)?;
    } else {
        check_moving(body)?;
    }
    check_position(scene)
}

/// Rotation from the frame of the body to the world.
pub(super) fn rotation(body: &ProjectileSpec) -> UnitQuaternion<f64> {
    let [w, x, y, z] = body.orientation;
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

fn check_orientation(q: [f64; 4]) -> CheckResult {
    const SLACK: f64 = 1e-3;
    let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    let good = (norm - 1.0).abs() <= SLACK;
    let found = || format!("{q:?} of norm {norm:?}");
    require(good, "projectile.orientation", found, "a quaternion [w, x, y, z] of norm 1, within 1e-3")
}

fn check_fixed(body: &ProjectileSpec) -> CheckResult {
    const EXPECTED: &str = "nothing: the body is fixed";
    let absent =
        |given: Option<String>, key| given.map_or(Ok(()), |found| Err(SceneError::value(key, found, EXPECTED)));
    absent(body.mass.map(|mass| format!("{mass:?}")), "projectile.mass")?;
    absent(body.density.map(|density| format!("{density:?}")), "projectile.density")?;
    absent(body.inertia.map(|inertia| format!("{inertia:?}")), "projectile.inertia")?;
    let still = |v: [f64; 3], key| require(v == [0.0; 3], key, || format!("{v:?}"), "zero: the body is fixed");
    still(body.velocity, "projectile.velocity")?;
    still(body.angular_velocity, "projectile.angular_velocity")
}

fn check_moving(body: &ProjectileSpec) -> CheckResult {
    const EXPECTED: &str = "a positive mass, kg, or fixed = true";
    let unbounded = matches!(body.shape, BodyShape::HalfSpace { .. } | BodyShape::Dome { .. });
    body.density.map_or(Ok(()), |density| positive("projectile.density", density, "a positive density, kg/m3"))?;
    match (body.mass, body.density) {
        (Some(mass), _) => positive("projectile.mass", mass, EXPECTED)?,
        (None, Some(_)) if !unbounded => {}
        (None, _) => return Err(SceneError::value("projectile.mass", "nothing", EXPECTED)),
    }
    match (body.inertia, &body.shape) {
        (Some(inertia), _) => check_inertia(&inertia),
        (None, BodyShape::HalfSpace { .. } | BodyShape::Dome { .. }) => {
            let expected = "six numbers, [xx, yy, zz, xy, xz, yz], kg m2: an unbounded body has no inertia of its own";
            Err(SceneError::value("projectile.inertia", "nothing", expected))
        }
        (
            None,
            BodyShape::Sphere { .. }
            | BodyShape::Cylinder { .. }
            | BodyShape::Capsule { .. }
            | BodyShape::Bullet(_)
            | BodyShape::Mushroom(_)
            | BodyShape::Plate { .. }
            | BodyShape::Chisel(_)
            | BodyShape::Stl(_),
        ) => Ok(()),
    }
}

/// Checks an inertia tensor: its principal moments are positive, and none exceeds the sum of the others.
fn check_inertia(inertia: &[f64; 6]) -> CheckResult {
    const ROUND_OFF: f64 = 1e-9;
    /// Least principal moment, kg·m²: its inverse and the products with that must stay finite.
    const SMALLEST: f64 = 1e-30;
    let key = "projectile.inertia";
    all_finite(key, inertia)?;
    let [xx, yy, zz, xy, xz, yz] = *inertia;
    let moments = Tensor3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz).symmetric_eigenvalues();
    let (least, most, sum) = (moments.min(), moments.max(), moments.sum());
    let found = || format!("{inertia:?} with a principal moment of {least:?}");
    require(least >= SMALLEST, key, found, "positive principal moments, at least 1e-30 kg m2")?;
    let found = || format!("{inertia:?} with principal moments {:?}", moments.as_slice());
    let expected = "no principal moment above the sum of the other two";
    require(most <= (sum - most) * (1.0 + ROUND_OFF), key, found, expected)
}

/// Depth at which a projectile that starts inside the gel is refused, in cells: the transient penetration that
/// contact allows.
const TOUCHING: f64 = 0.1;

/// Sine of a tilt up to which a body counts as upright.
const UPRIGHT: f64 = 1e-9;

/// Remedy of a body that starts in the gel or behind it, for example by a height of the wrong sign.
const ABOVE: &str = "a start outside the gel or just touching it; its surface is z = 0 and the gel is below it, all in metres, so that a \
                     projectile above it has a positive z";

/// Checks that a bounded body starts above the gel, touching it, or beside it; only a fixed body may be under the
/// gel.
fn check_position(scene: &Scene) -> CheckResult {
    let body = &scene.projectile;
    if !body.active || matches!(body.shape, BodyShape::HalfSpace { .. } | BodyShape::Dome { .. }) {
        return Ok(());
    }
    let Some(column) = column_at(&scene.gel.shape, body.position) else { return Ok(()) };
    let height = body.position[2];
    let beyond = || format!("{:?}, at or below the back face of the gel, z = {:?}", body.position, column.bottom);
    require(height > column.bottom || body.fixed, "projectile.position", beyond, ABOVE)?;
    let down = rotation(body).inverse_transform_vector(&-Vector3::z());
    // The foremost point of a tilted body may be beside the gel: the mesh is checked node by node later.
    if column.is_hollow || down.x.hypot(down.y) > UPRIGHT {
        return Ok(());
    }
    let depth = scene.shape(0).reach(&down) - height;
    let inside = depth > TOUCHING * scene.mesh.size && height > column.bottom;
    let found = || format!("{:?}, the foremost point {depth:.3e} m deep in the gel", body.position);
    require(!inside, "projectile.position", found, ABOVE)
}

/// Undisturbed gel above and below a point.
struct GelColumn {
    /// Height of the back face, m.
    bottom: f64,
    /// True if the gel leaves room for a body there: a bore, a cavity.
    is_hollow: bool,
}

/// Column of gel along z through `position`; `None` outside the outline of a block, a cylinder or a shell.
fn column_at(gel: &GelShape, [x, y, _]: [f64; 3]) -> Option<GelColumn> {
    match gel {
        GelShape::Block { size } => {
            let under = x.abs() < 0.5 * size[0] && (size.len() == 2 || y.abs() < 0.5 * size[1]);
            under.then(|| GelColumn { bottom: -size[size.len() - 1], is_hollow: false })
        }
        GelShape::Cylinder { radius, height, bore } => {
            (x.hypot(y) < *radius).then(|| GelColumn { bottom: -height, is_hollow: bore.is_some() })
        }
        GelShape::Shell { outer, .. } => (x.hypot(y) < *outer).then(|| GelColumn { bottom: -outer, is_hollow: true }),
        GelShape::LBeam { .. } => None,
    }
}
