//! Reads a scene text into a checked scene.

use super::named_body::{NamedBody, named_bodies};
use super::overrides::{Override, apply_level, keys_overlap, level_error};
use super::places::{KeyLocations, join, numbered};
use super::quantity::si_text;
use super::removed_keys::refuse_removed_keys;
use super::validate::validate;
use super::{FileSource, Scene, SceneError, explain, files, fill, no_files, resolve};
use serde::Deserialize;
use toml::de::{DeTable, DeValue, Deserializer};

/// Greatest size of a scene text, bytes: two hundred times that of the longest built-in scene.
pub const MOST_BYTES: usize = 1 << 20;

/// Reads and checks a scene that names no files.
///
/// # Errors
/// [`SceneError`] for the first invalid value, with key, line, value found and values expected.
///
/// # Examples
/// ```
/// use ballistic_gel::scene;
///
/// let text = scene::builtin("sphere-block").unwrap();
/// assert_eq!(scene::read(text)?.scene.end_time, 0.01);
///
/// let error = scene::read(&text.replace("end_time = 10e-3", "end_time = -1.0")).unwrap_err();
/// assert_eq!(error.key, "scene.end_time");
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn read(text: &str) -> Result<Scene, SceneError> {
    read_with_files(text, &no_files)
}

/// Reads and checks a scene, with the files that it names.
///
/// # Errors
/// An error of [`read`], or an error for the first file that cannot be read or has invalid content.
pub fn read_with_files(text: &str, files: &FileSource<'_>) -> Result<Scene, SceneError> {
    let scene = read_without_level(text, files)?;
    match apply_level(text, &scene) {
        Ok(None) => Ok(scene),
        Ok(Some(other)) => {
            read_without_level(&other, files).map_err(|error| with_line(text, level_error(&scene, &error)))
        }
        Err(error) => Err(with_line(text, error)),
    }
}

/// Error of a scene with overrides, attributed to the text or to overrides.
#[derive(Debug, Clone, PartialEq)]
pub struct OverrideError {
    /// Scene error. It has a line only where the text is at fault.
    pub error: Box<SceneError>,
    /// Overrides at fault; empty if the text is at fault.
    pub overrides: Vec<Override>,
}

impl OverrideError {
    fn of_text(error: SceneError) -> Self {
        Self { error: Box::new(error), overrides: Vec::new() }
    }

    /// Attributes the error to the overrides of the wrong key, or to all of them if none has that key.
    fn of_overrides(error: SceneError, overrides: &[Override]) -> Self {
        let touching: Vec<Override> = overrides.iter().filter(|o| keys_overlap(&o.key, &error.key)).cloned().collect();
        let overrides = if touching.is_empty() { overrides.to_vec() } else { touching };
        Self { error: Box::new(SceneError { line: None, ..error }), overrides }
    }
}

/// Scene with overrides.
#[derive(Debug, Clone, PartialEq)]
pub struct OverriddenScene {
    /// Scene text with the overrides.
    pub text: String,
    /// Parsed and checked scene.
    pub scene: Scene,
}

/// Reads a scene text with overrides and the files that it names.
///
/// # Errors
/// [`OverrideError`] with the key, the value found and the values expected. It carries the line if the text has the
/// same error without the overrides, otherwise the overrides that caused it.
pub fn read_with(text: &str, overrides: &[Override], files: &FileSource<'_>) -> Result<OverriddenScene, OverrideError> {
    let resolved = resolve(text, overrides);
    let error =
        match resolved.and_then(|text| read_with_files(&text, files).map(|scene| OverriddenScene { text, scene })) {
            Ok(made) => return Ok(made),
            Err(error) => error,
        };
    if overrides.is_empty() {
        return Err(OverrideError::of_text(error));
    }
    match read_with_files(text, files) {
        Err(own) if own.key == error.key && !overrides.iter().any(|o| keys_overlap(&o.key, &own.key)) => {
            Err(OverrideError::of_text(own))
        }
        Ok(_) | Err(_) => Err(OverrideError::of_overrides(error, overrides)),
    }
}

