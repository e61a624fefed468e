//! `resources/manifest.json`: identity of a packed archive, and the check of its resources.
//!
//! The GUID is XXH3-128 over four entries: the version, the hash of the model description with an empty GUID, the
//! hashes of the libraries, and name and hash of every other file in `resources/`. Importers cache unpacked archives by
//! GUID and therefore never confuse two archives. The library never reads `modelDescription.xml`, because importers
//! may rewrite it.

use crate::output::{MOST_FILE_BYTES, read_limited};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};
use xxhash_rust::xxh3::xxh3_128;

/// Version of the release, in the manifest that it packs and of the library that reads it.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Stamp of the sources, in the library and in the command: `gelfmu pack` recognises by it a library of other sources.
#[doc(hidden)]
pub const SOURCE_STAMP: &str = concat!("ballistic-gel of the sources ", env!("BALLISTIC_GEL_SOURCES"));
/// Remedy for every changed archive.
const REMEDY: &str = "pack the scene anew with gelfmu pack instead of editing the unpacked archive";

/// Manifest of an archive. The manifest does not list itself.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ArchiveManifest {
    /// Version of the release that packed the archive.
    version: String,
    /// GUID of the archive.
    guid: String,
    /// Hash of `modelDescription.xml` with an empty GUID.
    description: String,
    /// Path below `binaries/` and hash of each packed library.
    libraries: BTreeMap<String, String>,
    /// Name below `resources/`, with `/` between folders, and hash of every other file.
    files: BTreeMap<String, String>,
}

/// Content of an archive that determines its GUID.
#[derive(Debug, Clone, Copy)]
pub struct ArchiveContent<'a> {
    /// Text of `modelDescription.xml` with an empty GUID.
    pub description: &'a str,
    /// Path below `binaries/` and bytes of each library.
    pub libraries: &'a BTreeMap<String, Vec<u8>>,
    /// Name below `resources/` and bytes of every file but the manifest.
    pub resources: &'a BTreeMap<String, Vec<u8>>,
}

/// Error of a changed or incomplete archive.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ManifestError {
    /// Missing folder of resources.
    #[error("fmuResourceLocation: found {found}, expected the URI of the folder resources of the unpacked archive")]
    Location {
        /// Fault of the argument.
        found: String,
    },
    /// Unreadable file.
    #[error("{path}: found no readable file ({reason}), expected that of the archive; {REMEDY}")]
    Unreadable {
        /// Path of the file.
        path: String,
        /// Error of the system.
        reason: String,
    },
    /// Invalid manifest.
    #[error("{path}: found {reason}, expected the manifest that gelfmu pack wrote; {REMEDY}")]
    Undecodable {
        /// Path of the manifest.
        path: String,
        /// Fault of the text.
        reason: String,
    },
    /// Resources of another release.
    #[error(
        "{path}: found version {found}, expected {VERSION}, that of the library in the archive, {SOURCE_STAMP}; {REMEDY}"
    )]
    Release {
        /// Path of the manifest.
        path: String,
        /// Version in the manifest.
        found: String,
    },
    /// Mismatched GUID.
    #[error(
        "fmuGUID = {found}: expected {expected} as in {path}: model description and resources are of different archives; {REMEDY}"
    )]
    Guid {
        /// Path of the manifest.
        path: String,
        /// Given GUID.
        found: String,
        /// GUID in the manifest.
        expected: String,
    },
    /// Changed file.
    #[error("{path}: found content of hash {found}, expected {expected} as packed: the file was changed; {REMEDY}")]
    Changed {
        /// Path of the file.
        path: String,
        /// Hash of the content.
        found: String,
        /// Hash in the manifest.
        expected: String,
    },
    /// Unpacked extra file.
    #[error("{path}: found no entry for it in manifest.json, expected a file that was packed with the scene; {REMEDY}")]
    Unlisted {
        /// Path of the file.
        path: String,
    },
}

impl ArchiveManifest {
    /// Name of the manifest in `resources/`.
    pub const FILE: &'static str = "manifest.json";

