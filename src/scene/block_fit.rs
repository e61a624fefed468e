//! Doubts about a block that is too small for its shot: an estimate of the temporary cavity, and a body beside the gel.

use super::{Dimension, MaterialModel, ProjectileSpec, Scene, body_name};
use crate::geometry::{ShapeGeometry, SignedDistance};
use crate::math::Vector3;
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::PI;

/// Drag coefficient of a sphere with an open cavity behind it (May 1975).
pub const CAVITY_DRAG: f64 = 0.30;
/// Resisting pressure of 10 % gelatin in Poncelet's law, Pa: a BB of 179.8 m/s then stops at 85 mm with this drag.
pub const GEL_RESISTANCE: f64 = 2.32e6;
/// Energy of a temporary cavity by its volume, Pa, where speed times diameter is [`CAVITY_SIZE`], m²/s, and exponent with
/// which it falls with this product: fitted to cavities of the shots of `docs/shots.csv`, but those of runs to a neck, as
/// they were computed before. No measured cavity is behind them.
const CAVITY_PRESSURE: f64 = 0.73e6;
const CAVITY_SIZE: f64 = 5.0;
const CAVITY_EXPONENT: f64 = 0.8;
/// Relative error of the estimate within which all but two of these cavities are, of 7 to 104 mm; single runs are up to
/// 26 % off, and differ by up to 24 % with their last digits.
pub const CAVITY_MARGIN: f64 = 0.15;
/// Ratio of length to width from which a body that turns over shows its side.
const LONG: f64 = 1.05;

/// Estimate of the greatest diameter of the temporary cavity of a body, m; `None` in an elastic or planar gel, and for
/// a body that does not move by itself.
///
/// Energy per length of path over the cross-section of the cavity is a pressure: in proportion to the strength of the gel,
/// and smaller for large and fast bodies, whose cavities open slowly beside their size. The energy is the force of
/// Poncelet's law at the speed of the impact, on the section of the body across its path. The cavity is no wider than a
/// sphere that takes all of the kinetic energy, and until the end of the run no wider than inertia lets it become:
/// a² = 2 t √(E'/(π ρ)), a cylinder of radius a in gel that moves out to e times that radius. Layers are left out.
#[must_use]
pub fn cavity_estimate(scene: &Scene, body: usize) -> Option<f64> {
    let (projectile, shape) = (scene.body(body), scene.shape_in_gel(body));
    let can_flow = scene.gel.material == MaterialModel::TwoNetwork && scene.scene.dimension != Dimension::Planar;
    shape.volume().filter(|_| can_flow && !projectile.fixed && projectile.active)?;
    let speed_squared = approach(scene, projectile).norm_squared();
    let (density, strength, end_time) = (scene.gel.density, scene.gel.strength_scale, scene.scene.end_time);
    let section = section(scene, &shape);
    let size = (4.0 * section * speed_squared / PI).sqrt() / CAVITY_SIZE;
    let pressure = strength * CAVITY_PRESSURE * libm::pow(size, -CAVITY_EXPONENT);
    let per_length = (0.5 * CAVITY_DRAG * density * speed_squared + strength * GEL_RESISTANCE) * section;
    let cylinder = (4.0 * per_length / (PI * pressure)).sqrt();
    let energy = 0.5 * projectile.mass? * speed_squared;
    let sphere = libm::cbrt(6.0 * energy / (PI * pressure));
    let until_end = 2.0 * (2.0 * end_time * (per_length / (PI * density)).sqrt()).sqrt();
    Some(cylinder.min(sphere).min(until_end))
}

/// Reasons to take a larger block, one sentence each.
#[must_use]
pub fn block_doubts(scene: &Scene) -> Vec<String> {
    (0..scene.n_bodies()).filter_map(|body| tight_block(scene, body)).collect()
}

/// Doubt about the way from the path of a body to the nearest side of the gel.
fn tight_block(scene: &Scene, body: usize) -> Option<String> {
    let (projectile, shape) = (scene.body(body), scene.shape_in_gel(body));
    let (cavity, room) = (cavity_estimate(scene, body)?, room_about_path(scene, projectile)?);
    let (name, millimetres) = (body_name(body), |length: f64| (1e3 * length).round());
    let width = extent_across(projectile, &shape);
    // A body whose energy opens no cavity as wide as itself presses on the gel, as a plate in a slow test.
    if cavity < width {
        return None;
    }
    if width > room {
        return Some(format!(
            "{name}.position: the body is {} mm wide across its path, and the gel has room for {} mm about it: part of \
             the body passes the gel; widen gel.shape, or move the body to its middle",
            millimetres(width),
            millimetres(room.max(0.0))
        ));
    }
    let [narrowest, widest] = [1.0 + CAVITY_MARGIN, 1.0 - CAVITY_MARGIN].map(|ratio| cavity / ratio);
    (widest > room).then(|| {
        format!(
            "gel.shape: the temporary cavity of {name} may become {} to {} mm wide (an estimate from energy per length, \
             not a computation), and the gel has room for {} mm about the path: its sides would give way or burst, and \
             the figures are those of this block only; take a gel at least {:.1} m wide",
            millimetres(narrowest),
            millimetres(widest),
            millimetres(room),
            0.1 * (20.0 * widest).ceil()
        )
    })
}

