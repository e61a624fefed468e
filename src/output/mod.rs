//! What a run leaves behind: history, frames, summary and report. Reads the simulation; never writes to it.

mod body;
mod bounds;
mod files;
mod folder;
mod frames;
mod history;
mod overlap;
mod penetration;
mod picture;
mod remesh_pictures;
mod report;
mod sensors;
mod summary;
mod vtu;

use crate::scene::Scene;
use crate::simulation::{Frame, Observation, Simulation};
use std::path::Path;

pub use files::OutputError;
pub use folder::{FolderClaim, FolderRefusal, FolderState, ResultFolder, TakeoverPolicy};
pub use picture::model_picture;
pub use remesh_pictures::{Figures, draw as draw_steps};
pub use sensors::{Dent, SensorFigures};
pub use summary::{Account, EndCause, ExitFigures, Interface, Summary, rebound};

use frames::FrameSeries;
use history::History;
use penetration::{Line, Penetration, Profile};
use report::Seen;
use summary::Run;

/// Writes the folder of one run as it goes.
///
/// `history.csv`, `frames/` and `series.pvd` are complete after every call, so that a killed run leaves readable files (from the
/// first record on, where they replace those of an earlier run);
/// `summary.json` and `report.html`, and of a shot `shot.csv` and `cavity.csv`, are written by [`Recorder::finish`].
#[derive(Debug)]
pub struct Recorder {
    folder: ResultFolder,
    run: Run,
    history: History,
    frames: FrameSeries,
    /// Where a projectile runs into the gel.
    line: Option<Line>,
    /// The cavity at each frame.
    cavities: Vec<Profile>,
}

/// Command whose results a recorder writes; the FMU writes the same.
pub const RUN: &str = "run";
/// Name of the table of the run.
const HISTORY: &str = "history.csv";
/// Names of the other files of a run, beside its frames.
const FILES: [&str; 4] = ["summary.json", "report.html", "shot.csv", "cavity.csv"];

/// Names of all files that a recorder can write for a scene.
#[must_use]
pub fn result_names(scene: &Scene) -> Vec<String> {
    [HISTORY].into_iter().chain(FILES).map(str::to_owned).chain(frames::names(scene)).collect()
}

/// The last instant of a run, and why it is the last.
#[derive(Debug, Clone, Copy)]
pub struct Ending<'a> {
    /// What is seen of it.
    pub observation: &'a Observation,
    /// The mesh then.
    pub frame: &'a Frame,
    /// Hash of the stored state.
    pub digest: u128,
    /// The diagnosis of a run that stopped early.
    pub failure: Option<&'a str>,
}

impl Recorder {
    /// Claims the folder; results of an earlier run there are replaced once the first record is written.
    ///
    /// # Errors
    /// [`OutputError`] when the folder is not ours to write into, or cannot be written.
    pub fn create(folder: &Path, scene: &Scene, interface: Interface, threads: usize) -> Result<Self, OutputError> {
        let (policy, needs) = (TakeoverPolicy::Replace, result_names(scene));
        let claim = FolderClaim { command: RUN, policy, needs: &needs, inputs: &[], is_of_fmu: false };
        Self::within(ResultFolder::claim(folder, &claim)?, scene, interface, threads)
    }

