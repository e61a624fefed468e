//! Library of projectiles: service and test projectiles as rigid bodies, each value with its source.

use super::quantity::si_text;
use super::{BodyShape, ExpansionSpec, KnownName, ProjectileSpec, SceneError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the library. It rises whenever a value of a body changes, with `since` of its projectile.
pub const LIBRARY_VERSION: u32 = 1;

/// Kind of a projectile of the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectileKind {
    /// Sphere, cylinder or fragment simulator of a laboratory.
    Test,
    /// Bullet as it leaves the barrel.
    Service,
    /// Bullet as it leaves the barrel, which expands in the gel.
    Expanding,
    /// Expanded bullet in the shape in which it was recovered from the gel.
    Recovered,
}

/// Projectile of the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LibraryProjectile {
    /// Name, as given to `gelfmu new --projectile`.
    pub name: String,
    /// Title: one line.
    pub title: String,
    /// Kind.
    pub kind: ProjectileKind,
    /// Usual speed at the gel, m/s.
    pub speed: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Inertia about the centre of mass, kg m2: xx, yy, zz, xy, xz, yz; that of the homogeneous body if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 6]>,
    /// Shape.
    pub shape: BodyShape,
    /// Expansion in the gel; a rigid body if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expansion: Option<ExpansionSpec>,
    /// Behaviour of the real projectile that a rigid one does not have.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_modelled: Option<String>,
    /// Version of the library from which on the body has these values.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub since: u32,
    /// Source of each value by its key, or by the beginning of several keys.
    pub source: BTreeMap<String, String>,
}

fn first() -> u32 {
    1
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_first(version: &u32) -> bool {
    *version == first()
}

/// Value of a body of the library.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LibraryValue {
    /// Dotted key in the table of the body, such as `shape.sphere.radius`.
    pub key: String,
    /// Value as TOML, SI units.
    pub value: String,
    /// Source.
    pub source: String,
}

impl LibraryValue {
    /// Key of the table of a body that the value belongs to: `mass`, `shape`, `inertia` or `expansion`.
    #[must_use]
    pub fn quantity(&self) -> &str {
        self.key.split('.').next().unwrap_or_default()
    }
}

/// Value of a body that differs from that of its projectile of the library.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DifferingValue {
    /// Key in the table of the body: `mass`, `shape`, `inertia` or `expansion`.
    pub key: &'static str,
    /// Value of the body, and value of the library.
    pub values: [String; 2],
}

/// Reads the files of the library at compile time, by their names.
macro_rules! library {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../projectiles/", $name, ".toml")))),*]
    };
}

const LIBRARY: [(&str, &str); 43] = library![
    "bb",
    "sphere-4.8mm",
    "sphere-5.5mm",
    "lead-ball-31",
    "buckshot-1",
    "buckshot-00",
    "fsp-0.16g",
    "fsp-1.1g",
    "fsp-2.84g",
    "rcc-1.1g",
    "rcc-4.15g",
    "22lr",
    "9mm-fmj",
    "9mm-fmj-115gr",
    "45acp-fmj",
    "38-lrn",
    "357mag-fmj",
    "556-m193",
    "762x39-m43",
    "545x39-7n6",
    "762-m80",
    "45acp-230-xtp",
    "45acp-200-xtp",
    "45acp-230-black-talon",
    "45acp-185-remington",
    "45acp-185-silvertip",
    "45acp-185-silvertip-later",
    "38p-158-lswchp",
    "9mm-147-black-talon",
    "9mm-115-jhp",
    "40sw-165-hydra-shok",
    "45acp-230-xtp-recovered",
    "45acp-200-xtp-recovered",
    "45acp-230-black-talon-recovered",
    "45acp-185-remington-recovered",
    "45acp-185-silvertip-recovered",
    "45acp-185-silvertip-later-recovered",
    "38p-158-lswchp-recovered",
    "9mm-147-black-talon-recovered",
    "9mm-115-jhp-recovered",
    "9mm-115-jhp-clothed-recovered",
    "40sw-165-hydra-shok-recovered",
    "40sw-165-hydra-shok-clothed-recovered",
];

/// Names and texts of the projectiles of the library.
pub fn library() -> impl Iterator<Item = (&'static str, &'static str)> {
    LIBRARY.into_iter()
}

