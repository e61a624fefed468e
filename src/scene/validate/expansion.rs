//! Validation of the expansion of a bullet.

use super::domain::{CheckResult, positive, require, within};
use crate::scene::{BodyShape, Dimension, ExpansionSpec, MushroomSpec, ProjectileSpec, SceneError};

const LENGTH: &str = "a positive length, m";
/// Least radius of a round edge, relative to that of the head: beyond round-off.
const ROUND_EDGE: f64 = 1e-6;

/// Checks the expansion of a body.
pub(super) fn check(body: &ProjectileSpec, dimension: Dimension) -> CheckResult {
    let Some(expansion) = &body.expansion else { return Ok(()) };
    let key = "projectile.expansion";
    let BodyShape::Bullet(bullet) = &body.shape else {
        let expected = "nothing, or projectile.shape.bullet: only a bullet expands";
        return Err(SceneError::value(key, "the expansion of another body", expected));
    };
    let expected = "nothing, or dimension = \"axisymmetric\" or \"spatial\": a bullet of a planar scene is a prism";
    require(dimension != Dimension::Planar, key, || "the expansion of a planar body".to_owned(), expected)?;
    check_mushroom("projectile.expansion.opened", &expansion.opened)?;
    let found = || format!("{:?}", expansion.opened.radius);
    let expected = format!("more than the radius of the bullet, {:?} m", bullet.radius);
    require(expansion.opened.radius > bullet.radius, "projectile.expansion.opened.radius", found, &expected)?;
    check_path(expansion, bullet.radius)?;
    within("projectile.expansion.opening", expansion.opening, 0.0..=1.0)?;
    check_thresholds(expansion)
}

/// Checks that the path is long enough for the contact impulses to resolve the opening.
fn check_path(expansion: &ExpansionSpec, radius: f64) -> CheckResult {
    let Some(path) = expansion.path else { return Ok(()) };
    let expected = format!("at least the radius of the bullet, {radius:?} m: its opening along less is not resolved");
    let is_long = path.is_finite() && path >= radius;
    require(is_long, "projectile.expansion.path", || format!("{path:?}"), &expected)
}

/// Checks the lengths of a mushroom of this key.
pub(super) fn check_mushroom(key: &str, mushroom: &MushroomSpec) -> CheckResult {
    let own = |name: &str| format!("{key}.{name}");
    let MushroomSpec { radius, length, head_length, edge_radius, shank_radius, rim_radius } = *mushroom;
    positive(&own("radius"), radius, LENGTH)?;
    positive(&own("length"), length, LENGTH)?;
    positive(&own("shank_radius"), shank_radius, LENGTH)?;
    within(&own("shank_radius"), shank_radius, 0.0..=radius)?;
    within(&own("edge_radius"), edge_radius, 0.0..=radius.min(length))?;
    let expected = format!("0, a sharp edge, or at least {:?} m", ROUND_EDGE * radius);
    let is_round = edge_radius == 0.0 || edge_radius >= ROUND_EDGE * radius;
    require(is_round, &own("edge_radius"), || format!("{edge_radius:?}"), &expected)?;
    within(&own("head_length"), head_length, edge_radius..=length)?;
    within(&own("rim_radius"), rim_radius, 0.0..=length)?;
    let found = || format!("{rim_radius:?}");
    require(mushroom.outline().is_some(), &own("rim_radius"), found, "less: between the rims there is no room for it")
}

/// Greatest threshold, m/s or Pa: its stagnation pressure is a number.
const GREATEST: f64 = 1e15;

