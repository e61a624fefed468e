//! Validation of the gel: shape, material and supports are consistent with the dimension and each other.

use super::domain::{CheckResult, all_finite, finite, positive, require};
use super::{hyperelastic, two_network};
use crate::scene::{Dimension, FaceSupport, GelShape, GelSpec, GelSymmetry, MaterialModel, Scene, SceneError};

const LENGTH: &str = "a positive length, m";

pub(super) fn check(scene: &Scene) -> CheckResult {
    let (gel, dimension) = (&scene.gel, scene.scene.dimension);
    check_shape(&gel.shape, dimension)?;
    check_material(gel)?;
    check_supports(gel, dimension)?;
    check_symmetry(scene)?;
    check_thickness(gel.thickness, dimension)?;
    all_finite("gel.velocity", &gel.velocity)
}

/// Smallest length of a shape, m.
pub(super) fn smallest_dimension(shape: &GelShape) -> f64 {
    match shape {
        GelShape::Block { size } => size.iter().copied().fold(f64::INFINITY, f64::min),
        GelShape::Cylinder { radius, height, bore } => (radius - bore.unwrap_or(0.0)).min(*height),
        GelShape::Shell { inner, outer } => inner.min(outer - inner),
        GelShape::LBeam { leg, thickness, width, .. } => leg.min(*thickness).min(width.unwrap_or(f64::INFINITY)),
    }
}

/// Shortest distance from the z axis or the entry surface of a block or cylinder to a face, m.
pub(super) fn shortest_way(shape: &GelShape) -> f64 {
    let (height, sides) = match shape {
        GelShape::Block { size } => size.split_last().expect("a block was checked to have edges"),
        GelShape::Cylinder { radius, height, .. } => return radius.min(*height),
        GelShape::LBeam { .. } | GelShape::Shell { .. } => unreachable!("its mesh has no tree: the scene was checked"),
    };
    sides.iter().map(|side| 0.5 * side).fold(*height, f64::min)
}

fn check_shape(shape: &GelShape, dimension: Dimension) -> CheckResult {
    match shape {
        GelShape::Block { size } => check_block(size, dimension),
        GelShape::Cylinder { radius, height, bore } => check_cylinder(*radius, *height, *bore, dimension),
        GelShape::Shell { inner, outer } => check_shell(*inner, *outer, dimension),
        GelShape::LBeam { .. } => check_l_beam(shape, dimension),
    }
}

fn in_a_scene(what: &str, dimension: Dimension) -> String {
    let dimension = match dimension {
        Dimension::Planar => "a planar",
        Dimension::Axisymmetric => "an axisymmetric",
        Dimension::Spatial => "a spatial",
    };
    format!("{what} in {dimension} scene")
}

fn check_block(size: &[f64], dimension: Dimension) -> CheckResult {
    let (n, expected) = match dimension {
        Dimension::Planar => (2, "two positive lengths, [x, z], m"),
        Dimension::Spatial => (3, "three positive lengths, [x, y, z], m"),
        Dimension::Axisymmetric => {
            let expected = "a cylinder: a block is planar or spatial";
            return Err(SceneError::value("gel.shape.block", in_a_scene("a block", dimension), expected));
        }
    };
    let good = size.len() == n && size.iter().all(|&edge| edge.is_finite() && edge > 0.0);
    require(good, "gel.shape.block.size", || format!("{size:?}"), expected)?;
    size.iter().try_for_each(|edge| positive("gel.shape.block.size", *edge, LENGTH))
}

fn check_cylinder(radius: f64, height: f64, bore: Option<f64>, dimension: Dimension) -> CheckResult {
    let expected = "a block or an l-beam: a cylinder is axisymmetric or spatial";
    let in_scene = || in_a_scene("a cylinder", dimension);
    require(dimension != Dimension::Planar, "gel.shape.cylinder", in_scene, expected)?;
    positive("gel.shape.cylinder.radius", radius, LENGTH)?;
    positive("gel.shape.cylinder.height", height, LENGTH)?;
    let Some(bore) = bore else { return Ok(()) };
    let (key, found) = ("gel.shape.cylinder.bore", || format!("{bore:?}"));
    let expected = "nothing: a cylinder has a bore in axisymmetric scenes only";
    require(dimension == Dimension::Axisymmetric, key, found, expected)?;
    positive(key, bore, LENGTH)?;
    require(bore < radius, key, found, &format!("less than the radius, {radius:?} m"))
}

fn check_shell(inner: f64, outer: f64, dimension: Dimension) -> CheckResult {
    let expected = "a block, a cylinder or an l-beam: a shell is axisymmetric";
    let in_scene = || in_a_scene("a shell", dimension);
    require(dimension == Dimension::Axisymmetric, "gel.shape.shell", in_scene, expected)?;
    positive("gel.shape.shell.inner", inner, LENGTH)?;
    positive("gel.shape.shell.outer", outer, LENGTH)?;
    let expected = format!("more than the inner radius, {inner:?} m");
    require(outer > inner, "gel.shape.shell.outer", || format!("{outer:?}"), &expected)
}

fn check_l_beam(shape: &GelShape, dimension: Dimension) -> CheckResult {
    let &GelShape::LBeam { leg, thickness, width, angle, corner } = shape else {
        unreachable!("only an l-beam is checked as one");
    };
    let key = "gel.shape.l-beam";
    let expected = "a cylinder: an l-beam is planar or spatial";
    let revolved = dimension == Dimension::Axisymmetric;
    require(!revolved, key, || in_a_scene("an l-beam", dimension), expected)?;
    positive("gel.shape.l-beam.leg", leg, LENGTH)?;
    positive("gel.shape.l-beam.thickness", thickness, LENGTH)?;
    let expected = format!("less than the leg, {leg:?} m");
    require(thickness < leg, "gel.shape.l-beam.thickness", || format!("{thickness:?}"), &expected)?;
    check_beam_width(width, dimension)?;
    finite("gel.shape.l-beam.angle", angle)?;
    all_finite("gel.shape.l-beam.corner", &corner)
}

