//! Parameters: choice of scene, overrides of its values, and run settings.

use super::call::CallError;
use super::logger::CallLog;
use super::manifest::{ArchiveManifest, ManifestError};
use super::ports::VariablePorts;
use super::scalar::{ScalarValues, ScalarVariable, table_of};
use super::table::{Setting, Source, variable_of};
use super::uri;
use crate::output::{read_scene_text, scene_file_reader};
use crate::scene::{self, FileSource, OverriddenScene, Override, Scene, body_name};
use std::io;
use std::path::{Path, PathBuf};

/// Origin of the packed scene.
const PACKED: &str = "resources/scene.toml";
/// File name of the scene in `resources/`.
const SCENE_FILE: &str = "scene.toml";

/// Packed scene: the scene in `resources/` of the archive, with its manifest.
#[derive(Debug, Clone, Default)]
pub(super) struct PackedScene {
    /// Folder of the scene and of its files.
    folder: PathBuf,
    /// Text of the scene.
    text: String,
    /// Manifest of the packed files.
    manifest: ArchiveManifest,
    /// Scene as the source of the starts in `modelDescription.xml`; empty without a readable scene.
    pub starts: toml::Table,
    /// Ports of the scene, those included that were not packed; absent without a readable scene.
    ports: Option<VariablePorts>,
}

impl PackedScene {
    /// Reads the scene at a resource location, a URI, if the archive has this GUID and is unchanged.
    pub(super) fn read_at(location: Option<&str>, guid: &str) -> Result<Self, ManifestError> {
        let misplaced = |found: String| ManifestError::Location { found };
        let location = location.ok_or_else(|| misplaced("none".to_owned()))?;
        let folder = uri::to_path(location).map_err(misplaced)?;
        let manifest = ArchiveManifest::verified(&folder, guid)?;
        let text = manifest.read(&folder, SCENE_FILE)?;
        let text = String::from_utf8(text).map_err(|e| ManifestError::Unreadable {
            path: folder.join(SCENE_FILE).display().to_string(),
            reason: e.to_string(),
        })?;
        let mut packed = Self { folder, text, manifest, starts: toml::Table::new(), ports: None };
        if let Ok(scene) = scene::read_with_files(&packed.text, &|name| packed.read_file(name)) {
            (packed.starts, packed.ports) = (table_of(&scene), Some(VariablePorts::of(&scene)));
        }
        Ok(packed)
    }

    /// Reads a file packed with the scene.
    fn read_file(&self, name: &str) -> io::Result<Vec<u8>> {
        self.manifest.read(&self.folder, name).map_err(io::Error::other)
    }

    /// Returns the scene at a path, or the packed scene for an empty path, with the overrides applied.
    pub(super) fn resolve(
        &self,
        path: &str,
        overrides: &ScalarValues,
        log: &mut CallLog,
    ) -> Result<ResolvedScene, CallError> {
        let base = if path.is_empty() {
            self.read_scene(PACKED.to_owned(), self.text.clone())?
        } else {
            let no_scene = |e| CallError::NoScene { reason: format!("cannot read {path}: {e}") };
            let other = self.read_scene(path.to_owned(), read_scene_text(Path::new(path)).map_err(no_scene)?)?;
            self.expect_inputs(path, &other.scene)?;
            other
        };
        let overrides = changed_overrides(overrides, &self.starts, &table_of(&base.scene))?;
        if overrides.is_empty() {
            return Ok(base);
        }
        for o in &overrides {
            log.event(format!("override: {} = {}", o.key, o.value));
        }
        let ResolvedScene { origin, text, .. } = base;
        match scene::read_with(&text, &overrides, &*self.files_of(&origin)) {
            Ok(OverriddenScene { text, scene }) => Ok(ResolvedScene { origin, text, scene }),
            Err(fault) => {
                Err(CallError::Scene { origin: origin_with_faults(origin, &fault.overrides), error: fault.error })
            }
        }
    }

    /// Refuses another scene with an input that the packed scene cannot use.
    fn expect_inputs(&self, path: &str, scene: &Scene) -> Result<(), CallError> {
        let missing = self.ports.as_ref().and_then(|ports| ports.missing_input(&VariablePorts::of(scene)));
        let Some(missing) = missing else { return Ok(()) };
        Err(CallError::MissingInput { name: missing.name(), path: path.to_owned() })
    }

