//! Validation of bodies that name a projectile of the library.

use super::domain::{CheckResult, require};
use crate::scene::{LIBRARY_VERSION, LibraryProjectile, ProjectileSpec, Scene, SceneError, body_name};

pub(super) fn check(scene: &Scene) -> CheckResult {
    scene.bodies().enumerate().try_for_each(|(i, body)| check_body(&body_name(i), body))
}

/// Checks that the values beside a name are those of the library, or of the earlier version that the scene states.
fn check_body(table: &str, body: &ProjectileSpec) -> CheckResult {
    let key = |name: &str| format!("{table}.{name}");
    let version = || format!("{:?}", body.library_version.unwrap_or_default());
    let Some(projectile) = body.library.as_deref().and_then(LibraryProjectile::named) else {
        let expected = format!("nothing: the body has no {table}.library");
        return require(body.library_version.is_none(), &key("library_version"), version, &expected);
    };
    let stated = body.library_version.unwrap_or(LIBRARY_VERSION);
    let expected = format!("a version from 1 to {LIBRARY_VERSION}, that of the library of this program");
    require((1..=LIBRARY_VERSION).contains(&stated), &key("library_version"), version, &expected)?;
    if stated < projectile.since {
        return Ok(());
    }
    refuse_contradiction(table, body, &projectile)
}

/// Refuses values of a body beside the name of a projectile that has others.
fn refuse_contradiction(table: &str, body: &ProjectileSpec, projectile: &LibraryProjectile) -> CheckResult {
    let differences = projectile.differences(body);
    let density = body.density.map(|density| (format!("{table}.density"), format!(" = {density:?}")));
    let others = differences.iter().map(|differing| {
        let [own, known] = &differing.values;
        (format!("{table}.{}", differing.key), format!(" = {own} (the library has {known})"))
    });
    let (keys, told): (Vec<String>, Vec<String>) =
        others.chain(density).map(|(key, value)| (key.clone(), key + &value)).unzip();
    if keys.is_empty() {
        return Ok(());
    }
    let name = &projectile.name;
    let found = format!("{name:?} beside another body: {}", told.join(", "));
    let expected = format!(
        "the name alone: remove {} for the body of the library, or {table}.library for a body of your own; `gelfmu new \
         --projectile {name}` writes a scene with start, cells and times for it",
        keys.join(" and ")
    );
    Err(SceneError::value(&format!("{table}.library"), found, expected))
}
