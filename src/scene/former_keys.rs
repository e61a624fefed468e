//! Former names of keys and values, accepted until the next release, and keys that no scene has any more.

use super::SceneError;
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use toml_edit::DocumentMut;

/// Key of a table with its former name.
struct RenamedKey {
    table: &'static str,
    former: &'static str,
    present: &'static str,
}

const RENAMED: [RenamedKey; 4] = [
    RenamedKey { table: "remesh", former: "bend", present: "curvature_angle" },
    RenamedKey { table: "remesh", former: "compression", present: "min_volume_ratio" },
    RenamedKey { table: "remesh", former: "thinnest", present: "erosion_thickness" },
    RenamedKey { table: "remesh", former: "tip", present: "tip_size" },
];

/// Value of a key of a table with its former name.
struct RenamedValue {
    table: &'static str,
    key: &'static str,
    former: &'static str,
    present: &'static str,
}

const RENAMED_VALUES: [RenamedValue; 1] =
    [RenamedValue { table: "gel", key: "material", former: "viscoelastic", present: "two-network" }];

/// Key of a table, or one value of it, that a scene may not have any more.
struct RemovedKey {
    table: &'static str,
    key: &'static str,
    /// Removed value; `None` if the key itself is removed.
    value: Option<&'static str>,
    /// Keys that take its place.
    remedy: &'static str,
}

const REMOVED: [RemovedKey; 3] = [
    RemovedKey {
        table: "gel",
        key: "material",
        value: Some("flowing"),
        remedy: "\"two-network\", with gel.shear_modulus, gel.damage = { critical_stretch, delay } and gel.branches = \
                 [{ shear_modulus, power_law = { stress, exponent } }]: gel.strength, its confined and gel.softening \
                 are gone",
    },
    RemovedKey {
        table: "gel",
        key: "strength",
        value: None,
        remedy: "nothing: the stress that depends on the rate is that of gel.branches = [{ shear_modulus, power_law = \
                 { stress, exponent } }], which gel.strength_scale scales with the moduli",
    },
    RemovedKey {
        table: "gel",
        key: "softening",
        value: None,
        remedy: "nothing: a \"two-network\" gel softens by gel.damage = { critical_stretch, delay }",
    },
];

impl RemovedKey {
    /// Returns the text of the removed key in a scene, if it has the key with the removed value.
    fn found_in(&self, scene: &DeTable<'_>) -> Option<String> {
        let value = scene.get(self.table)?.get_ref().as_table()?.get(self.key)?.get_ref();
        match self.value {
            Some(removed) => (value.as_str() == Some(removed)).then(|| format!("{removed:?}")),
            None => Some(if value.is_table() { "a table" } else { "a value" }.to_owned()),
        }
    }
}

/// Refuses keys and values that a scene may not have any more, with those that take their place.
///
/// # Errors
/// [`SceneError`] of the first one, without a line.
pub(super) fn refuse_removed_keys(scene: &DeTable<'_>) -> Result<(), SceneError> {
    let error = |removed: &RemovedKey| {
        let found = removed.found_in(scene)?;
        Some(SceneError::value(&format!("{}.{}", removed.table, removed.key), found, removed.remedy))
    };
    REMOVED.iter().find_map(error).map_or(Ok(()), Err)
}

impl RenamedKey {
    fn is_named(&self, key: &str) -> bool {
        let name = key.strip_prefix(self.table).and_then(|rest| rest.strip_prefix('.'));
        name.is_some_and(|name| name == self.former || name == self.present)
    }
}

/// Gives the keys and values of a scene their present names. A table with both names of a key keeps both, and the
/// former one is unknown then.
pub(super) fn rename_keys(scene: &mut DeTable<'_>) {
    for RenamedKey { table, former, present } in RENAMED {
        let Some(DeValue::Table(table)) = scene.get_mut(table).map(Spanned::get_mut) else { continue };
        if table.contains_key(present) {
            continue;
        }
        if let Some((name, value)) = table.remove_entry(former) {
            table.insert(Spanned::new(name.span(), Cow::Borrowed(present)), value);
        }
    }
    for RenamedValue { table, key, former, present } in RENAMED_VALUES {
        let Some(DeValue::Table(table)) = scene.get_mut(table).map(Spanned::get_mut) else { continue };
        let Some(value) = table.get_mut(key).map(Spanned::get_mut) else { continue };
        if value.as_str() == Some(former) {
            *value = DeValue::String(Cow::Borrowed(present));
        }
    }
}

/// Returns the present name of a dotted key.
pub(super) fn present_key(key: &str) -> Cow<'_, str> {
    let renamed = RENAMED.iter().find(|renamed| renamed.is_named(key));
    renamed.map_or(Cow::Borrowed(key), |renamed| Cow::Owned(format!("{}.{}", renamed.table, renamed.present)))
}

