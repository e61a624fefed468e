//! `gelfmu pack`: writes the FMU of a scene, with the libraries of this build and the documents of both.

mod description;
mod documentation;
mod library;
mod requirement;
pub mod resources;
mod terminals;

use crate::console::Console;
use crate::failure::{CommandError, RunError};
use crate::options::{DEFAULT_SCENE, PackOptions};
use crate::results;
use crate::source::{self, SceneSource};
use ballistic_gel::fmi2::{ArchiveContent, ArchiveManifest, Causality, OutputSet, ScalarVariable, VariablePorts};
use ballistic_gel::output::model_picture;
use ballistic_gel::scene::Scene;
use ballistic_gel::simulation::{CouplingMode, Simulation};
use library::{INSTALLATION, PLATFORMS, check_platforms};
pub use library::{LIBRARY_PATH, PackedLibraries, long_version, own_platform, platforms};
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
    results::check_archive(&options.out, &results::inputs(name, &source))?;
    let interface = interface_of(&source.scene, options)?;
    let platforms = if options.platforms.is_empty() { platforms() } else { options.platforms.clone() };
    check_platforms(&platforms)?;
    let packed = write_fmu(&source, &interface, &platforms, &options.out).map_err(|error| match error {
        RunError::File { path, source, .. } => CommandError::BadInput(format!(
            "--out {}: found {source} at {}, expected a file that can be written",
            options.out.display(),
            path.display()
        )),
        other => other.into(),
    })?;
    let file = options.out.display().to_string();
    let value = json!({ "file": file, "bytes": packed.bytes, "platforms": packed.platforms });
    let packed_for = packed.platforms.join(", ");
    let text = format!("{file}: {} bytes, scene {}, for {packed_for}", packed.bytes, source.scene.scene.name);
    console.result(&value, &text);
    let others: Vec<&str> =
        PLATFORMS.into_iter().filter(|name| !packed.platforms.iter().any(|own| own == name)).collect();
    if !others.is_empty() && options.platforms.is_empty() {
        console.note(&format!("not inside this gelfmu: {}", others.join(", ")));
    }
    if packed.is_development {
        console.warning(&format!(
            "this FMU holds the library of a development build: the same bits, some percent slower; {INSTALLATION} makes a gelfmu for FMUs to give away"
        ));
    }
    Ok(())
}

/// Variables of a packed FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedInterface {
    /// Ports of the scene, as far as they are packed.
    pub ports: VariablePorts,
    /// Set of its outputs.
    pub outputs: OutputSet,
    /// True for an archive that describes the ports of each body and sensor as a terminal.
    pub has_terminals: bool,
}

impl PackedInterface {
    /// Returns the interface with every port of a scene and every output, without terminals.
    pub fn full(scene: &Scene) -> Self {
        Self { ports: VariablePorts::of(scene), outputs: OutputSet::Full, has_terminals: false }
    }

    /// Returns the causality of a scalar.
    pub fn causality(&self, scalar: &ScalarVariable) -> Causality {
        self.ports.causality(scalar, self.outputs)
    }
}

/// Returns the interface that the options ask for; without them the outputs that serve the coupling mode of the scene.
fn interface_of(scene: &Scene, options: &PackOptions) -> Result<PackedInterface, CommandError> {
    let ports = VariablePorts::of(scene);
    let fragments = count_ports("fragment", "body", options.fragments, ports.fragments())?;
    let sensors = count_ports("sensor", "sensor", options.sensors, ports.sensors())?;
    let own = match scene.coupling.mode {
        CouplingMode::Integrated => OutputSet::Integrated,
        CouplingMode::Corrected | CouplingMode::Prescribed => OutputSet::Corrected,
    };
    let outputs = options.outputs.map_or(own, OutputSet::from);
    let ports = ports.limited_to(fragments, sensors);
    Ok(PackedInterface { ports, outputs, has_terminals: options.terminals })
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
    /// FMI names of the platforms of its libraries.
    pub platforms: Vec<String>,
    /// True for the library of a development build.
    pub is_development: bool,
}

/// Path and bytes of each file in the archive, sorted.
type ArchiveEntries = BTreeMap<String, Vec<u8>>;

