//! The files that a scene names, as they go into the archive.

use crate::job::RunError;
use ballistic_gel::scene::{self, Files, Override, Scene};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// The scene text, and name and bytes of each file for the folder of the scene.
///
/// A name that leads down from the folder of the scene stays as it is; another becomes the last part of it, in the text too.
pub fn of((text, scene): (&str, &Scene), files: &Files<'_>) -> Result<(String, BTreeMap<String, Vec<u8>>), RunError> {
    let (mut carried, mut changes) = (BTreeMap::from([("scene.toml".to_owned(), vec![])]), vec![]);
    for (key, name) in scene.files() {
        let bytes = files(name).map_err(|source| RunError::File { verb: "pack", path: PathBuf::from(name), source })?;
        let inner = free(&inner_name(name), &bytes, &carried);
        if inner != name {
            changes.push(Override { key, value: toml_text(&inner) });
        }
        carried.insert(inner, bytes);
    }
    carried.remove("scene.toml");
    let text = if changes.is_empty() { text.to_owned() } else { scene::written(text, &changes)? };
    Ok((text, carried))
}

/// The name if it leads down, else its last part.
fn inner_name(name: &str) -> String {
    let path = Path::new(name);
    if path.components().all(|part| matches!(part, Component::Normal(_))) {
        return name.to_owned();
    }
    path.file_name().map_or_else(|| "file".to_owned(), |last| last.to_string_lossy().into_owned())
}

/// The name, or the first with a number before it that no other file has.
fn free(name: &str, bytes: &[u8], taken: &BTreeMap<String, Vec<u8>>) -> String {
    let is_free = |name: &String| taken.get(name).is_none_or(|other| other == bytes);
    let numbered = (2..).map(|n| match name.rsplit_once('/') {
        Some((folder, last)) => format!("{folder}/{n}-{last}"),
        None => format!("{n}-{name}"),
    });
    std::iter::once(name.to_owned()).chain(numbered).find(is_free).unwrap_or_else(|| name.to_owned())
}

/// A text in quotes, as TOML writes it.
fn toml_text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_out_of_the_folder_lose_the_way() {
        for (name, inner) in
            [("a.stl", "a.stl"), ("b/a.stl", "b/a.stl"), ("../b/a.stl", "a.stl"), ("/c/a.stl", "a.stl")]
        {
            assert_eq!(inner_name(name), inner);
        }
    }

    #[test]
    fn two_files_do_not_share_a_name_unless_they_are_the_same() {
        let taken = BTreeMap::from([("a.stl".to_owned(), vec![1]), ("b/a.stl".to_owned(), vec![1])]);
        assert_eq!(free("a.stl", &[1], &taken), "a.stl");
        assert_eq!(free("a.stl", &[2], &taken), "2-a.stl");
        assert_eq!(free("b/a.stl", &[2], &taken), "b/2-a.stl");
    }

    #[test]
    fn quoted_names_are_toml() {
        let name = "a \"b\" \\ é\u{1}.stl";
        let read: toml::Table = format!("x = {}", toml_text(name)).parse().unwrap();
        assert_eq!(read["x"].as_str(), Some(name));
    }
}
