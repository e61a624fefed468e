//! Where a scene comes from: the program itself or a file.

use crate::failure::Failure;
use ballistic_gel::scene::{self, Override, Scene, SceneError};

/// A scene and its text, with all overrides written into it.
#[derive(Debug)]
pub struct Source {
    /// Scene text.
    pub text: String,
    /// The same, read and checked.
    pub scene: Scene,
}

/// The scene of a built-in name or a path, with overrides.
pub fn load(name: &str, overrides: &[Override]) -> Result<Source, Failure> {
    let original = match scene::builtin(name) {
        Some(text) => text.to_owned(),
        None => std::fs::read_to_string(name).map_err(|error| unreadable(name, &error))?,
    };
    let resolved = scene::resolve(&original, overrides);
    let read = resolved.and_then(|text| scene::read(&text).map(|scene| Source { text, scene }));
    read.map_err(|error| Failure::BadInput(complaint(name, &original, overrides, error)))
}

fn unreadable(name: &str, error: &std::io::Error) -> Failure {
    let known: Vec<&str> = scene::builtins().map(|(name, _)| name).collect();
    Failure::BadInput(format!(
        "scene {name}: found neither a built-in scene nor a readable file ({error}), expected one of {} or the path of a scene file",
        known.join(", ")
    ))
}

/// Names the line of the user's own text, or the override where that is at fault.
fn complaint(name: &str, original: &str, overrides: &[Override], error: SceneError) -> String {
    if overrides.is_empty() {
        return format!("scene {name}: {error}");
    }
    match scene::read(original) {
        Err(own) if own.key == error.key => format!("scene {name}: {own}"),
        Ok(_) | Err(_) => format!("scene {name} with --set: {}", SceneError { line: None, ..error }),
    }
}