/// Returns the name that a document has for a dotted key: the former one where the document uses that.
pub(super) fn key_in_document<'a>(document: &DocumentMut, key: &'a str) -> Cow<'a, str> {
    let Some(renamed) = RENAMED.iter().find(|renamed| renamed.is_named(key)) else { return Cow::Borrowed(key) };
    let table = document.get(renamed.table).and_then(toml_edit::Item::as_table_like);
    let uses_former = table.is_some_and(|table| table.contains_key(renamed.former));
    Cow::Owned(format!("{}.{}", renamed.table, if uses_former { renamed.former } else { renamed.present }))
}

/// Returns a note for each former name of a key or value in a scene text; none for a text that is not TOML.
#[must_use]
pub fn former_keys(text: &str) -> Vec<String> {
    let Ok(scene) = DeTable::parse(text) else { return vec![] };
    let uses = |renamed: &&RenamedKey| {
        let table = scene.get_ref().get(renamed.table).map(Spanned::get_ref);
        matches!(table, Some(DeValue::Table(table)) if table.contains_key(renamed.former))
    };
    let note = |RenamedKey { table, former, present }: &RenamedKey| {
        format!("{table}.{former} is now {table}.{present}; the former name is accepted until the next release")
    };
    let has = |renamed: &&RenamedValue| {
        let value = scene.get_ref().get(renamed.table).and_then(|table| table.get_ref().as_table()?.get(renamed.key));
        value.is_some_and(|value| value.get_ref().as_str() == Some(renamed.former))
    };
    let value_note = |RenamedValue { table, key, former, present }: &RenamedValue| {
        format!("{table}.{key} = {former:?} is now {present:?}; the former name is accepted until the next release")
    };
    let values = RENAMED_VALUES.iter().filter(has).map(value_note);
    RENAMED.iter().filter(uses).map(note).chain(values).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Override, builtin, from_preset, read, resolve};
    use super::*;

    fn former(text: &str) -> String {
        RENAMED.iter().fold(text.to_owned(), |text, key| {
            text.replace(&format!("\n{} =", key.present), &format!("\n{} =", key.former))
        })
    }

    #[test]
    fn a_scene_with_former_keys_is_the_same_scene_with_a_note_for_each() {
        let text = builtin("bullet-yaw").expect("it is built in");
        let old = former(text);
        assert_eq!(read(&old), read(text));
        assert_eq!((former_keys(&old).len(), former_keys(text).len()), (4, 0));
        let overrides: [Override; 2] =
            ["remesh.bend=90", "remesh.tip_size=0.4e-3"].map(|text| text.parse().expect("it is an override"));
        let of = |text: &str| read(&resolve(text, &overrides).expect("both names are known"));
        assert_eq!(of(&old), of(text));
        assert_eq!(of(text).map(|scene| scene.remesh.map(|remesh| remesh.curvature_angle)), Ok(Some(90.0)));
    }

    #[test]
    fn a_scene_with_a_former_value_is_the_same_scene_with_a_note() {
        let text = builtin("bounce-visco").expect("it is built in");
        let old = text.replace("\"two-network\"", "\"viscoelastic\"");
        assert_ne!(old, text);
        assert_eq!(read(&old), read(text));
        let note = "gel.material = \"viscoelastic\" is now \"two-network\"; the former name is accepted until the \
                    next release";
        assert_eq!((former_keys(&old), former_keys(text)), (vec![note.to_owned()], vec![]));
    }

    #[test]
    fn a_preset_fills_a_gel_of_the_former_name_too() {
        let text = builtin("fbi-bb").expect("it is built in");
        let of = |name: &str| {
            let named: Override = format!("gel.material={name}").parse().expect("it is an override");
            resolve(text, &[named]).expect("it is TOML")
        };
        let [former, present] = ["viscoelastic", "two-network"].map(of);
        assert_eq!(read(&former), read(&present));
        assert_eq!(from_preset(&former), from_preset(&present));
        assert!(from_preset(&former).iter().any(|fact| fact.key == "gel.branches"));
    }

    #[test]
    fn an_error_of_a_former_key_has_its_line_and_its_present_name() {
        let text = builtin("fbi-bb").expect("it is built in");
        let old = former(text).replace("bend = 180.0", "bend = 181.0");
        let error = read(&old).expect_err("181 degrees are too many");
        let line = 1 + old.lines().position(|line| line.starts_with("bend")).expect("it is set");
        assert_eq!((error.key.as_str(), error.line), ("remesh.curvature_angle", Some(line)));
    }
}
