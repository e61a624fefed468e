//! Run of a scene through the packed FMU, as an importer does it.

use crate::failure::RunError;
use crate::forecast::RunPoint;
use crate::interrupt;
use crate::job::{ProgressCallback, RunEnding, RunJob};
use crate::pack::{LIBRARY_PATH, PackedInterface, own_platform, write_fmu};
use crate::scratch::ScratchFolder;
use crate::source::SceneSource;
use ballistic_gel::fmi2::{self, CallStatus, LoadedFmu, VariablePorts};
use quick_xml::Reader;
use quick_xml::events::Event;
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::Path;
use zip::ZipArchive;

/// Importer with one instance of the FMU.
pub struct FmuImporter {
    /// Instance of the FMU.
    pub fmu: LoadedFmu,
    ports: VariablePorts,
    /// Folder of the unpacked archive; removed after the instance.
    _folder: ScratchFolder,
}

/// Value references of the variables that the progress needs.
struct PointReferences {
    /// Depth of the projectile and time of its exit.
    numbers: [u32; 2],
    /// Perforation of the gel.
    perforated: u32,
}

/// Coupling mode in which the FMU needs no inputs.
const INTEGRATED: i32 = 2;

/// Packs the scene, unpacks it as an importer would, and runs it with the projectile integrated inside.
pub fn run(job: &RunJob, progress: &mut ProgressCallback<'_>) -> Result<RunEnding, RunError> {
    let place = InstanceFolder::of(&job.folder).map_err(|found| file("use", &job.folder, io::Error::other(found)))?;
    let importer = FmuImporter::new(&job.source, &place.name)?;
    let reference = importer.reference("output_directory")?;
    importer.check("fmi2SetString", importer.fmu.set_string(reference, &place.parent))?;
    importer.initialize(job.threads, job.source.scene.scene.end_time)?;
    let ending = importer.advance(job, progress)?;
    importer.check("fmi2Terminate", importer.fmu.terminate())?;
    Ok(ending)
}

impl FmuImporter {
    /// Packs a scene, unpacks the archive and instantiates the FMU under a name.
    pub fn new(source: &SceneSource, name: &str) -> Result<Self, RunError> {
        let folder = ScratchFolder::new().map_err(|e| file("create", &std::env::temp_dir(), e))?;
        interrupt::remove_on_exit(folder.path());
        let (archive, unpacked) = (folder.path().join("BallisticGel.fmu"), folder.path().join("unpacked"));
        let interface = PackedInterface::full(&source.scene);
        write_fmu(source, &interface, &[own_platform().to_owned()], &archive)?;
        let unzipped = File::open(&archive).map_err(zip::result::ZipError::from).and_then(ZipArchive::new);
        unzipped.and_then(|mut zip| zip.extract(&unpacked)).map_err(|e| file("unpack", &archive, e.into()))?;
        let description = unpacked.join("modelDescription.xml");
        let xml = std::fs::read_to_string(&description).map_err(|e| file("read", &description, e))?;
        let guid = guid_of(&xml).ok_or_else(|| component("modelDescription.xml", "it has no guid".to_owned()))?;
        let fmu = LoadedFmu::new(&unpacked.join(LIBRARY_PATH), name, &guid, &unpacked.join("resources"));
        let fmu = fmu.map_err(|error| component("fmi2Instantiate", error.to_string()))?;
        Ok(Self { fmu, ports: interface.ports, _folder: folder })
    }

    /// Initializes a run of this number of threads up to a time, s, with the projectile integrated inside.
    pub fn initialize(&self, threads: usize, end: f64) -> Result<(), RunError> {
        let threads = i32::try_from(threads).unwrap_or(i32::MAX);
        for (name, value) in [("threads", threads), ("coupling.mode", INTEGRATED)] {
            self.check("fmi2SetInteger", self.fmu.set_integer(self.reference(name)?, value))?;
        }
        self.check("fmi2SetupExperiment", self.fmu.set_up_experiment(end))?;
        self.check("fmi2EnterInitializationMode", self.fmu.enter_initialization())?;
        self.check("fmi2ExitInitializationMode", self.fmu.exit_initialization())
    }