    /// Creates the manifest of an archive.
    #[must_use]
    pub fn of(content: &ArchiveContent<'_>) -> Self {
        let hashes =
            |files: &BTreeMap<String, Vec<u8>>| files.iter().map(|(name, bytes)| (name.clone(), hash(bytes))).collect();
        let manifest = Self {
            version: VERSION.to_owned(),
            guid: String::new(),
            description: hash(content.description.as_bytes()),
            libraries: hashes(content.libraries),
            files: hashes(content.resources),
        };
        Self { guid: manifest.computed_guid(), ..manifest }
    }

    /// Returns the GUID of the archive.
    #[must_use]
    pub fn guid(&self) -> &str {
        &self.guid
    }

    /// Writes the manifest as JSON.
    ///
    /// # Panics
    /// Never: texts and a map of texts can be written as JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("texts can be written as JSON") + "\n"
    }

    /// Reads the manifest in a folder of resources, and verifies the GUID and every listed file.
    pub(super) fn verified(folder: &Path, guid: &str) -> Result<Self, ManifestError> {
        let file = folder.join(Self::FILE);
        let bytes = read_file(&file)?;
        let path = file.display().to_string();
        let undecodable = |reason: String| ManifestError::Undecodable { path: path.clone(), reason };
        let manifest: Self = serde_json::from_slice(&bytes).map_err(|e| undecodable(format!("no manifest: {e}")))?;
        if manifest.version != VERSION {
            return Err(ManifestError::Release { path, found: manifest.version });
        }
        if manifest.guid != manifest.computed_guid() {
            return Err(undecodable("entries that do not give its GUID".to_owned()));
        }
        if manifest.guid != guid {
            return Err(ManifestError::Guid { path, found: guid.to_owned(), expected: manifest.guid });
        }
        manifest.files.keys().try_for_each(|name| manifest.read(folder, name).map(drop))?;
        Ok(manifest)
    }

    /// Reads a listed file in a folder of resources, if unchanged.
    pub(super) fn read(&self, folder: &Path, name: &str) -> Result<Vec<u8>, ManifestError> {
        let file: PathBuf = folder.join(name);
        let path = file.display().to_string();
        let is_inside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        let Some(expected) = self.files.get(name).filter(|_| is_inside) else {
            return Err(ManifestError::Unlisted { path });
        };
        let bytes = read_file(&file)?;
        let found = hash(&bytes);
        if found == *expected {
            return Ok(bytes);
        }
        Err(ManifestError::Changed { path, found, expected: expected.clone() })
    }

    /// Computes the GUID from the entries.
    fn computed_guid(&self) -> String {
        let entries = (&self.version, &self.description, &self.libraries, &self.files);
        let hex = hash(&serde_json::to_vec(&entries).expect("texts can be written as JSON"));
        format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
    }
}

/// Returns the XXH3-128 hash of bytes in 32 hexadecimal digits.
fn hash(bytes: &[u8]) -> String {
    format!("{:032x}", xxh3_128(bytes))
}

