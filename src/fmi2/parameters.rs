//! Parameters: which scene, which of its values overridden, and how to run it.

use super::call::CallError;
use super::instance::{Instance, Values};
use super::manifest::{Manifest, ManifestError};
use super::reading::{files_in, read_scene_text};
use super::scalar::{Ports, Scalar, scalars, table_of};
use super::table::{Setting, Source, row};
use super::uri;
use crate::scene::{self, Files, MOST_FRAGMENTS, Override, Scene, body_name};
use std::io;
use std::path::{Path, PathBuf};

/// The origin of the scene in the archive.
const PACKED: &str = "resources/scene.toml";
/// Name of the scene in `resources/`.
const SCENE_FILE: &str = "scene.toml";

/// The scene in `resources/` of the archive, and the manifest that it was packed with.
#[derive(Debug, Clone, Default)]
pub(super) struct Packed {
    /// The folder of the scene and of the files that it names.
    folder: PathBuf,
    /// Its text.
    text: String,
    /// The files that were packed with it.
    manifest: Manifest,
    /// The starts in `modelDescription.xml` were written from this; empty without a readable scene.
    pub starts: toml::Table,
}

impl Packed {
    /// Reads the scene at a resource location, a URI, if the archive has this GUID and is as it was packed.
    pub(super) fn at(location: Option<&str>, guid: &str) -> Result<Self, ManifestError> {
        let misplaced = |found: String| ManifestError::Location { found };
        let location = location.ok_or_else(|| misplaced("none".to_owned()))?;
        let folder = uri::to_path(location).map_err(misplaced)?;
        let manifest = Manifest::verified(&folder, guid)?;
        let text = manifest.read(&folder, SCENE_FILE)?;
        let text = String::from_utf8(text).map_err(|e| ManifestError::Unreadable {
            path: folder.join(SCENE_FILE).display().to_string(),
            reason: e.to_string(),
        })?;
        let mut packed = Self { folder, text, manifest, starts: toml::Table::new() };
        let scene = scene::read_with_files(&packed.text, &|name| packed.file(name));
        packed.starts = scene.as_ref().map(table_of).unwrap_or_default();
        Ok(packed)
    }

    /// Reads a file that was packed with the scene.
    fn file(&self, name: &str) -> io::Result<Vec<u8>> {
        self.manifest.read(&self.folder, name).map_err(io::Error::other)
    }
}

/// A scene that was read.
pub(super) struct Resolved {
    /// Where it comes from.
    pub origin: String,
    /// Its text.
    pub text: String,
    /// What the text says.
    pub scene: Scene,
}

/// Parameters that are no scene keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Settings {
    /// Path of another scene; empty for the packed one.
    pub scene: String,
    /// Threads of the element loop; 0 for all cores.
    pub threads: usize,
    /// Folder of the output; empty for none.
    pub output_directory: String,
}

/// Most threads that can be asked for.
///
/// # Panics
/// If the table of variables gives the parameter `threads` no maximum; it does.
#[must_use]
pub fn most_threads() -> usize {
    row(Source::Setting(Setting::Threads)).max.expect("the table bounds the threads") as usize
}

impl Default for Settings {
    fn default() -> Self {
        Self { scene: String::new(), threads: 1, output_directory: String::new() }
    }
}

impl Settings {
    /// An Integer setting.
    pub(super) fn integer(&self, setting: Setting) -> Option<i32> {
        match setting {
            Setting::Threads => i32::try_from(self.threads).ok(),
            Setting::Scene | Setting::OutputDirectory => None,
        }
    }

    /// A String setting.
    pub(super) fn text(&self, setting: Setting) -> Option<&str> {
        match setting {
            Setting::Scene => Some(&self.scene),
            Setting::OutputDirectory => Some(&self.output_directory),
            Setting::Threads => None,
        }
    }

    /// Sets an Integer setting.
    pub(super) fn set_integer(&mut self, setting: Setting, value: i32) -> Result<(), CallError> {
        match setting {
            Setting::Threads => {
                let threads = usize::try_from(value).ok().filter(|n| *n <= most_threads());
                let expected = || format!("0 for all cores, or a number of threads up to {}", most_threads());
                self.threads = threads.ok_or_else(|| CallError::value("threads", value, expected()))?;
            }
            Setting::Scene | Setting::OutputDirectory => unreachable!("the table has these as String"),
        }
        Ok(())
    }

