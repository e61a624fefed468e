//! Validation of motion: bodies and gel of a two-dimensional scene stay in its plane or on its axis.

use super::body::rotation;
use super::domain::{CheckResult, require};
use crate::math::Vector3;
use crate::scene::{BodyShape, Dimension, GelShape, GelSymmetry, ProjectileSpec, Scene, SceneError};

const IN_PLANE: &str = "no motion out of the plane: a planar scene has y = 0; use dimension = \"spatial\"";
const ON_AXIS: &str = "no motion off the axis: an axisymmetric scene has x = y = 0; use dimension = \"spatial\"";
const TURN_IN_PLANE: &str = "no turn out of the plane: a planar scene turns about y; use dimension = \"spatial\"";
const UPRIGHT: &str = "an upright projectile: an axisymmetric scene has its axis along z; use dimension = \"spatial\"";
const IN_PART: &str = "motion that keeps gel.symmetry: with \"half\" bodies translate and rotate in the plane y = 0, \
                       with \"quarter\" they translate along z; or gel.symmetry = \"none\"";
const STILL: &str = "no rotation: an axisymmetric scene has none; use dimension = \"spatial\"";

/// Round-off of a component of a rotated unit vector.
const ROUND_OFF: f64 = 1e-9;

pub(super) fn check(scene: &Scene) -> CheckResult {
    let mirrored = |e: SceneError| e.expecting(IN_PART);
    match (scene.scene.dimension, scene.gel.symmetry) {
        (Dimension::Planar, _) => check_planar(scene),
        (Dimension::Axisymmetric, _) => check_axisymmetric(scene),
        (Dimension::Spatial, GelSymmetry::None) => Ok(()),
        (Dimension::Spatial, GelSymmetry::Half) => check_planar(scene).map_err(mirrored),
        (Dimension::Spatial, GelSymmetry::Quarter) => check_axisymmetric(scene).map_err(mirrored),
    }
}

fn check_planar(scene: &Scene) -> CheckResult {
    let body = &scene.projectile;
    let in_plane = |v: [f64; 3], key| require(v[1] == 0.0, key, || format!("{v:?}"), IN_PLANE);
    in_plane(scene.gel.velocity, "gel.velocity")?;
    if let GelShape::LBeam { corner, .. } = scene.gel.shape {
        in_plane(corner, "gel.shape.l-beam.corner")?;
    }
    in_plane(body.position, "projectile.position")?;
    in_plane(body.velocity, "projectile.velocity")?;
    let turn = body.angular_velocity;
    let good = turn[0] == 0.0 && turn[2] == 0.0;
    require(good, "projectile.angular_velocity", || format!("{turn:?}"), TURN_IN_PLANE)?;
    check_planar_body(body)
}

fn check_planar_body(body: &ProjectileSpec) -> CheckResult {
    let [_, x, _, z] = body.orientation;
    let q = || format!("{:?}", body.orientation);
    require(x.abs() <= ROUND_OFF && z.abs() <= ROUND_OFF, "projectile.orientation", q, TURN_IN_PLANE)?;
    if let Some(inertia) = body.inertia {
        let [.., xy, _, yz] = inertia;
        let expected = "no products xy and yz: a planar scene turns about y; use dimension = \"spatial\"";
        require(xy == 0.0 && yz == 0.0, "projectile.inertia", || format!("{inertia:?}"), expected)?;
    }
    if let BodyShape::HalfSpace { normal } = body.shape {
        let expected = "a normal in the plane: a planar scene has y = 0; use dimension = \"spatial\"";
        require(normal[1] == 0.0, "projectile.shape.half-space.normal", || format!("{normal:?}"), expected)?;
    }
    Ok(())
}

fn check_axisymmetric(scene: &Scene) -> CheckResult {
    let body = &scene.projectile;
    let on_axis = |v: [f64; 3], key| require(v[0] == 0.0 && v[1] == 0.0, key, || format!("{v:?}"), ON_AXIS);
    on_axis(scene.gel.velocity, "gel.velocity")?;
    on_axis(body.position, "projectile.position")?;
    on_axis(body.velocity, "projectile.velocity")?;
    let turn = body.angular_velocity;
    require(turn == [0.0; 3], "projectile.angular_velocity", || format!("{turn:?}"), STILL)?;
    check_upright(body)
}

fn check_upright(body: &ProjectileSpec) -> CheckResult {
    let along_z = |v: Vector3| v.x.abs() <= ROUND_OFF && v.y.abs() <= ROUND_OFF;
    let axis = rotation(body) * Vector3::z();
    require(along_z(axis), "projectile.orientation", || format!("{:?}", body.orientation), UPRIGHT)?;
    if let BodyShape::HalfSpace { normal } = body.shape {
        let expected = "a normal along z: an axisymmetric scene has x = y = 0; use dimension = \"spatial\"";
        let good = along_z(Vector3::from(normal).normalize());
        require(good, "projectile.shape.half-space.normal", || format!("{normal:?}"), expected)?;
    }
    Ok(())
}