fn check_beam_width(width: Option<f64>, dimension: Dimension) -> CheckResult {
    let key = "gel.shape.l-beam.width";
    match (width, dimension) {
        (Some(width), Dimension::Spatial) => positive(key, width, LENGTH),
        (None, Dimension::Spatial) => Err(SceneError::value(key, "nothing", LENGTH)),
        (Some(width), _) => {
            Err(SceneError::value(key, format!("{width:?}"), "nothing: a planar gel has gel.thickness"))
        }
        (None, _) => Ok(()),
    }
}

fn check_material(gel: &GelSpec) -> CheckResult {
    positive("gel.density", gel.density, "a positive density, kg/m3")?;
    hyperelastic::check_belonging(gel)?;
    if gel.material == MaterialModel::TwoNetwork {
        return two_network::check(gel);
    }
    two_network::check_absent(gel)?;
    hyperelastic::check(gel)?;
    positive("gel.shear_modulus", gel.shear_modulus, "a positive modulus, Pa")?;
    positive("gel.bulk_modulus", gel.bulk_modulus, "a positive modulus, Pa")?;
    let least = 2.0 / 3.0 * gel.shear_modulus;
    let expected = format!("more than 2/3 of gel.shear_modulus, {least:?} Pa: Poisson's ratio must be positive");
    require(gel.bulk_modulus > least, "gel.bulk_modulus", || format!("{:?}", gel.bulk_modulus), &expected)
}

fn check_supports(gel: &GelSpec, dimension: Dimension) -> CheckResult {
    let s = &gel.supports;
    let faces = [("x_min", s.x_min), ("x_max", s.x_max), ("y_min", s.y_min), ("y_max", s.y_max)].into_iter().chain([
        ("z_min", s.z_min),
        ("z_max", s.z_max),
        ("side", s.side),
    ]);
    let (held, expected) = held_faces(&gel.shape, dimension);
    for (face, support) in faces.filter(|(_, support)| *support != FaceSupport::Free) {
        let key = format!("gel.supports.{face}");
        require(held.contains(&face), &key, || format!("{:?}", name(support)), expected)?;
    }
    let is_shell = matches!(gel.shape, GelShape::Shell { .. });
    let expected = "\"free\" or \"fixed\": the outer surface of a shell is round";
    let slides = s.side == FaceSupport::Roller && is_shell;
    require(!slides, "gel.supports.side", || "\"roller\"".to_owned(), expected)?;
    let slides = s.side == FaceSupport::Roller && dimension == Dimension::Spatial;
    let expected = "\"free\" or \"fixed\": a mantle slides on rollers only in axisymmetric scenes";
    require(!slides, "gel.supports.side", || "\"roller\"".to_owned(), expected)
}

/// Checks that the rest of the gel is the mirror image of the computed part.
fn check_symmetry(scene: &Scene) -> CheckResult {
    let (gel, key) = (&scene.gel, "gel.symmetry");
    let found = || match gel.symmetry {
        GelSymmetry::None => "\"none\"".to_owned(),
        GelSymmetry::Half => "\"half\"".to_owned(),
        GelSymmetry::Quarter => "\"quarter\"".to_owned(),
    };
    let is_whole = gel.symmetry.is_none();
    let is_block = scene.scene.dimension == Dimension::Spatial && matches!(gel.shape, GelShape::Block { .. });
    require(is_whole || is_block, key, found, "\"none\": only spatial blocks can be computed in part")?;
    require(is_whole || scene.load.is_empty(), key, found, "\"none\": loads need a whole gel")?;
    let (s, expected) = (&gel.supports, "nothing: the plane of symmetry is there (gel.symmetry)");
    for (axis, face, support) in [(0, "x_min", s.x_min), (1, "y_min", s.y_min)] {
        let good = support == FaceSupport::Free || !gel.symmetry.mirrored().contains(&axis);
        require(good, &format!("gel.supports.{face}"), || format!("{:?}", name(support)), expected)?;
    }
    Ok(())
}

fn held_faces(shape: &GelShape, dimension: Dimension) -> (&'static [&'static str], &'static str) {
    match shape {
        GelShape::Block { .. } if dimension == Dimension::Spatial => (
            &["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"],
            "nothing: a block has the faces x_min, x_max, y_min, y_max, z_min and z_max",
        ),
        GelShape::Block { .. } => (
            &["x_min", "x_max", "z_min", "z_max"],
            "nothing: a planar block has the faces x_min, x_max, z_min and z_max",
        ),
        GelShape::Cylinder { .. } => {
            (&["z_min", "z_max", "side"], "nothing: a cylinder has the faces z_min, z_max and side")
        }
        GelShape::Shell { .. } => (&["z_max", "side"], "nothing: a shell has the faces z_max and side"),
        GelShape::LBeam { .. } => (&[], "nothing: an l-beam has no supports"),
    }
}

fn name(support: FaceSupport) -> &'static str {
    match support {
        FaceSupport::Free => "free",
        FaceSupport::Roller => "roller",
        FaceSupport::Fixed => "fixed",
    }
}

fn check_thickness(thickness: Option<f64>, dimension: Dimension) -> CheckResult {
    let Some(thickness) = thickness else { return Ok(()) };
    let planar = dimension == Dimension::Planar;
    let expected = "nothing: only a planar gel has a thickness";
    require(planar, "gel.thickness", || format!("{thickness:?}"), expected)?;
    positive("gel.thickness", thickness, LENGTH)
}