/// Returns the velocity of a body against the gel, m/s.
pub(super) fn approach(scene: &Scene, projectile: &ProjectileSpec) -> Vector3 {
    Vector3::from(projectile.velocity) - Vector3::from(scene.gel.velocity)
}

/// Section of a body across its path, m²: that across its axis, or if it is long and can yaw the mean of this and of its
/// side, as it has lost speed when it shows its side.
fn section(scene: &Scene, shape: &ShapeGeometry) -> f64 {
    let extent = |axis: Vector3| shape.reach(&axis) + shape.reach(&-axis);
    let (across, along) = (extent(Vector3::x()).max(extent(Vector3::y())), extent(Vector3::z()));
    let can_yaw = scene.freedom() != Dimension::Axisymmetric;
    let front = 0.25 * PI * across * across;
    if can_yaw && along > LONG * across { 0.5 * (front + across * along) } else { front }
}

/// Twice the distance from the path of a body at the entry surface to the nearest side of the gel, m; `None` for
/// a gel without sides.
fn room_about_path(scene: &Scene, projectile: &ProjectileSpec) -> Option<f64> {
    let (sides, velocity) = (scene.gel.shape.bounding_box()?.upper, approach(scene, projectile));
    let start = Vector3::from(projectile.position);
    let until_entry = if start.z > 0.0 && velocity.z < 0.0 { -start.z / velocity.z } else { 0.0 };
    let entry = start + until_entry * velocity;
    Some(2.0 * (sides.x - entry.x.abs()).min(sides.y - entry.y.abs()))
}

/// Greatest extent of a body along x and y in its attitude at the start, m.
fn extent_across(projectile: &ProjectileSpec, shape: &ShapeGeometry) -> f64 {
    let [w, x, y, z] = projectile.orientation;
    let to_body = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).inverse();
    let extent = |axis: Vector3| shape.reach(&(to_body * axis)) + shape.reach(&(to_body * -axis));
    extent(Vector3::x()).max(extent(Vector3::y()))
}

#[cfg(test)]
mod tests {
    use super::super::{Override, builtin, read, resolve};
    use super::*;

    fn scene_with(name: &str, changes: &[&str]) -> Scene {
        let changes: Vec<Override> = changes.iter().map(|change| change.parse().unwrap()).collect();
        read(&resolve(builtin(name).unwrap(), &changes).unwrap()).unwrap()
    }

    #[test]
    fn a_cavity_wider_than_the_gel_is_doubted_with_its_width_and_the_remedy() {
        // The rifle bullet opens some 224 mm, unless the run ends before.
        let long = scene_with("bullet-yaw", &["scene.end_time=5e-3"]);
        let [doubt] = &block_doubts(&long)[..] else { panic!("{:?}", block_doubts(&long)) };
        for part in
            ["gel.shape: the temporary cavity of projectile may become 1", "room for 150 mm", "at least 0.6 m wide"]
        {
            assert!(doubt.contains(part), "{doubt}");
        }
        let wide = ["scene.end_time=5e-3", "gel.shape.block.size=[0.5, 0.5, 0.5]"];
        for scene in [scene_with("bullet-yaw", &[]), scene_with("bullet-yaw", &wide), scene_with("sphere-720", &[])] {
            assert!(block_doubts(&scene).is_empty(), "{:?}", block_doubts(&scene));
        }
        let narrow = scene_with("sphere-720", &["gel.shape.cylinder.radius=0.024"]);
        assert!(block_doubts(&narrow)[0].contains("room for 48 mm"), "{:?}", block_doubts(&narrow));
    }

    #[test]
    fn a_body_that_passes_the_gel_at_its_side_is_doubted() {
        let aside = scene_with("bullet-yaw", &["projectile.position=[0.073, 0.0, 0.03]", "scene.end_time=5e-3"]);
        assert!(block_doubts(&aside)[0].contains("part of the body passes the gel"), "{:?}", block_doubts(&aside));
        // A slow plate presses on the gel.
        let plate = ["projectile.shape={plate={size=[0.3, 0.3, 0.02]}}", "projectile.velocity=[0, 0, -1]"];
        let press = scene_with("fbi-bb-3d", &[&plate[..], &["projectile.position=[0, 0, 0.02]"]].concat());
        assert!(block_doubts(&press).is_empty(), "{:?}", block_doubts(&press));
    }
}