    /// Parses the scene of an origin and a text, with the files in its folder.
    pub(super) fn read_scene(&self, origin: String, text: String) -> Result<ResolvedScene, CallError> {
        match scene::read_with_files(&text, &*self.files_of(&origin)) {
            Ok(scene) => Ok(ResolvedScene { origin, text, scene }),
            Err(error) => Err(CallError::Scene { origin, error: Box::new(error) }),
        }
    }

    /// Returns a reader of the files named by a scene of this origin: packed files, or files relative to its folder.
    fn files_of(&self, origin: &str) -> Box<FileSource<'_>> {
        if origin == PACKED {
            return Box::new(|name| self.read_file(name));
        }
        Box::new(scene_file_reader(Path::new(origin).parent().unwrap_or(Path::new(""))))
    }

    /// Returns the input files of a scene of this origin: the files that it names, and its own.
    pub(super) fn files_read(&self, origin: &str, scene: &Scene) -> Vec<PathBuf> {
        let path = if origin == PACKED { self.folder.join(SCENE_FILE) } else { PathBuf::from(origin) };
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut files: Vec<PathBuf> = scene.files().iter().map(|(_, name)| folder.join(name)).collect();
        files.push(path);
        files
    }
}

/// Parsed scene with origin and text.
pub(super) struct ResolvedScene {
    /// Origin of the scene.
    pub origin: String,
    /// Text of the scene.
    pub text: String,
    /// Parsed scene.
    pub scene: Scene,
}

/// Parameters without a scene key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RunSettings {
    /// Path of another scene; empty for the packed scene.
    pub scene: String,
    /// Threads of the element loop; 0 for all cores.
    pub threads: usize,
    /// Folder of the output; empty for no output.
    pub output_directory: String,
}

/// Returns the greatest allowed number of threads.
///
/// # Panics
/// If the table of variables gives the parameter `threads` no maximum; the table does.
#[must_use]
pub fn most_threads() -> usize {
    variable_of(Source::Setting(Setting::Threads)).max.expect("the table bounds the threads") as usize
}

impl Default for RunSettings {
    fn default() -> Self {
        Self { scene: String::new(), threads: 1, output_directory: String::new() }
    }
}

impl RunSettings {
    /// Returns an Integer setting.
    pub(super) fn integer(&self, setting: Setting) -> Option<i32> {
        match setting {
            Setting::Threads => i32::try_from(self.threads).ok(),
            Setting::Scene | Setting::OutputDirectory => None,
        }
    }

    /// Returns a String setting.
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

/// Returns the origin of a scene with the parameters at fault.
fn origin_with_faults(origin: String, overrides: &[Override]) -> String {
    if overrides.is_empty() {
        return origin;
    }
    let set = overrides.iter().map(|o| format!("{} = {}", parameter_name(&o.key), o.value));
    format!("{origin} with the parameters {}", set.collect::<Vec<_>>().join(", "))
}

/// Returns the name of the parameter of a scene key.
fn parameter_name(key: &str) -> String {
    let is_overriding = |s: &ScalarVariable| s.variable.source == Source::Scene && s.keys().any(|own| own == key);
    VariablePorts::all().scalars().find(is_overriding).map_or_else(|| key.to_owned(), |scalar| scalar.row_name())
}

/// Returns the overrides that differ from their starts, as scene keys and TOML values.
fn changed_overrides(set: &ScalarValues, starts: &toml::Table, base: &toml::Table) -> Result<Vec<Override>, CallError> {
    let scalars = set.keys().filter_map(|reference| ScalarVariable::find(*reference));
    let mut rows: Vec<ScalarVariable> = scalars.map(|scalar| ScalarVariable { component: 0, ..scalar }).collect();
    rows.dedup();
    rows.iter().filter_map(|row| override_of_row(row, set, starts, base).transpose()).collect()
}

fn override_of_row(
    row: &ScalarVariable,
    set: &ScalarValues,
    starts: &toml::Table,
    base: &toml::Table,
) -> Result<Option<Override>, CallError> {
    let differing = |scalar: &ScalarVariable| {
        let value = set.get(&scalar.reference()).copied();
        value.filter(|v| scalar.start(starts) != Some(*v))
    };
    let components = || ScalarVariable::of(row.variable, row.body);
    let Some((scalar, found)) = components().find_map(|scalar| Some((scalar, differing(&scalar)?))) else {
        return Ok(None);
    };
    let key = row.key_in(base).ok_or_else(|| {
        let expected = format!("to be left alone: the {} of this scene has none", body_name(row.body));
        CallError::value(scalar.row_name(), found, expected)
    })?;
    let value = |scalar: ScalarVariable| differing(&scalar).or_else(|| scalar.start(base)).unwrap_or(0.0);
    let items: Vec<String> = components().map(|scalar| scalar.toml(value(scalar))).collect();
    let value = if row.variable.length == 0 { items.concat() } else { format!("[{}]", items.join(", ")) };
    Ok(Some(Override { key, value }))
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
        let set = ScalarValues::from([(21, 1e3), (37, 0.01), (42, 0.01)]);
        assert_eq!(changed_overrides(&set, &starts, &other).unwrap(), []);
    }