/// Adds to an error the line on which its key is set.
fn with_line(text: &str, error: SceneError) -> SceneError {
    let line = DeTable::parse(text).ok().and_then(|table| KeyLocations::of(text, table.get_ref()).line_of(&error.key));
    SceneError { line, ..error }
}

/// Reads and checks a scene without applying its fidelity level.
fn read_without_level(text: &str, files: &FileSource<'_>) -> Result<Scene, SceneError> {
    if text.len() > MOST_BYTES {
        let found = format!("{} bytes", text.len());
        return Err(SceneError::value("", found, format!("the text of a scene, of at most {MOST_BYTES} bytes")));
    }
    let text = &*si_text(text)?;
    let parsed = DeTable::parse(text);
    let table = parsed.map_err(|error| explain::syntax_error(text, error.span(), error.message()))?;
    let places = KeyLocations::of(text, table.get_ref());
    let at_its_line = |error: SceneError| SceneError { line: places.line_of(&error.key), ..error };
    refuse_removed_keys(table.get_ref()).map_err(at_its_line)?;
    let shear_modulus = fill::shear_modulus(table.get_ref());
    let bodies = named_bodies(table.get_ref()).map_err(at_its_line)?;
    let values: Result<Vec<_>, SceneError> = bodies.iter().map(NamedBody::missing_values).collect();
    let values = values.map_err(at_its_line)?;
    let mut whole = table.clone();
    fill::fill_gel(whole.get_mut(), shear_modulus.as_deref());
    fill::fill_layers(whole.get_mut());
    bodies.iter().zip(&values).for_each(|(body, values)| fill::fill_named(whole.get_mut(), body, values));
    let scene = Scene::deserialize(Deserializer::from(whole));
    let mut scene = scene.map_err(|error| explain::content_error(text, &places, &error))?;
    let checked = check_lengths(table.get_ref(), &scene)
        .and_then(|()| files::attach_files(&mut scene, files))
        .and_then(|()| validate(&scene));
    checked.map_err(at_its_line)?;
    Ok(scene.with_masses())
}

/// Refuses lists that serde read only in part, and lists where a table is expected.
fn check_lengths(text: &DeTable<'_>, scene: &Scene) -> Result<(), SceneError> {
    match toml::Table::try_from(scene) {
        Ok(read) => compare_tables("", text, &read),
        Err(error) => unreachable!("a scene that was read from TOML can be written as TOML: {error}"),
    }
}

fn compare_tables(prefix: &str, text: &DeTable<'_>, read: &toml::Table) -> Result<(), SceneError> {
    for (name, value) in text {
        if let Some(same) = read.get(name.get_ref().as_ref()) {
            compare_values(&join(prefix, name.get_ref()), value.get_ref(), same)?;
        }
    }
    Ok(())
}

fn compare_values(key: &str, text: &DeValue<'_>, read: &toml::Value) -> Result<(), SceneError> {
    match (text, read) {
        (DeValue::Table(text), toml::Value::Table(read)) => compare_tables(key, text, read),
        (DeValue::Array(_), toml::Value::Table(_)) => Err(SceneError::value(key, "a list", "a table")),
        (DeValue::Array(text), toml::Value::Array(read)) if text.len() != read.len() => {
            Err(SceneError::value(key, format!("{} entries", text.len()), format!("{} entries", read.len())))
        }
        (DeValue::Array(text), toml::Value::Array(read)) => {
            let pairs = text.iter().zip(read).enumerate();
            let mut tables = pairs.filter(|(_, (text, _))| matches!(text.get_ref(), DeValue::Table(_)));
            tables.try_for_each(|(i, (text, read))| compare_values(&numbered(key, i), text.get_ref(), read))
        }
        _ => Ok(()),
    }
}
