//! Validation of loads: existing faces, finite pressures, ascending times.

use super::domain::{CheckResult, all_finite, finite, require};
use crate::scene::{BoxRegion, Dimension, GelShape, LoadSpec, MOST_LOADS, Scene, numbered};

pub(super) fn check(scene: &Scene) -> CheckResult {
    let most = format!("at most {MOST_LOADS}");
    require(scene.load.len() <= MOST_LOADS, "load", || format!("{} loads", scene.load.len()), &most)?;
    scene.load.iter().enumerate().try_for_each(|(i, load)| check_load(scene, load, &numbered("load", i)))
}

fn check_load(scene: &Scene, load: &LoadSpec, key: &str) -> CheckResult {
    let inside = |name: &str| format!("{key}.{name}");
    if let Some(face) = load.on {
        let (faces, expected) = faces(&scene.gel.shape, scene.scene.dimension);
        require(faces.contains(&face.name()), &inside("on"), || format!("{:?}", face.name()), expected)?;
    }
    load.within.map_or(Ok(()), |region| check_region(&region, &inside("within")))?;
    finite(&inside("pressure"), load.pressure)?;
    let depth = || format!("{:?}", load.depth);
    require(load.depth >= 0.0 && load.depth.is_finite(), &inside("depth"), depth, "a depth of 0 or more, m")?;
    let ramp = || format!("{:?}", load.ramp);
    require(load.ramp >= 0.0 && load.ramp.is_finite(), &inside("ramp"), ramp, "a time of 0 or more, s")?;
    let one = load.ramp == 0.0 || load.table.is_empty();
    require(one, &inside("ramp"), ramp, "no ramp beside a table: the table gives the whole time course")?;
    all_finite(&inside("table"), load.table.as_flattened())?;
    let ascending = load.table.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    require(ascending, &inside("table"), || format!("{:?}", load.table), "ascending times, s, each with a part")
}

fn check_region(region: &BoxRegion, key: &str) -> CheckResult {
    all_finite(&format!("{key}.low"), &region.low)?;
    all_finite(&format!("{key}.high"), &region.high)?;
    let good = region.low.iter().zip(region.high).all(|(low, high)| *low <= high);
    let expected = format!("nothing below within.low, {:?} m", region.low);
    require(good, &format!("{key}.high"), || format!("{:?}", region.high), &expected)
}

fn faces(shape: &GelShape, dimension: Dimension) -> (&'static [&'static str], &'static str) {
    match shape {
        GelShape::Block { .. } if dimension == Dimension::Spatial => (
            &["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"],
            "a face of a block: x_min, x_max, y_min, y_max, z_min or z_max",
        ),
        GelShape::Block { .. } => {
            (&["x_min", "x_max", "z_min", "z_max"], "a face of a planar block: x_min, x_max, z_min or z_max")
        }
        GelShape::Cylinder { bore: Some(_), .. } => {
            (&["z_min", "z_max", "side", "inner"], "a face of a cylinder with a bore: z_min, z_max, side or inner")
        }
        GelShape::Cylinder { bore: None, .. } => {
            (&["z_min", "z_max", "side"], "a face of a cylinder: z_min, z_max or side; inner if it has a bore")
        }
        GelShape::Shell { .. } => (&["z_max", "side", "inner"], "a face of a shell: z_max, side or inner"),
        GelShape::LBeam { .. } => (&[], "nothing: the faces of an l-beam have no names; use within"),
    }
}
