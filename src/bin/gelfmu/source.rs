//! Where a scene comes from: the program itself or a file.

use crate::failure::Failure;
use ballistic_gel::fmi2;
use ballistic_gel::scene::{self, Fault, Override, Scene};
use std::path::{Path, PathBuf};

/// A scene and its text, with all overrides written into it.
#[derive(Debug)]
pub struct Source {
    /// Scene text.
    pub text: String,
    /// The folder that it is in, to which the names of its files are relative.
    pub folder: PathBuf,
    /// The same, read and checked.
    pub scene: Scene,
}

/// The text of a built-in name or a path.
fn original(name: &str) -> Result<String, Failure> {
    match scene::builtin(name) {
        Some(text) => Ok(text.to_owned()),
        None => fmi2::read_scene_text(Path::new(name)).map_err(|error| unreadable(name, &error)),
    }
}

/// The scene of a built-in name or a path, with overrides.
pub fn load(name: &str, overrides: &[Override]) -> Result<Source, Failure> {
    let original = original(name)?;
    let folder = Path::new(name).parent().unwrap_or(Path::new(""));
    match scene::read_with(&original, overrides, &fmi2::files_in(folder)) {
        Ok((text, scene)) => Ok(Source { text, folder: folder.to_path_buf(), scene }),
        Err(fault) => Err(Failure::BadInput(complaint(name, &fault))),
    }
}

/// Loads a scene for an FMU, whose importer chooses a level of `scene.fidelity` later: the overrides take nothing from the levels.
pub fn load_standard(name: &str, overrides: &[Override]) -> Result<Source, Failure> {
    let source = load(name, overrides)?;
    let unusual = |error| Failure::BadInput(format!("scene {name}: {error}"));
    let text = scene::rebase(&original(name)?, overrides).map_err(unusual)?;
    let scene = scene::read_with_files(&text, &fmi2::files_in(&source.folder)).map_err(unusual)?;
    Ok(Source { text, scene, ..source })
}

/// The scene of a file whose names of files are relative to a folder.
pub fn load_from(path: &Path, folder: &Path) -> Result<Scene, Failure> {
    let name = path.display().to_string();
    let text = fmi2::read_scene_text(path).map_err(|error| unreadable(&name, &error))?;
    let read = scene::read_with_files(&text, &fmi2::files_in(folder));
    read.map_err(|error| Failure::BadInput(format!("scene {name}: {error}")))
}

fn unreadable(name: &str, error: &std::io::Error) -> Failure {
    let known: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    let hint = scene::did_you_mean(name, known.iter().copied());
    Failure::BadInput(format!(
        "scene {name}: found neither a built-in scene nor a readable file ({error}){hint}, expected one of {} or the path of a scene file",
        known.join(", ")
    ))
}

/// Names the line of the user's own text, or the overrides where they are at fault.
fn complaint(name: &str, fault: &Fault) -> String {
    let set: Vec<String> = fault.overrides.iter().map(|o| format!("--set {}={}", o.key, o.value)).collect();
    let with = if set.is_empty() { "" } else { " with " };
    format!("scene {name}{with}{}: {}", set.join(" "), fault.error)
}