    /// Sets a String setting, an absolute path or empty.
    pub(super) fn set_text(&mut self, setting: Setting, value: &str) -> Result<(), CallError> {
        let (name, field) = match setting {
            Setting::Scene => ("scene", &mut self.scene),
            Setting::OutputDirectory => ("output_directory", &mut self.output_directory),
            Setting::Threads => unreachable!("the table has this as Integer"),
        };
        if !value.is_empty() && !Path::new(value).is_absolute() {
            return Err(CallError::value(name, format!("{value:?}"), "an absolute path, or nothing"));
        }
        *field = value.to_string();
        Ok(())
    }
}

impl Instance {
    /// The scene with the overrides written into it.
    pub(super) fn resolved_scene(&mut self) -> Result<Resolved, CallError> {
        let (origin, text) = self.scene_text()?;
        let base = self.read_scene(origin, text)?;
        let overrides = overrides(&self.overrides, &self.packed.starts, &table_of(&base.scene))?;
        if overrides.is_empty() {
            return Ok(base);
        }
        for o in &overrides {
            self.log.event(format!("override: {} = {}", o.key, o.value));
        }
        let Resolved { origin, text, .. } = base;
        match scene::read_with(&text, &overrides, &*self.files_of(&origin)) {
            Ok((text, scene)) => Ok(Resolved { origin, text, scene }),
            Err(fault) => Err(CallError::Scene { origin: blamed(origin, &fault.overrides), error: fault.error }),
        }
    }

    /// The scene of an origin and a text, with the files in its folder.
    pub(super) fn read_scene(&self, origin: String, text: String) -> Result<Resolved, CallError> {
        match scene::read_with_files(&text, &*self.files_of(&origin)) {
            Ok(scene) => Ok(Resolved { origin, text, scene }),
            Err(error) => Err(CallError::Scene { origin, error: Box::new(error) }),
        }
    }

    /// The files that a scene of this origin names: packed with it, or relative to its folder.
    fn files_of(&self, origin: &str) -> Box<Files<'_>> {
        if origin == PACKED {
            return Box::new(|name| self.packed.file(name));
        }
        Box::new(files_in(Path::new(origin).parent().unwrap_or(Path::new(""))))
    }

    /// Files that the model was read from: the scene, and those that it names.
    pub(super) fn files_read(&mut self) -> Result<Vec<PathBuf>, CallError> {
        self.model()?;
        let Some(model) = &self.model else { return Ok(vec![]) };
        let is_packed = model.origin == PACKED;
        let scene = if is_packed { self.packed.folder.join(SCENE_FILE) } else { PathBuf::from(&model.origin) };
        let folder = scene.parent().unwrap_or(Path::new(""));
        let named = model.scene.files().iter().map(|(_, name)| folder.join(name)).collect::<Vec<_>>();
        Ok(named.into_iter().chain([scene]).collect())
    }

    fn scene_text(&self) -> Result<(String, String), CallError> {
        match self.settings.scene.as_str() {
            "" => Ok((PACKED.to_string(), self.packed.text.clone())),
            path => {
                let text = read_text(Path::new(path)).map_err(|reason| CallError::NoScene { reason })?;
                Ok((path.to_string(), text))
            }
        }
    }
}

/// The origin of a scene, and the parameters that are at fault.
fn blamed(origin: String, overrides: &[Override]) -> String {
    if overrides.is_empty() {
        return origin;
    }
    let set = overrides.iter().map(|o| format!("{} = {}", parameter_of(&o.key), o.value));
    format!("{origin} with the parameters {}", set.collect::<Vec<_>>().join(", "))
}

/// Name of the parameter that overrides a scene key.
fn parameter_of(key: &str) -> String {
    let overriding = |s: &Scalar| s.variable.source == Source::Scene && s.keys().any(|own| own == key);
    let ports = Ports { fragments: MOST_FRAGMENTS, sensors: 0 };
    scalars(ports).find(overriding).map_or_else(|| key.to_owned(), |scalar| scalar.row_name())
}