    /// Steps to the end, to a step that cannot be completed, or until `progress` asks to stop.
    fn advance(&self, job: &RunJob, progress: &mut ProgressCallback<'_>) -> Result<RunEnding, RunError> {
        let (mut now, references) = (0.0, self.point_references()?);
        // Warnings about the scene are no diagnosis of a step; they stand in the summary.
        drop(self.fmu.take_messages());
        if progress(self.point(now, &references)?).is_break() {
            return Ok(RunEnding::Interrupted);
        }
        for end in job.times() {
            let status = self.fmu.do_step(now, end - now, true);
            if status == CallStatus::Discard {
                return Ok(RunEnding::Stopped(self.fmu.take_messages()));
            }
            self.check("fmi2DoStep", status)?;
            now = end;
            if self.is_over()? {
                return Ok(RunEnding::Completed);
            }
            if progress(self.point(now, &references)?).is_break() {
                return Ok(RunEnding::Interrupted);
            }
        }
        Ok(RunEnding::Completed)
    }

    /// Returns true if the exit or the rest of the projectile ends the run.
    fn is_over(&self) -> Result<bool, RunError> {
        let mut is_over = false;
        let reference = self.reference("scene.is_over")?;
        self.check("fmi2GetBoolean", self.fmu.get_boolean(reference, &mut is_over))?;
        Ok(is_over)
    }

    /// Returns the state of the projectile at a time, s, for the progress.
    fn point(&self, time: f64, references: &PointReferences) -> Result<RunPoint, RunError> {
        let mut values = [0.0; 2];
        self.check("fmi2GetReal", self.fmu.get_reals(&references.numbers, &mut values))?;
        let mut has_left = false;
        self.check("fmi2GetBoolean", self.fmu.get_boolean(references.perforated, &mut has_left))?;
        let [depth, exit] = values;
        Ok(RunPoint { time, depth, exit: has_left.then_some(exit) })
    }

    /// Returns the references of the variables that the progress needs.
    fn point_references(&self) -> Result<PointReferences, RunError> {
        let numbers = [self.reference("projectile.depth")?, self.reference("projectile.exit_time")?];
        Ok(PointReferences { numbers, perforated: self.reference("projectile.perforated")? })
    }
    fn reference(&self, name: &str) -> Result<u32, RunError> {
        let missing = || component("modelDescription.xml", format!("there is no variable {name}"));
        self.ports.scalars().find(|scalar| scalar.name() == name).map(|scalar| scalar.reference()).ok_or_else(missing)
    }

    /// Refuses every status but success: a warning of this FMU says that files can no longer be written.
    pub fn check(&self, call: &'static str, status: CallStatus) -> Result<(), RunError> {
        if status == CallStatus::Ok { Ok(()) } else { Err(component(call, self.fmu.take_messages())) }
    }
}

/// Returns the GUID of a model description.
fn guid_of(xml: &str) -> Option<String> {
    let mut reader = Reader::from_str(xml);
    loop {
        match reader.read_event().ok()? {
            Event::Start(root) => {
                let guid = root.try_get_attribute("guid").ok()??;
                return Some(guid.value.into_owned());
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

/// Result folder as the FMU takes it: the name of the instance inside `output_directory`.
pub struct InstanceFolder {
    parent: String,
    name: String,
}

impl InstanceFolder {
    /// Splits the path of a result folder; the error describes a path that an FMU cannot take.
    pub fn of(folder: &Path) -> Result<Self, String> {
        let absolute = std::path::absolute(folder).map_err(|e| e.to_string())?;
        let text = |part: Option<&OsStr>| part.and_then(OsStr::to_str).map(str::to_owned);
        let (parent, name) = (text(absolute.parent().map(Path::as_os_str)), text(absolute.file_name()));
        let (parent, name) = parent.zip(name).ok_or("a path that does not end with a name of UTF-8 text")?;
        if name.trim().is_empty() || fmi2::instance_folder_name(&name) != name {
            return Err(format!("the name {name:?}, which an FMU gives no folder"));
        }
        Ok(Self { parent, name })
    }
}

fn file(verb: &'static str, path: &Path, source: io::Error) -> RunError {
    RunError::File { verb, path: path.to_path_buf(), source }
}

fn component(call: &'static str, reason: String) -> RunError {
    RunError::Component { call, reason }
}