    #[test]
    fn one_component_leaves_the_others_as_the_scene_has_them() {
        let mut other = sphere();
        other["projectile"]["position"] = toml::Value::Array(vec![1.0.into(), 2.0.into(), 3.0.into()]);
        let made = changed_overrides(&ScalarValues::from([(42, 0.5)]), &sphere(), &other).unwrap();
        assert_eq!(made, [Override { key: "projectile.position".into(), value: "[1.0, 2.0, 0.5]".into() }]);
    }

    #[test]
    fn a_radius_goes_to_the_shape_that_the_scene_has() {
        let made = changed_overrides(&ScalarValues::from([(37, 2e-5)]), &sphere(), &sphere()).unwrap();
        assert_eq!(made, [Override { key: "projectile.shape.sphere.radius".into(), value: "2e-5".into() }]);
        for shape in ["capsule", "bullet"] {
            let other: toml::Table = toml::from_str(&format!("[projectile.shape.{shape}]\nradius = 0.01")).unwrap();
            let made = changed_overrides(&ScalarValues::from([(37, 2e-5)]), &sphere(), &other).unwrap();
            assert_eq!(made[0].key, format!("projectile.shape.{shape}.radius"));
        }
        let flat: toml::Table = toml::from_str("[projectile.shape.half-space]\nnormal = [0, 0, 1]").unwrap();
        let refused = changed_overrides(&ScalarValues::from([(37, 2e-5)]), &sphere(), &flat).unwrap_err();
        assert!(refused.to_string().starts_with("projectile.radius = 0.00002"), "{refused}");
    }

    #[test]
    fn a_parameter_replaces_a_value_of_the_library_and_its_name() {
        let own = "shape.sphere.radius = 2.185e-3\nmass = 0.343e-3";
        let text = scene::builtin("fbi-bb").unwrap();
        assert!(text.contains(own));
        let text = text.replace(own, "library = \"bb\"");
        let starts = table_of(&scene::read(&text).unwrap());
        let packed = PackedScene { text, starts, ..PackedScene::default() };
        let resolve = |mass| packed.resolve("", &ScalarValues::from([(30, mass)]), &mut CallLog::new(false));
        let heavy = resolve(0.35e-3).unwrap().scene.projectile;
        assert_eq!((heavy.library, heavy.mass), (None, Some(0.35e-3)));
        let start = resolve(0.343e-3).unwrap().scene.projectile;
        assert_eq!((start.library.as_deref(), start.mass), (Some("bb"), Some(0.343e-3)));
    }

    #[test]
    fn a_path_must_be_absolute() {
        let mut settings = RunSettings::default();
        assert!(settings.set_text(Setting::Scene, "a.toml").unwrap_err().to_string().contains("absolute"));
        settings.set_text(Setting::Scene, "/a.toml").unwrap();
        assert_eq!(settings.text(Setting::Scene), Some("/a.toml"));
    }
}
