//! A run through the packed FMU, as an importer does it.

use crate::interrupt;
use crate::job::{ProgressCallback, RunEnding, RunError, RunJob};
use crate::pack::{LIBRARY_PATH, pack};
use crate::scratch::ScratchFolder;
use ballistic_gel::fmi2::{self, CallStatus, Causality, Kind, LoadedFmu, VariablePorts, scalars};
use ballistic_gel::scene::Scene;
use quick_xml::Reader;
use quick_xml::events::Event;
use std::ffi::OsStr;
use std::fs::File;
use std::path::Path;
use zip::ZipArchive;

/// An instance of the FMU.
pub struct FmuImporter {
    /// The instance.
    pub fmu: LoadedFmu,
    ports: VariablePorts,
    /// Folder of the unpacked archive; removed after the instance.
    _folder: ScratchFolder,
}

/// The coupling mode in which the FMU needs no inputs.
const INTEGRATED: i32 = 2;

/// Packs the scene, unpacks it as an importer would, and runs it with the projectile integrated inside.
pub fn run(job: &RunJob, progress: &mut ProgressCallback<'_>) -> Result<RunEnding, RunError> {
    let scene = job.read_scene()?;
    let (_, name) = placed(job)?;
    let (text, place) = &job.scene;
    let importer = FmuImporter::new((text, place), &scene, &name)?;
    importer.start(job, &scene)?;
    let ending = importer.advance((job, &scene), progress)?;
    importer.check("fmi2Terminate", importer.fmu.terminate())?;
    Ok(ending)
}

impl FmuImporter {
    /// Packs a scene, a text and the folder of its files, and unpacks and instantiates it under a name.
    pub fn new(text: (&str, &Path), scene: &Scene, name: &str) -> Result<Self, RunError> {
        let folder = ScratchFolder::new().map_err(|e| file("create", &std::env::temp_dir(), e))?;
        interrupt::remove_on_exit(folder.path());
        let (archive, unpacked) = (folder.path().join("BallisticGel.fmu"), folder.path().join("unpacked"));
        let ports = VariablePorts::of(scene);
        pack(text, ports, &archive)?;
        let unzipped = File::open(&archive).map_err(zip::result::ZipError::from).and_then(ZipArchive::new);
        unzipped.and_then(|mut zip| zip.extract(&unpacked)).map_err(|e| file("unpack", &archive, e.into()))?;
        let description = unpacked.join("modelDescription.xml");
        let xml = std::fs::read_to_string(&description).map_err(|e| file("read", &description, e))?;
        let guid = guid_of(&xml).ok_or_else(|| component("modelDescription.xml", "it has no guid".to_owned()))?;
        let fmu = LoadedFmu::new(&unpacked.join(LIBRARY_PATH), name, &guid, &unpacked.join("resources"));
        let fmu = fmu.map_err(|error| component("fmi2Instantiate", error.to_string()))?;
        Ok(Self { fmu, ports, _folder: folder })
    }

    /// Sets the parameters of a run and initializes.
    fn start(&self, job: &RunJob, scene: &Scene) -> Result<(), RunError> {
        let (directory, _) = placed(job)?;
        let reference = self.reference("output_directory")?;
        self.check("fmi2SetString", self.fmu.set_string(reference, &directory))?;
        self.initialize(job.threads, scene.scene.end_time)
    }

    /// Initializes for so many threads and up to a time, s, with the projectile integrated inside.
    pub fn initialize(&self, threads: usize, end: f64) -> Result<(), RunError> {
        let threads = i32::try_from(threads).unwrap_or(i32::MAX);
        for (name, value) in [("threads", threads), ("coupling.mode", INTEGRATED)] {
            self.check("fmi2SetInteger", self.fmu.set_integer(self.reference(name)?, value))?;
        }
        self.check("fmi2SetupExperiment", self.fmu.set_up_experiment(end))?;
        self.check("fmi2EnterInitializationMode", self.fmu.enter_initialization())?;
        self.check("fmi2ExitInitializationMode", self.fmu.exit_initialization())
    }

    /// Steps to the end, to a step that cannot be completed, or until the user has enough.
    fn advance(
        &self,
        (job, scene): (&RunJob, &Scene),
        progress: &mut ProgressCallback<'_>,
    ) -> Result<RunEnding, RunError> {
        let mut now = 0.0;
        // Warnings about the scene are no diagnosis of a step; they stand in the summary.
        drop(self.fmu.take_messages());
        if progress(now, scene.scene.end_time).is_break() {
            return Ok(RunEnding::Interrupted);
        }
        for end in job.times(scene) {
            let status = self.fmu.do_step(now, end - now, true);
            if status == CallStatus::Discard {
                return Ok(RunEnding::Stopped(self.fmu.take_messages()));
            }
            self.check("fmi2DoStep", status)?;
            now = end;
            if self.is_over()? {
                return Ok(RunEnding::Completed);
            }
            if progress(now, scene.scene.end_time).is_break() {
                return Ok(RunEnding::Interrupted);
            }
        }
        Ok(RunEnding::Completed)
    }

    /// Returns true if `scene.stop_after_exit` ends the run.
    fn is_over(&self) -> Result<bool, RunError> {
        let mut is_over = false;
        let reference = self.reference("scene.is_over")?;
        self.check("fmi2GetBoolean", self.fmu.get_boolean(reference, &mut is_over))?;
        Ok(is_over)
    }

    /// Value references of all outputs that are real numbers.
    pub fn outputs(&self) -> Vec<u32> {
        let all = scalars(self.ports).filter(|scalar| scalar.variable.causality == Causality::Output);
        all.filter(|scalar| scalar.variable.kind == Kind::Real).map(|scalar| scalar.reference()).collect()
    }

    fn reference(&self, name: &str) -> Result<u32, RunError> {
        let missing = || component("modelDescription.xml", format!("there is no variable {name}"));
        scalars(self.ports).find(|scalar| scalar.name() == name).map(|scalar| scalar.reference()).ok_or_else(missing)
    }

    /// Anything but success is an error: a warning of this FMU says that files can no longer be written.
    pub fn check(&self, call: &'static str, status: CallStatus) -> Result<(), RunError> {
        if status == CallStatus::Ok { Ok(()) } else { Err(component(call, self.fmu.take_messages())) }
    }
}

/// The GUID that a model description has.
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

/// The parent of the folder as `output_directory`, and its name as the name of the instance; or what is wrong with it.
pub fn destination(folder: &Path) -> Result<(String, String), String> {
    let absolute = std::path::absolute(folder).map_err(|e| e.to_string())?;
    let text = |part: Option<&OsStr>| part.and_then(OsStr::to_str).map(str::to_owned);
    let (parent, name) = (text(absolute.parent().map(Path::as_os_str)), text(absolute.file_name()));
    let (parent, name) = parent.zip(name).ok_or("a path that does not end with a name of UTF-8 text")?;
    if name.trim().is_empty() || fmi2::instance_folder_name(&name) != name {
        return Err(format!("the name {name:?}, which an FMU gives no folder"));
    }
    Ok((parent, name))
}

fn placed(job: &RunJob) -> Result<(String, String), RunError> {
    destination(&job.folder).map_err(|found| file("use", &job.folder, std::io::Error::other(found)))
}

fn file(verb: &'static str, path: &Path, source: std::io::Error) -> RunError {
    RunError::File { verb, path: path.to_path_buf(), source }
}

fn component(call: &'static str, reason: String) -> RunError {
    RunError::Component { call, reason }
}
