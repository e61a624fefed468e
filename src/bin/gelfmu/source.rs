//! Loading of scenes: built-in scenes and scene files, with overrides.

use crate::failure::CommandError;
use ballistic_gel::output;
use ballistic_gel::scene::{self, OverriddenScene, Override, OverrideError, Scene};
use std::path::{Path, PathBuf};

/// Scene with its text; all overrides are written into both.
#[derive(Debug)]
pub struct SceneSource {
    /// Scene text, TOML.
    pub text: String,
    /// Folder of the scene file, the base of relative file names.
    pub folder: PathBuf,
    /// Parsed and checked scene.
    pub scene: Scene,
}

/// Reads the text of a built-in scene or of a scene file.
fn read_original(name: &str) -> Result<String, CommandError> {
    match scene::builtin(name) {
        Some(text) => Ok(text.to_owned()),
        None => output::read_scene_text(Path::new(name)).map_err(|error| unreadable_scene(name, &error)),
    }
}

/// Loads a built-in scene or a scene file, with overrides.
pub fn load(name: &str, overrides: &[Override]) -> Result<SceneSource, CommandError> {
    load_text(name, &read_original(name)?, overrides)
}

/// Loads the text of a scene of this name, with overrides.
pub fn load_text(name: &str, original: &str, overrides: &[Override]) -> Result<SceneSource, CommandError> {
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    match scene::read_with(original, overrides, &output::scene_file_reader(folder)) {
        Ok(OverriddenScene { text, scene }) => Ok(SceneSource { text, folder: folder.to_path_buf(), scene }),
        Err(OverrideError { overrides, error }) => {
            Err(CommandError::Scene { place: describe_place(name, &overrides), error })
        }
    }
}

/// Loads a scene for an FMU, whose importer chooses a level of `scene.fidelity` later: overrides do not remove levels.
pub fn load_for_fmu(name: &str, overrides: &[Override]) -> Result<SceneSource, CommandError> {
    let source = load(name, overrides)?;
    let bad_input = |error| CommandError::Scene { place: describe_place(name, &[]), error: Box::new(error) };
    let text = scene::rebase_scene(&read_original(name)?, overrides).map_err(bad_input)?;
    let scene = scene::read_with_files(&text, &output::scene_file_reader(&source.folder)).map_err(bad_input)?;
    Ok(SceneSource { text, scene, ..source })
}

fn unreadable_scene(name: &str, error: &std::io::Error) -> CommandError {
    let known: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    let hint = match scene::did_you_mean(name, known.iter().copied()) {
        none if none.is_empty() => projectile_hint(name),
        hint => hint,
    };
    CommandError::BadInput(format!(
        "scene {name}: found neither a built-in scene nor a readable file ({error}){hint}, expected one of {} or the path of a scene file",
        known.join(", ")
    ))
}

/// Question that names projectiles like the name of a scene, and the command that makes a scene of one; empty if none is.
fn projectile_hint(name: &str) -> String {
    let found = scene::suggestions(name, scene::known_projectiles());
    let Some(first) = found.first() else { return String::new() };
    let asked = scene::did_you_mean(name, scene::known_projectiles());
    let asked = asked.trim_end_matches(')');
    format!(
        "{asked} `gelfmu new --projectile {first} --out shot.toml` writes the scene of a shot with this projectile)"
    )
}

/// Names a scene and the overrides at fault, before an error with the line of the user's own text.
fn describe_place(name: &str, overrides: &[Override]) -> String {
    let set: Vec<String> = overrides.iter().map(|o| format!("--set {}={}", o.key, o.value)).collect();
    let with = if set.is_empty() { "" } else { " with " };
    format!("scene {name}{with}{}: ", set.join(" "))
}
