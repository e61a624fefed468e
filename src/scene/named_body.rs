//! Bodies of a scene text that name a projectile of the library, and the values that it gives them.

use super::{
    LIBRARY_VERSION, LibraryProjectile, LibraryValue, SceneError, body_name, did_you_mean, known_projectiles, library,
};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Key of the version of the library in the table of a body.
const VERSION: &str = "library_version";

/// Body of a scene text that names a projectile of the library.
pub(super) struct NamedBody {
    /// Index of the body; 0 is the projectile.
    pub body: usize,
    /// Projectile of the library.
    pub projectile: LibraryProjectile,
    /// Place of the name in the text.
    pub place: Range<usize>,
    /// Version of the library that the scene states.
    version: Option<u32>,
    /// True for a body that is held in place.
    is_fixed: bool,
    /// Keys that the text sets.
    keys: Vec<String>,
}

/// Bodies of a scene that name a projectile of the library.
///
/// # Errors
/// [`SceneError`] for a name that the library does not have.
pub(super) fn named_bodies(scene: &DeTable<'_>) -> Result<Vec<NamedBody>, SceneError> {
    let fragments = scene.get("fragment").and_then(|list| list.get_ref().as_array());
    let fragments = fragments.into_iter().flatten().zip(1..).map(|(fragment, body)| (body, fragment.get_ref()));
    let bodies = scene.get("projectile").map(|projectile| (0, projectile.get_ref())).into_iter().chain(fragments);
    bodies.filter_map(|(body, table)| named_body(body, table.as_table()?).transpose()).collect()
}

fn named_body(body: usize, table: &DeTable<'_>) -> Result<Option<NamedBody>, SceneError> {
    let value = |key: &str| table.get(key).map(Spanned::get_ref);
    let Some(name) = value("library").and_then(DeValue::as_str) else { return Ok(None) };
    let projectile = LibraryProjectile::named(name).ok_or_else(|| {
        let names = || library().map(|(known, _)| known);
        let expected = format!("a projectile of the library: {}", names().collect::<Vec<_>>().join(", "));
        let found = format!("{name:?}{}", did_you_mean(name, known_projectiles()));
        SceneError::value(&format!("{}.library", body_name(body)), found, expected)
    })?;
    Ok(Some(NamedBody {
        body,
        projectile,
        place: table.get("library").map_or(0..0, Spanned::span),
        version: value(VERSION).and_then(DeValue::as_integer).and_then(|number| number.as_str().parse().ok()),
        is_fixed: value("fixed").and_then(DeValue::as_bool).unwrap_or(false),
        keys: table.keys().map(|key| key.get_ref().to_string()).collect(),
    }))
}

impl NamedBody {
    /// Dotted key of the table of the body.
    pub(super) fn key(&self) -> String {
        body_name(self.body)
    }

    /// Quantities that the name stands for, and the density, which would give another mass.
    pub(super) fn quantities(&self) -> Vec<String> {
        let given = self.projectile.values().into_iter().map(|value| value.quantity().to_owned());
        given.chain(["density".to_owned()]).collect()
    }

    /// Returns true if the text sets a value of the body itself.
    pub(super) fn has_own_values(&self) -> bool {
        self.quantities().iter().any(|key| self.sets(key))
    }

    fn sets(&self, key: &str) -> bool {
        self.keys.iter().any(|own| own == key)
    }

    /// Values of the library that the text does not set, and its version if the text states none.
    ///
    /// # Errors
    /// [`SceneError`] if the text states a version of the library in which the projectile had other values.
    pub(super) fn missing_values(&self) -> Result<Vec<LibraryValue>, SceneError> {
        let is_free = |value: &LibraryValue| {
            let quantity = value.quantity();
            let is_needless = self.is_fixed && quantity != "shape";
            !self.sets(quantity) && !is_needless
        };
        let mut missing: Vec<LibraryValue> = self.projectile.values().into_iter().filter(is_free).collect();
        let LibraryProjectile { name, since, .. } = &self.projectile;
        if let Some(version) = self.version.filter(|version| version < since && !missing.is_empty()) {
            let expected = format!(
                "{LIBRARY_VERSION}, or the values of that version beside the name, as the scene.toml of a run has them: \
                 {name} has others since version {since}"
            );
            return Err(SceneError::value(&format!("{}.{VERSION}", self.key()), version.to_string(), expected));
        }
        if !self.sets(VERSION) {
            let (key, value) = (VERSION.to_owned(), LIBRARY_VERSION.to_string());
            missing.push(LibraryValue { key, value, source: String::new() });
        }
        Ok(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bodies of a scene, of a library in which each has changed in version 3.
    fn missing(text: &str) -> Result<Vec<LibraryValue>, SceneError> {
        let table = DeTable::parse(text).unwrap();
        let mut named = named_bodies(table.get_ref())?.remove(0);
        named.projectile.since = 3;
        named.missing_values()
    }

    #[test]
    fn the_name_alone_is_refused_where_the_body_has_changed_since_the_stated_version() {
        let scene = |more: &str| format!("[projectile]\nlibrary = \"bb\"\n{more}");
        let keys: Vec<String> = missing(&scene("")).unwrap().into_iter().map(|value| value.key).collect();
        assert_eq!(keys, ["mass", "shape.sphere.radius", "library_version"]);
        assert_eq!(missing(&scene("library_version = 3")).unwrap().len(), 2);
        let refused = missing(&scene("library_version = 2")).unwrap_err();
        assert_eq!(refused.key, "projectile.library_version");
        assert!(refused.kind.expected().ends_with("bb has others since version 3"), "{refused}");
        let values = "library_version = 2\nmass = 0.34e-3\nshape.sphere.radius = 2.2e-3";
        assert_eq!(missing(&scene(values)).unwrap(), [], "values of the earlier version are kept");
    }
}
