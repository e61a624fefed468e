//! Files that a scene names, under their names in the archive.

use crate::failure::RunError;
use crate::source::SceneSource;
use ballistic_gel::fmi2::ArchiveManifest;
use ballistic_gel::output;
use ballistic_gel::scene::{self, Override};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Scene text and the files that it names, for one folder.
pub struct SceneResources {
    /// Scene text with the names below, and with the bodies that the library gives written out.
    pub text: String,
    /// Bytes of each file by its name relative to the folder.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// Reads the files that a scene names, and gives them names inside the folder of the scene.
///
/// A name that leads down from the folder keeps its folders, with `/` between them. Another name becomes its last part,
/// in the text too. No name has a character that a system forbids, and no two differ by case alone.
pub fn collect(source: &SceneSource) -> Result<SceneResources, RunError> {
    let read = output::scene_file_reader(&source.folder);
    let (mut packed, mut changes) = (BTreeMap::new(), vec![]);
    for (key, name) in source.scene.files() {
        let bytes = read(name).map_err(|source| RunError::File { verb: "pack", path: PathBuf::from(name), source })?;
        let inner = free_name(&inner_name(name), &bytes, &packed);
        if inner != name {
            changes.push(Override { key, value: toml_text(&inner) });
        }
        packed.insert(inner, bytes);
    }
    let text = if changes.is_empty() { source.text.clone() } else { scene::written(&source.text, &changes)? };
    Ok(SceneResources { text: scene::fill_bodies(&text)?, files: packed })
}

/// Returns the name with `/` between its folders if it leads down, else its last part; a character that a system
/// forbids becomes `_`.
fn inner_name(name: &str) -> String {
    let name = name.replace('\\', "/");
    let (is_of_drive, path) = match name.split_at_checked(2) {
        Some((drive, path)) if drive.ends_with(':') && drive.starts_with(|c: char| c.is_ascii_alphabetic()) => {
            (true, path)
        }
        _ => (false, name.as_str()),
    };
    let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty() && *part != ".").collect();
    let leads_out = is_of_drive || path.starts_with('/') || parts.contains(&"..");
    let kept = if leads_out { &parts[parts.len().saturating_sub(1)..] } else { &parts[..] };
    let kept: Vec<String> = kept.iter().filter(|part| **part != "..").map(|part| portable(part)).collect();
    if kept.is_empty() { "file".to_owned() } else { kept.join("/") }
}

/// Makes a part of a path valid on every system: Windows forbids some characters, and a dot or a space at the end.
fn portable(part: &str) -> String {
    let is_forbidden = |c: char| c.is_control() || "<>:\"|?*".contains(c);
    let part = part.replace(is_forbidden, "_");
    let stem = part.trim_end_matches(['.', ' ']);
    stem.to_owned() + &"_".repeat(part.len() - stem.len())
}

/// Returns the name, or the first name with a number before it, that clashes with no other file, also on systems that
/// ignore case.
fn free_name(name: &str, bytes: &[u8], taken: &BTreeMap<String, Vec<u8>>) -> String {
    let same =
        |(other, content): (&String, &Vec<u8>)| is_same_name(other, name).then(|| (other.clone(), content == bytes));
    if let Some((known, true)) = taken.iter().find_map(same) {
        return known;
    }
    let reserved = || ["scene.toml", ArchiveManifest::FILE].into_iter();
    let all = || reserved().chain(taken.keys().map(String::as_str));
    let (folder, last) = name.rsplit_once('/').map_or(("", name), |(folder, last)| (folder, last));
    // A folder with the name of another file cannot exist.
    let has_place = all().all(|other| !is_same_name(other, folder) && !is_below(folder, other));
    let folder = if has_place && !folder.is_empty() { format!("{folder}/") } else { String::new() };
    let names = std::iter::once(format!("{folder}{last}")).chain((2..).map(|n| format!("{folder}{n}-{last}")));
    let is_free = |name: &String| all().all(|other| !is_same_name(other, name) && !is_below(other, name));
    names.into_iter().find(is_free).unwrap_or_else(|| name.to_owned())
}

