//! Validation of sensors: each lies in the gel at rest.

use super::domain::{CheckResult, all_finite, require};
use crate::scene::{Dimension, GelShape, MOST_SENSORS, Scene, numbered};

/// Relative round-off by which a sensor may lie outside the gel.
const ROUND_OFF: f64 = 1e-9;

pub(super) fn check(scene: &Scene) -> CheckResult {
    let most = format!("at most {MOST_SENSORS}");
    require(scene.sensor.len() <= MOST_SENSORS, "sensor", || format!("{} sensors", scene.sensor.len()), &most)?;
    scene.sensor.iter().enumerate().try_for_each(|(i, sensor)| {
        let key = numbered("sensor", i) + ".position";
        all_finite(&key, &sensor.position)?;
        let SensorRegion { contains, description } = sensor_region(scene, sensor.position);
        let expected = format!("a point of the gel at rest, {description}: move the sensor into it");
        require(contains, &key, || format!("{:?}", sensor.position), &expected)
    })
}

/// Region of the gel at rest, compared with a point.
struct SensorRegion {
    /// True if the point is in the region.
    contains: bool,
    /// Description of the region.
    description: String,
}

fn sensor_region(scene: &Scene, [x, y, z]: [f64; 3]) -> SensorRegion {
    let (flat, dimension) = (y == 0.0, scene.scene.dimension);
    let (contains, description) = match &scene.gel.shape {
        GelShape::Block { size } if dimension == Dimension::Spatial => {
            let inside = is_within(x.abs(), 0.5 * size[0]) && is_within(y.abs(), 0.5 * size[1]) && is_below(z, size[2]);
            (inside, format!("|x| <= {:?}, |y| <= {:?}, -{:?} <= z <= 0 m", 0.5 * size[0], 0.5 * size[1], size[2]))
        }
        GelShape::Block { size } => {
            let inside = flat && is_within(x.abs(), 0.5 * size[0]) && is_below(z, size[1]);
            (inside, format!("|x| <= {:?}, y = 0, -{:?} <= z <= 0 m", 0.5 * size[0], size[1]))
        }
        GelShape::Cylinder { radius, height, bore } => {
            let section = dimension == Dimension::Spatial || (flat && x >= 0.0);
            let (r, least) = (x.hypot(y), bore.unwrap_or(0.0));
            let inside = section && is_within(r, *radius) && is_within(least, r) && is_below(z, *height);
            let axis = if dimension == Dimension::Spatial { "" } else { ", x the radius and y = 0" };
            (inside, format!("{least:?} <= radius <= {radius:?}, -{height:?} <= z <= 0 m{axis}"))
        }
        GelShape::Shell { inner, outer } => {
            let distance = x.hypot(z);
            let inside = flat && x >= 0.0 && z <= 0.0 && is_within(distance, *outer) && is_within(*inner, distance);
            (inside, format!("{inner:?} to {outer:?} m from the origin, x >= 0 the radius, y = 0, z <= 0"))
        }
        GelShape::LBeam { leg, thickness, width, angle, corner } => {
            let (sin, cos) = angle.to_radians().sin_cos();
            let (dx, dz) = (x - corner[0], z - corner[2]);
            let along = [cos * dx + sin * dz, cos * dz - sin * dx];
            let in_square = along.iter().all(|a| is_within(-a, 0.0) && is_within(*a, *leg));
            let across = width.map_or(flat, |width| is_within((y - corner[1]).abs(), 0.5 * width));
            let inside = in_square && across && along.iter().any(|a| is_within(*a, *thickness));
            (inside, format!("{thickness:?} m or less from the outer edge of a leg of {leg:?} m"))
        }
    };
    SensorRegion { contains, description }
}

/// Returns true if a length is at most `most`, within round-off.
fn is_within(length: f64, most: f64) -> bool {
    length <= most + ROUND_OFF * most.abs().max(length.abs()).max(1e-3)
}

fn is_below(z: f64, height: f64) -> bool {
    is_within(z, 0.0) && is_within(-z, height)
}