/// Checks that the thresholds are two speeds, two pressures, or none, in their order.
fn check_thresholds(expansion: &ExpansionSpec) -> CheckResult {
    let ExpansionSpec { opening_speed, full_speed, opening_pressure, full_pressure, .. } = *expansion;
    let pairs = [("speed", opening_speed, full_speed, "m/s"), ("pressure", opening_pressure, full_pressure, "Pa")];
    let is_given = |(_, opening, full, _): &(&str, Option<f64>, Option<f64>, &str)| opening.is_some() || full.is_some();
    if pairs.iter().all(is_given) {
        let expected = "speeds or pressures as thresholds, not both";
        return Err(SceneError::value("projectile.expansion.opening_pressure", "pressures beside speeds", expected));
    }
    for (name, opening, full, unit) in pairs.into_iter().filter(is_given) {
        let [opening_key, full_key] = ["opening", "full"].map(|part| format!("projectile.expansion.{part}_{name}"));
        let expected = "both thresholds, or none where the importer prescribes the opening";
        let (Some(opening), Some(full)) = (opening, full) else {
            let missing = if opening.is_none() { &opening_key } else { &full_key };
            return Err(SceneError::value(missing, "nothing", expected));
        };
        for (key, value) in [(&opening_key, opening), (&full_key, full)] {
            within(key, value, f64::MIN_POSITIVE..=GREATEST)?;
        }
        let expected = format!("at least {opening_key}, {opening:?} {unit}: a bullet begins to open before it is open");
        require(full >= opening, &full_key, || format!("{full:?}"), &expected)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::scene::{Override, builtin, read, resolve};

    const BULLET: &str = "projectile.shape={bullet={radius=4.5e-3, length=15e-3, nose=\"round\", edge_radius=1e-3}}";

    fn read_with(expansion: &str) -> Result<(), String> {
        let above = "projectile.position=[0, 0, 0.02]".parse().unwrap();
        let changes: [Override; 3] = [BULLET.parse().unwrap(), above, expansion.parse().unwrap()];
        let text = resolve(builtin("fbi-bb").unwrap(), &changes).map_err(|error| error.to_string())?;
        read(&text).map(|_| ()).map_err(|error| error.to_string())
    }

    fn expansion(opened: &str, more: &str) -> String {
        format!("projectile.expansion={{opened={{{opened}}}{more}}}")
    }

    const OPENED: &str = "radius=7e-3, length=9e-3, head_length=4e-3, edge_radius=2e-3, shank_radius=4.5e-3";

    #[test]
    fn an_expansion_without_sense_is_refused_by_key_with_a_remedy() {
        assert_eq!(read_with(&expansion(OPENED, ", opening_speed=180.0, full_speed=280.0")), Ok(()));
        assert_eq!(read_with(&expansion(OPENED, "")), Ok(()));
        let small = OPENED.replace("radius=7e-3", "radius=4.5e-3");
        for (opened, more, key, part) in [
            (small.as_str(), "", "expansion.opened.radius", "more than the radius of the bullet"),
            (
                OPENED,
                ", opening_speed=280.0, full_speed=180.0",
                "expansion.full_speed",
                "at least projectile.expansion.opening_speed",
            ),
            (OPENED, ", opening_speed=280.0", "expansion.full_speed", "both thresholds"),
            (OPENED, ", full_pressure=280.0", "expansion.opening_pressure", "both thresholds"),
            (OPENED, ", full_pressure=1e7, opening_speed=200.0", "expansion.opening_pressure", "not both"),
            (OPENED, ", path=4e-3", "expansion.path", "at least the radius of the bullet"),
            (OPENED, ", opening_speed=180.0, full_speed=1e200", "expansion.full_speed", ""),
            (&OPENED.replace("edge_radius=2e-3", "edge_radius=4e-19"), "", "opened.edge_radius", "a sharp edge"),
            (OPENED, ", opening=1.5", "expansion.opening", "from 0.0 to 1.0"),
            (&OPENED.replace("edge_radius=2e-3", "edge_radius=5e-3"), "", "expansion.opened.head_length", ""),
            (&format!("{OPENED}, rim_radius=8e-3"), "", "expansion.opened.rim_radius", "no room"),
        ] {
            let refused = read_with(&expansion(opened, more)).unwrap_err();
            assert!(refused.contains(key) && refused.contains(part), "{opened}{more}: {refused}");
        }
        let sphere = resolve(builtin("fbi-bb").unwrap(), &[expansion(OPENED, "").parse().unwrap()]).unwrap();
        assert!(read(&sphere).unwrap_err().to_string().contains("only a bullet expands"));
    }
}
