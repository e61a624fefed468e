//! Writes the FMU: the library of this build, the scene, and what describes them.

mod description;
mod documentation;
mod library;
mod requirement;
pub mod resources;

use crate::job::RunError;
use crate::results;
use ballistic_gel::fmi2::{self, ArchiveContent, ArchiveManifest, VariablePorts};
use ballistic_gel::output::model_picture;
use ballistic_gel::scene::{self, Scene};
use ballistic_gel::simulation::{CouplingMode, Simulation};
pub use library::{INSTALLATION, LIBRARY_PATH, PackedLibrary};
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

mod licenses {
    include!(concat!(env!("OUT_DIR"), "/licenses.rs"));
}

/// A written FMU.
#[derive(Debug)]
pub struct Packed {
    /// Size of the file.
    pub bytes: u64,
    /// FMI name of the platform its library is for.
    pub platform: String,
    /// True if its library is that of a development build.
    pub is_development: bool,
}

/// Path and bytes of each file in the archive, sorted.
type Entries = BTreeMap<String, Vec<u8>>;

/// Writes the FMU of a scene, a text and the folder of its files, with these ports, for this host.
/// The same scene gives the same bytes.
pub fn pack(scene: (&str, &Path), ports: VariablePorts, file: &Path) -> Result<Packed, RunError> {
    let library = PackedLibrary::find()?;
    let entries = entries(scene, ports, &library)?;
    let archive = archive(&entries).map_err(|e| written(file, std::io::Error::other(e)))?;
    results::replace(file, &archive)?;
    let platform = LIBRARY_PATH.split('/').nth(1).unwrap_or_default().to_owned();
    Ok(Packed { bytes: archive.len() as u64, platform, is_development: library.is_development })
}

fn entries((text, folder): (&str, &Path), ports: VariablePorts, library: &PackedLibrary) -> Result<Entries, RunError> {
    let files = fmi2::scene_file_reader(folder);
    let scene = scene::read_with_files(text, &files)?;
    let (text, mut resources) = resources::of((text, &scene), &files)?;
    resources.insert("scene.toml".to_owned(), text.into_bytes());
    let frame = Simulation::new(&scene, CouplingMode::Integrated, 1)?.frame();
    let (description, manifest) = identified(&scene, ports, library, &resources)?;
    resources.insert(ArchiveManifest::FILE.to_owned(), manifest.into_bytes());
    let mut entries = Entries::from([
        ("model.png".to_owned(), model_picture(&frame, &scene)),
        ("modelDescription.xml".to_owned(), description.into_bytes()),
        ("documentation/index.html".to_owned(), documentation::page(&scene, ports, &library.bytes).into_bytes()),
        (
            "documentation/externalDependencies.html".to_owned(),
            documentation::external_dependencies(&library.bytes).into_bytes(),
        ),
        (LIBRARY_PATH.to_owned(), library.bytes.to_vec()),
    ]);
    entries.extend(resources.into_iter().map(|(name, bytes)| (format!("resources/{name}"), bytes)));
    for (path, bytes) in licenses::LICENSES {
        entries.insert(format!("documentation/licenses/{path}"), bytes.to_vec());
    }
    Ok(entries)
}

/// The model description with the GUID of the archive, and the manifest that the GUID comes from.
fn identified(
    scene: &Scene,
    ports: VariablePorts,
    library: &PackedLibrary,
    resources: &BTreeMap<String, Vec<u8>>,
) -> Result<(String, String), RunError> {
    let described = |guid: &str| {
        let fault = |e| RunError::Component { call: "pack", reason: format!("modelDescription.xml: {e}") };
        description::xml(scene, ports, guid, library.tool()).map_err(fault)
    };
    let manifest =
        ArchiveManifest::of(&ArchiveContent { description: &described("")?, library: &library.bytes, resources });
    Ok((described(manifest.guid())?, manifest.to_json()))
}

/// Sorted, deflated, without times and owners.
fn archive(entries: &Entries) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, bytes) in entries {
        zip.start_file(path.as_str(), options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn written(path: &Path, source: std::io::Error) -> RunError {
    RunError::File { verb: "write", path: path.to_path_buf(), source }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zip::ZipArchive;

    #[test]
    fn entries_are_sorted_and_carry_no_time_of_writing() {
        let entries = Entries::from([("b".to_owned(), vec![1; 100]), ("a/c".to_owned(), b"text".to_vec())]);
        let bytes = archive(&entries).unwrap();
        assert_eq!(bytes, archive(&entries).unwrap());
        let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let names: Vec<String> =
            (0..zip.len()).map(|i| zip.by_index(i).unwrap().name().unwrap().into_owned()).collect();
        assert_eq!(names, ["a/c", "b"]);
        for i in 0..zip.len() {
            assert_eq!(zip.by_index(i).unwrap().last_modified(), Some(DateTime::default()));
        }
    }
}
