//! Validation of the dimensions of a projectile.

use super::domain::{CheckResult, positive, require, within};
use super::expansion::check_mushroom;
use crate::math::Vector3;
use crate::scene::{BodyShape, BulletNose, BulletSpec, ChiselSpec, Dimension, SceneError};

const LENGTH: &str = "a positive length, m";
const IN_SPACE: &str = "another shape: only a scene with dimension = \"spatial\" takes any closed surface";
const NOT_ROUND: &str = "another shape: a plate is no body of revolution; use dimension = \"spatial\" or \"planar\"";

pub(super) fn check(shape: &BodyShape, dimension: Dimension) -> CheckResult {
    match shape {
        BodyShape::Sphere { radius } => positive("projectile.shape.sphere.radius", *radius, LENGTH),
        &BodyShape::Cylinder { radius, length, edge_radius } => {
            positive("projectile.shape.cylinder.radius", radius, LENGTH)?;
            positive("projectile.shape.cylinder.length", length, LENGTH)?;
            within("projectile.shape.cylinder.edge_radius", edge_radius, 0.0..=radius.min(0.5 * length))
        }
        &BodyShape::Capsule { radius, length } => {
            positive("projectile.shape.capsule.radius", radius, LENGTH)?;
            positive("projectile.shape.capsule.length", length, LENGTH)?;
            let expected = format!("at least twice the radius, {:?} m: the length holds both ends", 2.0 * radius);
            require(length >= 2.0 * radius, "projectile.shape.capsule.length", || format!("{length:?}"), &expected)
        }
        BodyShape::Bullet(bullet) => check_bullet(bullet),
        BodyShape::Plate { size, edge_radius } => check_plate(size, *edge_radius, dimension),
        BodyShape::Mushroom(mushroom) => check_mushroom("projectile.shape.mushroom", mushroom),
        BodyShape::Chisel(chisel) => check_chisel(chisel, dimension),
        BodyShape::Stl(stl) => {
            let found = || format!("{:?}, a body in space", stl.file);
            require(dimension == Dimension::Spatial, "projectile.shape.stl", found, IN_SPACE)
        }
        BodyShape::HalfSpace { normal } => {
            let norm = Vector3::from(*normal).norm();
            let key = "projectile.shape.half-space.normal";
            require(norm.is_finite() && norm > 0.0, key, || format!("{normal:?}"), "a vector that is not zero")
        }
        &BodyShape::Dome { height, radius } => {
            positive("projectile.shape.dome.radius", radius, LENGTH)?;
            let expected = format!("from 0 to the base radius, {radius:?} m: the cap is at most half a sphere");
            require(
                (0.0..=radius).contains(&height),
                "projectile.shape.dome.height",
                || format!("{height:?}"),
                &expected,
            )
        }
    }
}

fn check_chisel(chisel: &ChiselSpec, dimension: Dimension) -> CheckResult {
    let found = || format!("a chisel of radius {:?}, a body in space", chisel.radius);
    require(dimension == Dimension::Spatial, "projectile.shape.chisel", found, IN_SPACE)?;
    positive("projectile.shape.chisel.radius", chisel.radius, LENGTH)?;
    positive("projectile.shape.chisel.length", chisel.length, LENGTH)?;
    let (least, most) = (0.02 * chisel.radius, 1.9 * chisel.radius);
    within("projectile.shape.chisel.face_width", chisel.face_width, least..=most)?;
    within("projectile.shape.chisel.face_angle", chisel.face_angle, 1.0..=85.0)?;
    let flats = chisel.outline().flat_length();
    let expected = format!("more than the sloping flats, {flats:?} m");
    let found = || format!("{:?}", chisel.length);
    require(chisel.length > flats, "projectile.shape.chisel.length", found, &expected)?;
    let found = || format!("{:?}", chisel.outline());
    require(chisel.solid.is_some(), "projectile.shape.chisel", found, "lengths of a body that can be meshed")
}

fn check_plate(size: &[f64; 3], edge_radius: f64, dimension: Dimension) -> CheckResult {
    let key = "projectile.shape.plate.size";
    require(dimension != Dimension::Axisymmetric, "projectile.shape.plate", || format!("size = {size:?}"), NOT_ROUND)?;
    size.iter().try_for_each(|length| positive(key, *length, "three positive lengths, m"))?;
    let across = if dimension == Dimension::Planar { f64::INFINITY } else { size[1] };
    within("projectile.shape.plate.edge_radius", edge_radius, 0.0..=0.5 * size[0].min(size[2]).min(across))
}