fn read_file(file: &Path) -> Result<Vec<u8>, ManifestError> {
    let unreadable =
        |e: io::Error| ManifestError::Unreadable { path: file.display().to_string(), reason: e.to_string() };
    read_limited(file, MOST_FILE_BYTES).map_err(unreadable)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn resources() -> BTreeMap<String, Vec<u8>> {
        BTreeMap::from([("b/ball.stl".to_owned(), vec![1, 2, 3]), ("scene.toml".to_owned(), b"[scene]".to_vec())])
    }

    fn guid_of(description: &str, library: &[u8], resources: &BTreeMap<String, Vec<u8>>) -> String {
        let libraries = &BTreeMap::from([("linux64/BallisticGel.so".to_owned(), library.to_vec())]);
        ArchiveManifest::of(&ArchiveContent { description, libraries, resources }).guid
    }

    #[test]
    fn the_guid_depends_on_every_part_of_the_archive_and_on_nothing_else() {
        let (own, mut edited, mut renamed) = (resources(), resources(), resources());
        edited.insert("scene.toml".to_owned(), b"[scene] ".to_vec());
        let moved = renamed.remove("b/ball.stl").unwrap();
        renamed.insert("ball.stl".to_owned(), moved);
        let guid = guid_of("<a/>", b"\x7fELF", &own);
        assert_eq!(guid, guid_of("<a/>", b"\x7fELF", &own));
        let others = [
            guid_of("<b/>", b"\x7fELF", &own),
            guid_of("<a/>", b"MZ", &own),
            guid_of("<a/>", b"\x7fELF", &edited),
            guid_of("<a/>", b"\x7fELF", &renamed),
        ];
        assert!(others.iter().all(|other| *other != guid), "{guid} {others:?}");
        assert_eq!(guid.len(), 38);
    }

    fn written() -> (tempfile::TempDir, ArchiveManifest) {
        let (folder, resources) = (tempfile::tempdir().unwrap(), resources());
        let (libraries, resources) = (&BTreeMap::new(), &resources);
        let manifest = ArchiveManifest::of(&ArchiveContent { description: "", libraries, resources });
        fs::create_dir(folder.path().join("b")).unwrap();
        for (name, bytes) in resources {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        fs::write(folder.path().join(ArchiveManifest::FILE), manifest.to_json()).unwrap();
        (folder, manifest)
    }

    #[test]
    fn an_archive_as_packed_is_taken_and_files_that_a_tool_adds_are_ignored() {
        let (folder, manifest) = written();
        fs::write(folder.path().join("container.txt"), "added").unwrap();
        assert_eq!(ArchiveManifest::verified(folder.path(), &manifest.guid), Ok(manifest.clone()));
        assert_eq!(manifest.read(folder.path(), "b/ball.stl"), Ok(vec![1, 2, 3]));
        for name in ["container.txt", "manifest.json", "../scene.toml", "/etc/passwd"] {
            assert!(matches!(manifest.read(folder.path(), name), Err(ManifestError::Unlisted { .. })), "{name}");
        }
    }

    #[test]
    fn every_changed_or_missing_file_is_refused_by_name_and_with_the_remedy() {
        type Edit = fn(&Path, &ArchiveManifest);
        let edits: [(&str, Edit); 6] = [
            ("scene.toml: found content", |at, _| fs::write(at.join("scene.toml"), "[scene]\n").unwrap()),
            ("ball.stl: found no readable file", |at, _| fs::remove_file(at.join("b/ball.stl")).unwrap()),
            ("manifest.json: found no readable file", |at, _| fs::remove_file(at.join(ArchiveManifest::FILE)).unwrap()),
            ("manifest.json: found no manifest", |at, _| fs::write(at.join(ArchiveManifest::FILE), "{").unwrap()),
            ("manifest.json: found version 0.0.0", |at, m| {
                let text = m.to_json().replace(env!("CARGO_PKG_VERSION"), "0.0.0");
                fs::write(at.join(ArchiveManifest::FILE), text).unwrap();
            }),
            ("manifest.json: found entries", |at, m| {
                let text = m.to_json().replace(&hash(b"[scene]"), &hash(b"[scene]\n"));
                fs::write(at.join(ArchiveManifest::FILE), text).unwrap();
                fs::write(at.join("scene.toml"), "[scene]\n").unwrap();
            }),
        ];
        for (said, edit) in edits {
            let (folder, manifest) = written();
            edit(folder.path(), &manifest);
            let refused = ArchiveManifest::verified(folder.path(), &manifest.guid).unwrap_err().to_string();
            assert!(refused.contains(said) && refused.ends_with(REMEDY), "{said}: {refused}");
        }
        let (folder, _) = written();
        let refused = ArchiveManifest::verified(folder.path(), "{0}").unwrap_err().to_string();
        assert!(refused.starts_with("fmuGUID = {0}: expected {"), "{refused}");
    }
}