fn is_same_name(a: &str, b: &str) -> bool {
    a.to_lowercase() == b.to_lowercase()
}

/// Returns true if a path is inside a folder.
fn is_below(path: &str, folder: &str) -> bool {
    path.to_lowercase().starts_with(&format!("{}/", folder.to_lowercase()))
}

/// Quotes a text for TOML.
fn toml_text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_lead_out_of_the_folder_lose_the_way() {
        for (name, inner) in [
            ("a.stl", "a.stl"),
            ("b/a.stl", "b/a.stl"),
            ("./b//a.stl", "b/a.stl"),
            ("../b/a.stl", "a.stl"),
            ("b/../a.stl", "a.stl"),
            ("/c/a.stl", "a.stl"),
            ("..", "file"),
        ] {
            assert_eq!(inner_name(name), inner);
        }
    }

    #[test]
    fn windows_paths_become_names_that_every_system_takes() {
        for (name, inner) in [
            ("b\\a.stl", "b/a.stl"),
            ("..\\b\\a.stl", "a.stl"),
            ("C:\\bodies\\a.stl", "a.stl"),
            ("c:a.stl", "a.stl"),
            ("\\\\server\\share\\a.stl", "a.stl"),
            ("a?:1.stl", "a__1.stl"),
            ("b./a.stl ", "b_/a.stl_"),
        ] {
            assert_eq!(inner_name(name), inner);
        }
    }

    #[test]
    fn two_files_do_not_share_a_name_unless_they_are_the_same() {
        let taken = BTreeMap::from([("a.stl".to_owned(), vec![1]), ("b/a.stl".to_owned(), vec![1])]);
        for (name, byte, expected) in [
            ("a.stl", 1, "a.stl"),
            ("A.STL", 1, "a.stl"),
            ("a.stl", 2, "2-a.stl"),
            ("A.STL", 2, "2-A.STL"),
            ("b/a.stl", 2, "b/2-a.stl"),
            ("B", 2, "2-B"),
            ("A.stl/c.stl", 2, "c.stl"),
            ("A.stl/d/a.stl", 2, "2-a.stl"),
        ] {
            assert_eq!(free_name(name, &[byte], &taken), expected, "{name}");
        }
    }

    #[test]
    fn no_file_takes_the_name_of_the_scene_or_of_the_manifest() {
        for (name, expected) in [
            ("scene.toml", "2-scene.toml"),
            ("SCENE.TOML", "2-SCENE.TOML"),
            ("Manifest.json", "2-Manifest.json"),
            ("Scene.toml/a.stl", "a.stl"),
            ("b/scene.toml", "b/scene.toml"),
        ] {
            assert_eq!(free_name(name, &[1], &BTreeMap::new()), expected);
        }
    }

    #[test]
    fn the_scene_of_a_folder_or_an_archive_holds_the_body_of_the_library() {
        let text = "[projectile]\nlibrary = \"bb\"\nposition = [0, 0, 0]\n".to_owned();
        let scene = scene::read(scene::builtin("fbi-bb").unwrap()).unwrap();
        let source = SceneSource { text, folder: PathBuf::new(), scene };
        let kept: toml::Table = collect(&source).unwrap().text.parse().unwrap();
        assert_eq!(kept["projectile"]["mass"].as_float(), Some(0.343e-3));
        assert_eq!(kept["projectile"]["shape"]["sphere"]["radius"].as_float(), Some(2.185e-3));
    }

    #[test]
    fn quoted_names_are_toml() {
        let name = "a \"b\" \\ é\u{1}.stl";
        let read: toml::Table = format!("x = {}", toml_text(name)).parse().unwrap();
        assert_eq!(read["x"].as_str(), Some(name));
    }
}