    /// Writes into a folder that is claimed.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn within(
        mut folder: ResultFolder,
        scene: &Scene,
        interface: Interface,
        threads: usize,
    ) -> Result<Self, OutputError> {
        let history = folder.prepare(HISTORY)?;
        Ok(Self {
            run: Run::start(scene, interface, threads),
            history: History::create(&history, scene)?,
            frames: FrameSeries::create(&mut folder, scene)?,
            line: None,
            cavities: vec![],
            folder,
        })
    }

    /// One row of history, and a frame when one is due. Called after initialisation and after each communication step.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn record(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        self.record_observation(&simulation.observe(), || simulation.frame())
    }

    /// [`Recorder::record`] of an observation already made; `frame` is asked only when a frame is due.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn record_observation(
        &mut self,
        observation: &Observation,
        frame: impl Fn() -> Frame,
    ) -> Result<(), OutputError> {
        self.history.append(observation)?;
        if self.run.initial_mass.is_none() {
            self.begin(&frame());
        }
        let is_seen = self.frames.has_files() || self.line.is_some();
        if is_seen && self.frames.is_due(observation.time) {
            self.take(&frame())?;
        }
        self.begin_folder()
    }

    /// The run has results: they take their place in the folder.
    fn begin_folder(&mut self) -> Result<(), OutputError> {
        self.folder.begin()?;
        self.history.follow(self.folder.place(HISTORY));
        Ok(())
    }

    /// Notes what is compared with the start.
    fn begin(&mut self, start: &Frame) {
        self.run.initial_mass = Some(start.mass);
        self.line = Line::of(&self.run.scene, start);
    }

    /// A frame that is due.
    fn take(&mut self, frame: &Frame) -> Result<(), OutputError> {
        self.see(frame);
        self.frames.append(frame, &self.run.scene, &mut self.folder)
    }

    /// Notes the cavity of a frame later than those before.
    fn see(&mut self, frame: &Frame) {
        let Some(line) = &self.line else { return };
        if self.cavities.last().is_none_or(|last| last.time < frame.time) {
            self.cavities.push(Profile::of(line, &self.run.scene, frame));
        }
    }

    /// Forgets rows and frames after `time`, s: an earlier state was restored.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn rewind(&mut self, time: f64) -> Result<(), OutputError> {
        self.history.rewind(time)?;
        self.cavities.retain(|cavity| cavity.time <= time);
        self.frames.rewind(time, &mut self.folder)
    }

    /// Writes `series.pvd`, `summary.json` and `report.html`, and of a shot `shot.csv` and `cavity.csv`. `failure` is the diagnosis of a run that stopped early.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn finish(&mut self, simulation: &Simulation, failure: Option<&str>) -> Result<(), OutputError> {
        let (observation, frame) = (simulation.observe(), simulation.frame());
        self.conclude(&Ending { observation: &observation, frame: &frame, digest: simulation.digest(), failure })
            .map(|_| ())
    }

    /// [`Recorder::finish`] at an instant already observed; returns what stands in `summary.json`.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn conclude(&mut self, ending: &Ending) -> Result<Summary, OutputError> {
        self.begin_folder()?;
        self.see(ending.frame);
        let penetration = self.penetration()?;
        let sensors = sensors::figures(&self.run.scene, &self.history)?;
        let summary = Summary { sensors, ..Summary::of(&self.run, ending, penetration.as_ref()) };
        if summary.ended_by != EndCause::EndTime {
            self.frames.append_last(ending.frame, &self.run.scene, &mut self.folder)?;
        }
        self.folder.write("summary.json", summary.to_json().as_bytes())?;
        if self.run.scene.output.report {
            self.report(&summary, penetration.as_ref())?;
        }
        self.folder.mark(match (summary.completed, ending.failure) {
            (true, _) => FolderState::Complete,
            (false, None) => FolderState::Interrupted,
            (false, Some(_)) => FolderState::Failed,
        })?;
        Ok(summary)
    }

    fn report(&mut self, summary: &Summary, penetration: Option<&Penetration>) -> Result<(), OutputError> {
        let rows = self.history.thinned(report::PLOT_POINTS)?;
        let seen = Seen { rows: &rows, shots: &self.frames.shots(), penetration };
        let page = report::page(&self.run.scene, summary, &seen);
        self.folder.write("report.html", page.as_bytes())
    }

    /// The shot, if it is one; its tables are written.
    fn penetration(&mut self) -> Result<Option<Penetration>, OutputError> {
        let Some(line) = &self.line else { return Ok(None) };
        let penetration = Penetration::of(line, &self.history, &self.cavities)?;
        if let Some(penetration) = &penetration {
            penetration.write(&mut self.folder)?;
        }
        Ok(penetration)
    }
}