fn check_bullet(bullet: &BulletSpec) -> CheckResult {
    positive("projectile.shape.bullet.radius", bullet.radius, LENGTH)?;
    positive("projectile.shape.bullet.length", bullet.length, LENGTH)?;
    match bullet.nose {
        BulletNose::Ogive { length, arc_radius, meplat_radius } => {
            check_meplat("projectile.shape.bullet.nose.ogive.meplat_radius", meplat_radius, bullet)?;
            check_ogive(bullet, length, meplat_radius, arc_radius)?;
        }
        BulletNose::Cone { length, meplat_radius } => {
            check_meplat("projectile.shape.bullet.nose.cone.meplat_radius", meplat_radius, bullet)?;
            positive("projectile.shape.bullet.nose.cone.length", length, LENGTH)?;
        }
        BulletNose::Round | BulletNose::Flat => {}
    }
    if let Some(tail) = bullet.tail {
        positive("projectile.shape.bullet.tail.length", tail.length, LENGTH)?;
        within("projectile.shape.bullet.tail.radius", tail.radius, 0.0..=bullet.radius)?;
    }
    let (key, length) = ("projectile.shape.bullet.length", bullet.length);
    let least = length - bullet.mantle_length();
    let expected = format!("at least the nose and the tail, {least:?} m");
    require(bullet.mantle_length() >= 0.0, key, || format!("{length:?}"), &expected)?;
    check_edge(bullet)
}

fn check_meplat(key: &str, radius: f64, bullet: &BulletSpec) -> CheckResult {
    let expected = format!("0 or more, less than the mantle, {:?} m", bullet.radius);
    require((0.0..bullet.radius).contains(&radius), key, || format!("{radius:?}"), &expected)
}

/// Checks a convex ogive: neither blunter than a sphere nor wider than the bullet.
fn check_ogive(bullet: &BulletSpec, length: f64, meplat_radius: f64, arc_radius: Option<f64>) -> CheckResult {
    /// Greatest arc radius in lengths: its arc rises by less than a thousandth of the length over its chord.
    const STRAIGHT: f64 = 100.0;
    let key = "projectile.shape.bullet.nose.ogive.length";
    positive(key, length, LENGTH)?;
    let least = bullet.radius - meplat_radius;
    let expected =
        format!("at least the mantle's radius less the meplat's, {least:?} m: a nose of that length is round");
    require(length >= least, key, || format!("{length:?}"), &expected)?;
    let Some(arc_radius) = arc_radius else { return Ok(()) };
    let (tangent, most) = (bullet.tangent_radius(length, meplat_radius), STRAIGHT * length);
    let expected = format!(
        "a radius from {tangent:?} m, tangent to the mantle, to a hundred lengths, {:?} m: beyond, the nose is a cone",
        most.max(tangent)
    );
    let key = "projectile.shape.bullet.nose.ogive.arc_radius";
    require((tangent..=most.max(tangent)).contains(&arc_radius), key, || format!("{arc_radius:?}"), &expected)
}

fn check_edge(bullet: &BulletSpec) -> CheckResult {
    let (key, edge) = ("projectile.shape.bullet.edge_radius", bullet.edge_radius);
    within(key, edge, 0.0..=bullet.length)?;
    if bullet.rounded().is_some() {
        return Ok(());
    }
    let expected = format!("at most {:.3e} m: between the rims there is no room for more", most_edge(bullet));
    Err(SceneError::value(key, format!("{edge:?}"), expected))
}

/// Greatest rounding that has room, m, by bisection; reduced by 0.1 % so that its printed digits have room too.
fn most_edge(bullet: &BulletSpec) -> f64 {
    let (mut fits, mut fails) = (0.0, bullet.edge_radius);
    for _ in 0..40 {
        let middle = 0.5 * (fits + fails);
        let tried = BulletSpec { edge_radius: middle, ..*bullet };
        if tried.rounded().is_some() { fits = middle } else { fails = middle }
    }
    0.999 * fits
}
