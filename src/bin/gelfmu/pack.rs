//! `gelfmu pack`: writes the FMU of a scene, with the library of this build and the documents of both.

mod description;
mod documentation;
mod library;
mod requirement;
pub mod resources;

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::options::{DEFAULT_SCENE, PackOptions};
use crate::results;
use crate::source::{self, SceneSource};
use ballistic_gel::fmi2::{ArchiveContent, ArchiveManifest, VariablePorts};
use ballistic_gel::output::model_picture;
use ballistic_gel::scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use library::INSTALLATION;
pub use library::{LIBRARY_PATH, PackedLibrary};
use resources::SceneResources;
use serde_json::json;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

mod licenses {
    include!(concat!(env!("OUT_DIR"), "/licenses.rs"));
}

/// Writes the FMU of a scene.
pub fn pack(options: &PackOptions, console: &Console) -> Result<(), CommandError> {
    let name = options.named.as_deref().or(options.scene.as_deref()).unwrap_or(DEFAULT_SCENE);
    let source = source::load_for_fmu(name, &options.set)?;
    console.notes(&scene::former_keys(&source.text));
    results::check_archive(&options.out, &results::inputs(name, &source))?;
    let available = VariablePorts::of(&source.scene);
    let ports = VariablePorts {
        fragments: count_ports("fragment", "body", options.fragments, available.fragments)?,
        sensors: count_ports("sensor", "sensor", options.sensors, available.sensors)?,
    };
    let packed = write_fmu(&source, ports, &options.out).map_err(|error| match error {
        RunError::File { path, source, .. } => CommandError::BadInput(format!(
            "--out {}: found {source} at {}, expected a file that can be written",
            options.out.display(),
            path.display()
        )),
        other => other.into(),
    })?;
    let file = options.out.display().to_string();
    let value = json!({ "file": file, "bytes": packed.bytes, "platform": packed.platform });
    let text = format!("{file}: {} bytes, scene {}, for {}", packed.bytes, source.scene.scene.name, packed.platform);
    console.result(&value, &text);
    if packed.is_development {
        console.warning(&format!(
            "this FMU holds the library of a development build: the same bits, some percent slower; {INSTALLATION} makes a gelfmu for FMUs to give away"
        ));
    }
    Ok(())
}

/// Returns the number of ports of a kind: the requested number, at most the number of tables; by default all.
fn count_ports(table: &str, needs: &str, asked: Option<usize>, available: usize) -> Result<usize, CommandError> {
    match asked {
        Some(asked) if asked > available => {
            let expected = format!("at most the [[{table}]] tables of the scene, {available}: a port needs a {needs}");
            Err(CommandError::BadInput(format!("--{table}s: found {asked}, expected {expected}")))
        }
        asked => Ok(asked.unwrap_or(available)),
    }
}

/// Written FMU.
#[derive(Debug)]
pub struct PackedFmu {
    /// Size of the file.
    pub bytes: u64,
    /// FMI name of the platform of its library.
    pub platform: String,
    /// True for the library of a development build.
    pub is_development: bool,
}

/// Path and bytes of each file in the archive, sorted.
type ArchiveEntries = BTreeMap<String, Vec<u8>>;

/// Writes the FMU of a scene with these ports for this host. The same scene gives the same bytes.
pub fn write_fmu(source: &SceneSource, ports: VariablePorts, file: &Path) -> Result<PackedFmu, RunError> {
    let library = PackedLibrary::find()?;
    let zipped = zip_archive(&archive_entries(source, ports, &library)?);
    let archive = zipped.map_err(|error| RunError::File {
        verb: "write",
        path: file.to_path_buf(),
        source: io::Error::other(error),
    })?;
    results::replace(file, &archive)?;
    let platform = LIBRARY_PATH.split('/').nth(1).unwrap_or_default().to_owned();
    Ok(PackedFmu { bytes: archive.len() as u64, platform, is_development: library.is_development })
}

/// Makes the files of the archive: model description, documents, picture, library, resources and licences.
fn archive_entries(
    source: &SceneSource,
    ports: VariablePorts,
    library: &PackedLibrary,
) -> Result<ArchiveEntries, RunError> {
    let scene = &source.scene;
    let SceneResources { text, files: mut resources } = resources::collect(source)?;
    resources.insert("scene.toml".to_owned(), text.into_bytes());
    let frame = Simulation::new(scene, CouplingMode::Integrated, 1)?.frame();
    let describe = |guid: &str| {
        let fault = |e| RunError::Component { call: "pack", reason: format!("modelDescription.xml: {e}") };
        description::xml(scene, ports, guid, library.tool()).map_err(fault)
    };
    let content = ArchiveContent { description: &describe("")?, library: &library.bytes, resources: &resources };
    let manifest = ArchiveManifest::of(&content);
    resources.insert(ArchiveManifest::FILE.to_owned(), manifest.to_json().into_bytes());
    let mut entries = ArchiveEntries::from([
        ("model.png".to_owned(), model_picture(&frame, scene)),
        ("modelDescription.xml".to_owned(), describe(manifest.guid())?.into_bytes()),
        ("documentation/index.html".to_owned(), documentation::page(scene, ports, &library.bytes).into_bytes()),
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

/// Compresses the files of an archive, sorted, without times and owners.
fn zip_archive(entries: &ArchiveEntries) -> zip::result::ZipResult<Vec<u8>> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use zip::ZipArchive;

    #[test]
    fn entries_are_sorted_and_carry_no_time_of_writing() {
        let entries = ArchiveEntries::from([("b".to_owned(), vec![1; 100]), ("a/c".to_owned(), b"text".to_vec())]);
        let bytes = zip_archive(&entries).unwrap();
        assert_eq!(bytes, zip_archive(&entries).unwrap());
        let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let names: Vec<String> =
            (0..zip.len()).map(|i| zip.by_index(i).unwrap().name().unwrap().into_owned()).collect();
        assert_eq!(names, ["a/c", "b"]);
        for i in 0..zip.len() {
            assert_eq!(zip.by_index(i).unwrap().last_modified(), Some(DateTime::default()));
        }
    }
}
