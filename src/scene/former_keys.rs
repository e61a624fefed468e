//! Former names of keys, accepted until the next release.

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

impl RenamedKey {
    fn is_named(&self, key: &str) -> bool {
        let name = key.strip_prefix(self.table).and_then(|rest| rest.strip_prefix('.'));
        name.is_some_and(|name| name == self.former || name == self.present)
    }
}

/// Gives the keys of a scene their present names. A table with both names keeps both, and the former one is unknown
/// then.
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

/// Returns a note for each former name in a scene text; none for a text that is not TOML.
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
    RENAMED.iter().filter(uses).map(note).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Override, builtin, read, resolve};
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
    fn an_error_of_a_former_key_has_its_line_and_its_present_name() {
        let text = builtin("fbi-bb").expect("it is built in");
        let old = former(text).replace("bend = 180.0", "bend = 181.0");
        let error = read(&old).expect_err("181 degrees are too many");
        let line = 1 + old.lines().position(|line| line.starts_with("bend")).expect("it is set");
        assert_eq!((error.key.as_str(), error.line), ("remesh.curvature_angle", Some(line)));
    }
}
