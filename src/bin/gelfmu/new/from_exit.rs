//! Shot with the projectile that has left the gel of a finished run.

use super::arrival::Arrival;
use super::options::NewOptions;
use super::shot::{Shot, check_block};
use crate::failure::CommandError;
use crate::source;
use ballistic_gel::output::{SCENE, SavedRunError, exited_run};
use ballistic_gel::scene::{BodyShape, Dimension, LibraryProjectile, ProjectileKind, ProjectileSpec, Scene};
use std::collections::BTreeMap;
use std::path::Path;

/// Longest gap, m: drag and gravity are left out.
const LONGEST_GAP: f64 = 100.0;
/// Speeds at which a projectile makes a shot, m/s.
const SPEEDS: std::ops::RangeInclusive<f64> = 1.0..=5000.0;

/// Shot of the options with the projectile that has left the gel of the run in a folder.
pub fn shot_from_exit(options: &NewOptions, folder: &Path) -> Result<Shot, CommandError> {
    refuse_aim(options)?;
    let refuse = |why: &str| CommandError::BadInput(format!("--from-exit {}: {why}", folder.display()));
    if options.gap > LONGEST_GAP {
        let gap = options.gap;
        return Err(CommandError::BadInput(format!("--gap {gap} m: expected at most {LONGEST_GAP} m of air")));
    }
    let file = folder.join(SCENE);
    if !file.is_file() {
        return Err(refuse(&format!("found no {SCENE}, expected a folder that gelfmu run or an FMU has written")));
    }
    let scene = source::load(&file.to_string_lossy(), &[])?.scene;
    if scene.scene.dimension == Dimension::Planar {
        return Err(refuse(
            "found a run in the plane, whose projectile is a prism, expected one in space or about an axis",
        ));
    }
    let run = exited_run(folder, &scene).map_err(|error| match error {
        SavedRunError::Read { .. } => refuse(&format!("{error}; expected the folder of a finished run")),
        other => refuse(&other.to_string()),
    })?;
    let arrival = Arrival::of(folder, &scene, &run, options.gap).ok_or_else(|| {
        refuse("found a body that does not fly away from the back face, expected one that leaves the gel")
    })?;
    let (speed, yaw) = (arrival.speed(), arrival.yaw());
    if !SPEEDS.contains(&speed) {
        return Err(refuse(&format!(
            "found a projectile that left at {speed} m/s, expected a speed from 1 to 5000 m/s"
        )));
    }
    check_block(options.block, arrival.radius)?;
    let projectile = library_form(&scene, arrival.projectile());
    let (block, gel) = (options.block, options.gel);
    let layers = options.layer.clone();
    Ok(Shot { projectile, speed, yaw, roll: 0.0, block, gel, layers, arrival: Some(arrival) })
}

/// Refuses options that the run answers.
fn refuse_aim(options: &NewOptions) -> Result<(), CommandError> {
    let given = [
        ("--projectile", options.projectile.is_some(), "projectile"),
        ("--speed", options.speed.is_some(), "speed"),
        ("--yaw", options.yaw.is_some(), "attitude"),
        ("--roll", options.roll.is_some(), "attitude"),
    ];
    match given.into_iter().find(|(_, is_given, _)| *is_given) {
        Some((option, _, what)) => Err(CommandError::BadInput(format!(
            "{option}: the run of --from-exit gives the {what}; leave {option} or --from-exit out"
        ))),
        None => Ok(()),
    }
}

/// Body of a run in the form of the library: that of its name, or one of the scene.
fn library_form(scene: &Scene, spec: &ProjectileSpec) -> LibraryProjectile {
    let name = &scene.scene.name;
    let of_scene = || LibraryProjectile {
        name: name.clone(),
        title: format!("projectile of {name}"),
        kind: if spec.expansion.is_some() { ProjectileKind::Expanding } else { ProjectileKind::Test },
        speed: 0.0,
        mass: 0.0,
        inertia: None,
        shape: BodyShape::Sphere { radius: 0.0 },
        expansion: None,
        not_modelled: None,
        since: 1,
        source: BTreeMap::new(),
    };
    let named = spec.library.as_deref().and_then(LibraryProjectile::named).unwrap_or_else(of_scene);
    let (mass, shape) = (spec.mass.unwrap_or(named.mass), spec.shape.clone());
    LibraryProjectile { mass, inertia: spec.inertia, shape, expansion: spec.expansion, ..named }
}
