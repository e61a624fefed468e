//! `gelfmu new`: the scene of a shot with a projectile of the library, or with one that has left the gel of a run.

mod arrival;
mod arrival_text;
mod block;
mod flight;
mod from_exit;
mod layer;
mod level_errors;
#[cfg(test)]
mod measured_shots;
mod options;
mod shot;
mod sizes;
mod text;

pub use options::NewOptions;
pub use shot::named_projectile;

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::level;
use crate::results;
use ballistic_gel::scene;
#[cfg(test)]
use block::BlockSize;
use level_errors::ShotIdentity;
use serde_json::{Value, json};
use shot::Shot;
use std::io::ErrorKind;
use std::path::Path;
use text::{read_scene, scene_text};

/// Prints the scene of a shot, or writes it to a file that does not exist.
pub fn new(options: &NewOptions, console: &Console) -> Result<(), CommandError> {
    let shot = shot_of(options)?;
    let text = scene_text(&shot)?;
    let (identity, mut doubts) = (ShotIdentity::of(&shot), doubts_of(&text)?);
    doubts.extend(shot.arrival.as_ref().and_then(|arrival| arrival.flight.doubt()));
    for doubt in &doubts {
        console.warning(doubt);
    }
    let Some(path) = &options.out else {
        let result = json!({ "text": text, "shot": identity, "doubts": doubts });
        console.document(&with_origin(result, &shot), &text);
        return Ok(());
    };
    write_new(path, &text)?;
    let shown = path.display();
    let estimate = json!({ "longest_path": shot.longest_path(), "longest_time": shot.longest_time() });
    let units = options.units.system();
    let yaw = if shot.yaw == 0.0 { String::new() } else { format!(" with {}° of yaw", shot.shown_yaw()) };
    let told = format!(
        "{shown}: {}, {} at {}{yaw}, into {}. The levels coarse, standard \
         and fine cost more than draft, which stops a bullet early. Run it with:\n    gelfmu run {shown} --fidelity draft",
        shot.projectile.title,
        units.format_mass(shot.projectile.mass),
        units.format_speed(shot.speed, 1),
        units.format_sides([shot.block.width, shot.block.height, shot.block.length])
    );
    let result = json!({ "file": shown.to_string(), "estimate": estimate, "shot": identity, "doubts": doubts });
    console.result(&with_origin(result, &shot), &told);
    Ok(())
}

fn shot_of(options: &NewOptions) -> Result<Shot, CommandError> {
    match (&options.from_exit, &options.projectile) {
        (Some(folder), _) => from_exit::shot_from_exit(options, folder),
        (None, name) => Shot::of_library(options, name.as_deref().unwrap_or_default()),
    }
}

/// Adds to the result the run from which the projectile of a shot comes.
fn with_origin(mut result: Value, shot: &Shot) -> Value {
    if let Some(arrival) = &shot.arrival {
        result["from_exit"] = arrival.told();
    }
    result
}

/// Doubts about the block of a shot, and about levels that `gelfmu run` refuses.
fn doubts_of(text: &str) -> Result<Vec<String>, CommandError> {
    let at_level = |fidelity| {
        let text = scene::resolve(text, &[level::level_override(fidelity)]);
        Ok(text.and_then(|text| read_scene(&text)).map_err(RunError::from)?)
    };
    let scene = read_scene(text).map_err(RunError::from)?;
    Ok([scene::block_doubts(&scene), level::refused_levels(&scene.fidelity, at_level)].concat())
}

fn write_new(path: &Path, text: &str) -> Result<(), CommandError> {
    let refuse = |why: &str| CommandError::BadInput(format!("--out {}: {why}", path.display()));
    results::create(path, text.as_bytes()).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => refuse("found a file of this name, which is not replaced; expected a new name"),
        ErrorKind::NotFound
        | ErrorKind::NotADirectory
        | ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem => refuse(&format!("{error}, expected a file that can be written")),
        _ => RunError::File { verb: "write", path: path.to_path_buf(), source: error }.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballistic_gel::scene::Preset;

    #[test]
    fn a_block_that_the_cavity_outgrows_is_doubted() {
        let doubts = |block: &str| {
            let projectile = named_projectile("45acp-185-silvertip-recovered").unwrap();
            let (speed, block) = (projectile.speed, BlockSize::parse(block).unwrap());
            let shot = Shot {
                projectile,
                speed,
                yaw: 0.0,
                roll: 0.0,
                block,
                gel: Preset::Gelatin10,
                layers: vec![],
                arrival: None,
            };
            doubts_of(&scene_text(&shot).unwrap()).unwrap()
        };
        let narrow = doubts("10x10x10cm");
        assert!(narrow.len() == 1 && narrow[0].contains("cavity of projectile may become 93 to 125 mm"), "{narrow:?}");
        assert_eq!(doubts("15x15x40cm"), Vec::<String>::new());
    }
}
