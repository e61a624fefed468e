//! A run through the packed FMU, as an importer does it.

use crate::interrupt;
use crate::job::{Ending, Job, Progress, RunError};
use crate::pack::pack;
use ballistic_gel::fmi2::{self, Ports};
use ballistic_gel::scene::Scene;
use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2};
use fmi_rs::model_description::fmi2::{Causality, ModelDescription, ScalarVariable, VariableType};
use fmi_rs::sim::SimulationError;
use fmi_rs::zip::extract_zip_archive;
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::TempDir;

/// An instance of the FMU and what it logged.
pub struct Importer {
    /// The instance.
    pub fmu: Arc<FMU2<CS>>,
    description: ModelDescription,
    log: Arc<Messages>,
    /// Where it was unpacked; goes after the instance.
    _folder: TempDir,
}

/// The coupling mode in which the FMU needs no inputs.
const INTEGRATED: i32 = 2;

/// Warnings and errors of the FMU, in order.
#[derive(Default)]
struct Messages(Mutex<Vec<String>>);

impl Logger for Messages {
    fn log_call(&self, _status: fmi2Status, _message: &str) {}

    fn log_message(&self, _status: fmi2Status, _category: &str, message: &str) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_owned());
    }
}

/// Packs the scene, unpacks it as an importer would, and runs it with the projectile integrated inside.
pub fn run(job: &Job, progress: &mut Progress<'_>) -> Result<Ending, RunError> {
    let scene = job.read_scene()?;
    let (_, name) = placed(job)?;
    let (text, place) = &job.scene;
    let importer = Importer::new((text, place), &scene, &name)?;
    importer.start(job, &scene)?;
    let ending = importer.advance((job, &scene), progress)?;
    importer.check("fmi2Terminate", importer.fmu.terminate())?;
    Ok(ending)
}

impl Importer {
    /// Packs a scene, a text and the folder of its files, and unpacks and instantiates it under a name.
    pub fn new(text: (&str, &Path), scene: &Scene, name: &str) -> Result<Self, RunError> {
        let folder = tempfile::tempdir().map_err(|e| file("create", &std::env::temp_dir(), e))?;
        interrupt::remove_on_exit(folder.path());
        let (archive, unpacked) = (folder.path().join("BallisticGel.fmu"), folder.path().join("unpacked"));
        pack(text, Ports::of(scene), &archive)?;
        let log = Arc::new(Messages::default());
        let made = extract_zip_archive(&archive, &unpacked)
            .map_err(SimulationError::from)
            .and_then(|()| Ok(ModelDescription::from_path(&unpacked.join("modelDescription.xml"))?))
            .and_then(|description| {
                let (guid, logger): (_, Arc<dyn Logger>) = (&description.guid, log.clone());
                let fmu = FMU2::<CS>::new(&unpacked, fmi2::MODEL, name, guid, false, false, false, logger, false)?;
                Ok((fmu, description))
            });
        match made {
            Ok((fmu, description)) => Ok(Self { fmu, description, log, _folder: folder }),
            Err(error) => Err(component("fmi2Instantiate", format!("{error}. {}", log.take()))),
        }
    }

    /// Sets the parameters of a run and initializes.
    fn start(&self, job: &Job, scene: &Scene) -> Result<(), RunError> {
        let (directory, _) = placed(job)?;
        let texts = [self.reference("output_directory")?];
        self.check("fmi2SetString", self.fmu.setString(&texts, &[&directory]))?;
        self.initialize(job.threads, scene.scene.end_time)
    }

    /// Initializes for so many threads and up to a time, s, with the projectile integrated inside.
    pub fn initialize(&self, threads: usize, end: f64) -> Result<(), RunError> {
        let threads = i32::try_from(threads).unwrap_or(i32::MAX);
        let integers = [self.reference("threads")?, self.reference("coupling.mode")?];
        self.check("fmi2SetInteger", self.fmu.setInteger(&integers, &[threads, INTEGRATED]))?;
        self.check("fmi2SetupExperiment", self.fmu.setupExperiment(None, 0.0, Some(end)))?;
        self.check("fmi2EnterInitializationMode", self.fmu.enterInitializationMode())?;
        self.check("fmi2ExitInitializationMode", self.fmu.exitInitializationMode())
    }

    /// Steps to the end, to a step that cannot be completed, or until the user has enough.
    fn advance(&self, (job, scene): (&Job, &Scene), progress: &mut Progress<'_>) -> Result<Ending, RunError> {
        let mut now = 0.0;
        if progress(now, scene.scene.end_time).is_break() {
            return Ok(Ending::Interrupted);
        }
        for end in job.times(scene) {
            let status = self.fmu.doStep(now, end - now, 0);
            if status == fmi2Status::Discard {
                return Ok(Ending::Stopped(self.log.take()));
            }
            self.check("fmi2DoStep", status)?;
            now = end;
            if progress(now, scene.scene.end_time).is_break() {
                return Ok(Ending::Interrupted);
            }
        }
        Ok(Ending::Completed)
    }

    /// Value references of all outputs that are real numbers.
    pub fn outputs(&self) -> Vec<u32> {
        let is_real = |v: &&ScalarVariable| matches!(v.variableType, VariableType::Real { .. });
        let all = self.description.modelVariables.iter().filter(|v| v.causality == Causality::Output);
        all.filter(is_real).map(|v| v.valueReference).collect()
    }

    fn reference(&self, name: &str) -> Result<u32, RunError> {
        let variable = self.description.modelVariables.iter().find(|v| v.name == name);
        let missing = || component("modelDescription.xml", format!("there is no variable {name}"));
        variable.map(|v| v.valueReference).ok_or_else(missing)
    }

    /// Anything but success is an error: a warning of this FMU says that files can no longer be written.
    pub fn check(&self, call: &'static str, status: fmi2Status) -> Result<(), RunError> {
        if status == fmi2Status::Ok { Ok(()) } else { Err(component(call, self.log.take())) }
    }
}

impl Messages {
    fn take(&self) -> String {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner)).join(" ")
    }
}

/// The parent of the folder as `output_directory`, and its name as the name of the instance; or what is wrong with it.
pub fn destination(folder: &Path) -> Result<(String, String), String> {
    let absolute = std::path::absolute(folder).map_err(|e| e.to_string())?;
    let text = |part: Option<&OsStr>| part.and_then(OsStr::to_str).map(str::to_owned);
    let (parent, name) = (text(absolute.parent().map(Path::as_os_str)), text(absolute.file_name()));
    let (parent, name) = parent.zip(name).ok_or("a path that does not end with a name of UTF-8 text")?;
    if name.trim().is_empty() || fmi2::folder_name(&name) != name {
        return Err(format!("the name {name:?}, which an FMU gives no folder"));
    }
    Ok((parent, name))
}

fn placed(job: &Job) -> Result<(String, String), RunError> {
    destination(&job.folder).map_err(|found| file("use", &job.folder, std::io::Error::other(found)))
}

fn file(verb: &'static str, path: &Path, source: std::io::Error) -> RunError {
    RunError::File { verb, path: path.to_path_buf(), source }
}

fn component(call: &'static str, reason: String) -> RunError {
    RunError::Component { call, reason }
}