/// Names of the projectiles of the library, described by their titles and the usual abbreviations for their bullets.
pub fn known_projectiles() -> impl Iterator<Item = KnownName<'static>> {
    let projectiles = LIBRARY.into_iter().filter_map(|(name, _)| Some((name, LibraryProjectile::named(name)?)));
    projectiles.map(|(name, LibraryProjectile { title, kind, .. })| {
        let is_expanding = matches!(kind, ProjectileKind::Expanding | ProjectileKind::Recovered);
        let hollow_point = if is_expanding { "jhp hp hollow point" } else { "" };
        let full_jacket = if title.contains("full metal jacket") { "fmj" } else { "" };
        KnownName { name, description: format!("{title} {hollow_point} {full_jacket}") }
    })
}

impl LibraryProjectile {
    /// Projectile of a name, if the library has it.
    ///
    /// # Examples
    /// ```
    /// use ballistic_gel::scene::LibraryProjectile;
    ///
    /// let bullet = LibraryProjectile::named("9mm-fmj").unwrap();
    /// assert!((bullet.mass / 8.04e-3 - 1.0).abs() < 1e-3);
    /// ```
    ///
    /// # Panics
    /// Never: the texts of the library are tested.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let (_, text) = library().find(|(known, _)| *known == name)?;
        Some(Self::read(text).unwrap_or_else(|error| unreachable!("{name} of the library can be read: {error}")))
    }

    /// Reads the text of a projectile, with units.
    ///
    /// # Errors
    /// [`SceneError`] for a quantity without sense, or a key that is missing or unknown.
    pub fn read(text: &str) -> Result<Self, SceneError> {
        let mut projectile: Self = toml::from_str(&si_text(text)?)
            .map_err(|error| SceneError::value("", error.message(), "the keys of a projectile"))?;
        if let BodyShape::Chisel(chisel) = &mut projectile.shape {
            chisel.build();
        }
        if let (Some(expansion), BodyShape::Bullet(bullet)) = (&mut projectile.expansion, &projectile.shape) {
            expansion.set_path(bullet.radius);
        }
        Ok(projectile)
    }

    /// Values of the body: mass, shape, and the inertia and the expansion if the library has them.
    #[must_use]
    pub fn values(&self) -> Vec<LibraryValue> {
        let text = library().find(|(known, _)| *known == self.name).map_or("", |(_, text)| text);
        let text = si_text(text).unwrap_or_default();
        let before_sources = text.lines().take_while(|line| !line.starts_with("[source]"));
        let values = before_sources.filter_map(|line| {
            let (key, value) = line.split_once(" = ")?;
            let source = self.source_of(key).unwrap_or_default().to_owned();
            Some(LibraryValue { key: key.to_owned(), value: value.to_owned(), source })
        });
        values.filter(|value| ["mass", "shape", "inertia", "expansion"].contains(&value.quantity())).collect()
    }

    /// Values of a body that are those of this projectile.
    #[must_use]
    pub fn values_of(&self, body: &ProjectileSpec) -> Vec<LibraryValue> {
        let own = self.differences(body);
        let is_own = |value: &LibraryValue| own.iter().any(|differing| differing.key == value.quantity());
        let is_absent = |value: &LibraryValue| value.key == "mass" && body.mass.is_none();
        self.values().into_iter().filter(|value| !is_own(value) && !is_absent(value)).collect()
    }

    /// Values of a body that differ from those of this projectile.
    #[must_use]
    pub fn differences(&self, body: &ProjectileSpec) -> Vec<DifferingValue> {
        let mass = body.mass.filter(|mass| *mass != self.mass);
        let mass = mass.map(|mass| ("mass", [format!("{mass:?}"), format!("{:?}", self.mass)]));
        let shape = (body.shape != self.shape).then(|| ("shape", [toml_text(&body.shape), toml_text(&self.shape)]));
        let inertia = body.inertia.zip(self.inertia).filter(|(own, known)| own != known);
        let inertia = inertia.map(|(own, known)| ("inertia", [format!("{own:?}"), format!("{known:?}")]));
        // The opening at the start is a state of the body, not one of its values.
        let unopened = |expansion: ExpansionSpec| ExpansionSpec { opening: 0.0, ..expansion };
        let known = || self.expansion.as_ref().map_or_else(|| "none".to_owned(), toml_text);
        let own = body.expansion.map(unopened).filter(|own| Some(*own) != self.expansion);
        let expansion = own.map(|own| ("expansion", [toml_text(&own), known()]));
        [mass, shape, inertia, expansion]
            .into_iter()
            .flatten()
            .map(|(key, values)| DifferingValue { key, values })
            .collect()
    }

    /// Source of the value of a key: that of the key, or of the longest beginning of it.
    #[must_use]
    pub fn source_of(&self, key: &str) -> Option<&str> {
        let covers = |known: &&String| {
            key.strip_prefix(known.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let known = self.source.keys().filter(covers).max_by_key(|known| known.len())?;
        self.source.get(known).map(String::as_str)
    }
}

/// Value of a body as TOML in one line.
fn toml_text(value: &impl Serialize) -> String {
    toml::Value::try_from(value).map_or_else(|error| error.to_string(), |value| value.to_string())
}

#[cfg(test)]
mod tests {
    use super::{LIBRARY_VERSION, LibraryProjectile, LibraryValue, ProjectileKind, library};
    use crate::scene::{builtin, read};
    use toml::{Table, Value};

    fn numbers(prefix: &str, table: &Table, into: &mut Vec<String>) {
        for (name, value) in table {
            let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
            match value {
                Value::Table(inner) => numbers(&key, inner, into),
                Value::Float(_) | Value::Integer(_) | Value::Array(_) => into.push(key),
                _ => (),
            }
        }
    }

    #[test]
    fn every_number_of_the_library_has_a_source_or_is_marked_as_estimated() {
        for (name, text) in library() {
            let projectile = LibraryProjectile::read(text).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(projectile.name, name);
            let mut keys = vec![];
            let mut values = Table::try_from(&projectile).unwrap();
            values.remove("source");
            numbers("", &values, &mut keys);
            // A shape without a rounding is written with an edge radius of 0.
            for key in keys.iter().filter(|key| !key.ends_with("edge_radius") || text.contains("edge_radius")) {
                let source = projectile.source_of(key).unwrap_or_else(|| panic!("{name}: no source of {key}"));
                assert!(source.starts_with('[') || source.starts_with("estimated:"), "{name}: {key}: {source}");
            }
        }
    }

    #[test]
    fn the_mass_of_a_service_or_test_projectile_is_that_of_metal_of_its_outline() {
        for (name, text) in library() {
            let projectile = LibraryProjectile::read(text).unwrap();
            let shape =
                toml::to_string(&Table::from_iter([("shape".to_owned(), Value::try_from(&projectile.shape).unwrap())]));
            let scene = format!(
                "[scene]\nname = \"x\"\ndimension = \"spatial\"\nend_time = 1e-3\ncommunication_step = 1e-4\n\
                 [gel]\nshape.block.size = [0.1, 0.1, 0.1]\npreset = \"gelatin-10\"\n[mesh]\nsize = 0.001\n\
                 [projectile]\nmass = {:?}\nposition = [0.0, 0.0, 0.05]\n{}",
                projectile.mass,
                shape.unwrap().replace("[shape", "[projectile.shape")
            );
            let scene = read(&scene).unwrap_or_else(|error| panic!("{name}: {error}\n{scene}"));
            let density = projectile.mass / scene.volume(0).unwrap();
            if projectile.kind != ProjectileKind::Recovered {
                assert!((7600.0..11_400.0).contains(&density), "{name}: {density} kg/m3");
            }
        }
    }

    #[test]
    fn a_changed_value_of_the_library_needs_another_version() {
        let values = library().flat_map(|(name, _)| {
            let values = LibraryProjectile::named(name).unwrap().values();
            values.into_iter().map(move |LibraryValue { key, value, .. }| format!("{name} {key} = {value}\n"))
        });
        let digest = xxhash_rust::xxh3::xxh3_64(values.collect::<String>().as_bytes());
        // A further projectile needs the new digest alone; a changed value also a LIBRARY_VERSION one higher, and that
        // as `since` in the file of the projectile.
        assert_eq!((LIBRARY_VERSION, digest), (1, 12_146_791_986_964_177_948));
        assert!(library().all(|(name, _)| LibraryProjectile::named(name).unwrap().since <= LIBRARY_VERSION));
    }

    #[test]
    fn the_bb_of_the_library_is_that_of_the_calibration_shot() {
        let (bb, scene) = (LibraryProjectile::named("bb").unwrap(), read(builtin("fbi-bb").unwrap()).unwrap());
        assert_eq!((bb.shape, Some(bb.mass)), (scene.projectile.shape, scene.projectile.mass));
        assert_eq!(bb.speed, -scene.projectile.velocity[2]);
    }
}