/// The overrides that differ from their starts, as scene keys and TOML values.
fn overrides(set: &Values, starts: &toml::Table, base: &toml::Table) -> Result<Vec<Override>, CallError> {
    let scalars = set.keys().filter_map(|reference| Scalar::find(*reference));
    let mut rows: Vec<Scalar> = scalars.map(|scalar| Scalar { component: 0, ..scalar }).collect();
    rows.dedup();
    rows.iter().filter_map(|row| one_override(row, set, (starts, base)).transpose()).collect()
}

fn one_override(
    row: &Scalar,
    set: &Values,
    (starts, base): (&toml::Table, &toml::Table),
) -> Result<Option<Override>, CallError> {
    let differing = |scalar: &Scalar| {
        let value = set.get(&scalar.reference()).copied();
        value.filter(|v| scalar.start(starts) != Some(*v))
    };
    let components = || Scalar::of(row.variable, row.body);
    let Some((scalar, found)) = components().find_map(|scalar| Some((scalar, differing(&scalar)?))) else {
        return Ok(None);
    };
    let key = row.key_in(base).ok_or_else(|| {
        let expected = format!("to be left alone: the {} of this scene has none", body_name(row.body));
        CallError::value(scalar.row_name(), found, expected)
    })?;
    let value = |scalar: Scalar| differing(&scalar).or_else(|| scalar.start(base)).unwrap_or(0.0);
    let items: Vec<String> = components().map(|scalar| scalar.toml(value(scalar))).collect();
    let value = if row.variable.length == 0 { items.concat() } else { format!("[{}]", items.join(", ")) };
    Ok(Some(Override { key, value }))
}

fn read_text(path: &Path) -> Result<String, String> {
    read_scene_text(path).map_err(|e| format!("cannot read {}: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sphere() -> toml::Table {
        toml::from_str(
            "[gel]\nshear_modulus = 1e3\n[projectile]\nmass = 0.5\nposition = [0.0, 0.0, 0.01]\n\
             [projectile.shape.sphere]\nradius = 0.01",
        )
        .unwrap()
    }

    #[test]
    fn a_value_equal_to_its_start_overrides_nothing() {
        let starts = sphere();
        let mut other = sphere();
        other["gel"]["shear_modulus"] = toml::Value::Float(7e3);
        let set = Values::from([(21, 1e3), (37, 0.01), (42, 0.01)]);
        assert_eq!(overrides(&set, &starts, &other).unwrap(), []);
    }

    #[test]
    fn one_component_leaves_the_others_as_the_scene_has_them() {
        let mut other = sphere();
        other["projectile"]["position"] = toml::Value::Array(vec![1.0.into(), 2.0.into(), 3.0.into()]);
        let made = overrides(&Values::from([(42, 0.5)]), &sphere(), &other).unwrap();
        assert_eq!(made, [Override { key: "projectile.position".into(), value: "[1.0, 2.0, 0.5]".into() }]);
    }

    #[test]
    fn a_radius_goes_to_the_shape_that_the_scene_has() {
        let made = overrides(&Values::from([(37, 2e-5)]), &sphere(), &sphere()).unwrap();
        assert_eq!(made, [Override { key: "projectile.shape.sphere.radius".into(), value: "2e-5".into() }]);
        for shape in ["capsule", "bullet"] {
            let other: toml::Table = toml::from_str(&format!("[projectile.shape.{shape}]\nradius = 0.01")).unwrap();
            let made = overrides(&Values::from([(37, 2e-5)]), &sphere(), &other).unwrap();
            assert_eq!(made[0].key, format!("projectile.shape.{shape}.radius"));
        }
        let flat: toml::Table = toml::from_str("[projectile.shape.half-space]\nnormal = [0, 0, 1]").unwrap();
        let refused = overrides(&Values::from([(37, 2e-5)]), &sphere(), &flat).unwrap_err();
        assert!(refused.to_string().starts_with("projectile.radius = 0.00002"), "{refused}");
    }

    #[test]
    fn a_path_must_be_absolute() {
        let mut settings = Settings::default();
        assert!(settings.set_text(Setting::Scene, "a.toml").unwrap_err().to_string().contains("absolute"));
        settings.set_text(Setting::Scene, "/a.toml").unwrap();
        assert_eq!(settings.text(Setting::Scene), Some("/a.toml"));
    }
}