/// Writes the FMU of a scene with this interface for platforms that this program [can pack](platforms). The same scene
/// and interface give the same bytes.
pub fn write_fmu(
    source: &SceneSource,
    interface: &PackedInterface,
    platforms: &[String],
    file: &Path,
) -> Result<PackedFmu, RunError> {
    let libraries = PackedLibraries::find(platforms)?;
    let zipped = zip_archive(archive_entries(source, interface, &libraries)?, &libraries);
    let archive = zipped.map_err(|error| RunError::File {
        verb: "write",
        path: file.to_path_buf(),
        source: io::Error::other(error),
    })?;
    results::replace(file, &archive)?;
    let (platforms, is_development) = (libraries.platforms(), libraries.archive.is_none());
    Ok(PackedFmu { bytes: archive.len() as u64, platforms, is_development })
}

/// Makes the files of the archive but the libraries: model description, documents, picture, resources and licences.
fn archive_entries(
    source: &SceneSource,
    interface: &PackedInterface,
    libraries: &PackedLibraries,
) -> Result<ArchiveEntries, RunError> {
    let scene = &source.scene;
    let SceneResources { text, files: mut resources } = resources::collect(source)?;
    resources.insert("scene.toml".to_owned(), text.into_bytes());
    let frame = Simulation::new(scene, CouplingMode::Integrated, 1)?.frame();
    let describe = |guid: &str| {
        let fault = |e| RunError::Component { call: "pack", reason: format!("modelDescription.xml: {e}") };
        description::xml(scene, interface, guid, libraries.tool()).map_err(fault)
    };
    let content = ArchiveContent { description: &describe("")?, libraries: &libraries.files, resources: &resources };
    let manifest = ArchiveManifest::of(&content);
    resources.insert(ArchiveManifest::FILE.to_owned(), manifest.to_json().into_bytes());
    let picture = model_picture(&frame, scene);
    let mut entries = ArchiveEntries::new();
    if interface.has_terminals {
        let terminals = terminals::xml(interface)
            .map_err(|e| RunError::Component { call: "pack", reason: format!("{}: {e}", terminals::FILE) })?;
        entries.insert(terminals::ICON.to_owned(), picture.clone());
        entries.insert(terminals::FILE.to_owned(), terminals.into_bytes());
    }
    entries.extend([
        ("model.png".to_owned(), picture),
        ("modelDescription.xml".to_owned(), describe(manifest.guid())?.into_bytes()),
        ("documentation/index.html".to_owned(), documentation::page(scene, interface, &libraries.files).into_bytes()),
        (
            "documentation/externalDependencies.html".to_owned(),
            documentation::external_dependencies(&libraries.files).into_bytes(),
        ),
    ]);
    entries.extend(resources.into_iter().map(|(name, bytes)| (format!("resources/{name}"), bytes)));
    for (path, bytes) in licenses::LICENSES {
        entries.insert(format!("documentation/licenses/{path}"), bytes.to_vec());
    }
    Ok(entries)
}

/// Compresses the files of an archive, sorted, without times and owners. Libraries that are compressed already are copied.
fn zip_archive(mut entries: ArchiveEntries, libraries: &PackedLibraries) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let mut compressed = libraries.archive.clone();
    entries.extend(libraries.files.iter().map(|(path, bytes)| (format!("binaries/{path}"), bytes.clone())));
    for (path, bytes) in entries {
        if let Some(library) = compressed.as_mut().and_then(|archive| archive.by_name(&path).ok()) {
            zip.raw_copy_file(library)?;
        } else {
            zip.start_file(path.as_str(), options)?;
            zip.write_all(&bytes)?;
        }
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
        let libraries = PackedLibraries { files: [("linux64/a.so".to_owned(), vec![2; 100])].into(), archive: None };
        let bytes = zip_archive(entries.clone(), &libraries).unwrap();
        assert_eq!(bytes, zip_archive(entries, &libraries).unwrap());
        let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let names: Vec<String> =
            (0..zip.len()).map(|i| zip.by_index(i).unwrap().name().unwrap().into_owned()).collect();
        assert_eq!(names, ["a/c", "b", "binaries/linux64/a.so"]);
        for i in 0..zip.len() {
            assert_eq!(zip.by_index(i).unwrap().last_modified(), Some(DateTime::default()));
        }
    }
}
