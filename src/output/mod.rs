//! What a run leaves behind: history, frames, summary and report. Reads the simulation; never writes to it.

mod body;
mod bounds;
mod files;
mod frames;
mod history;
mod overlap;
mod picture;
mod report;
mod steps;
mod summary;
mod vtu;

use crate::scene::Scene;
use crate::simulation::{Frame, Observation, Simulation};
use std::path::Path;

pub use files::{OutputError, claim};
pub use picture::model_picture;
pub use steps::{Figures, draw as draw_steps};
pub use summary::{Account, Interface, Summary};

use frames::FrameSeries;
use history::History;
use summary::Run;

/// Writes the folder of one run as it goes.
///
/// `history.csv`, `frames/` and `series.pvd` are complete after every call, so that a killed run leaves readable files;
/// `summary.json` and `report.html` are written by [`Recorder::finish`].
#[derive(Debug)]
pub struct Recorder {
    folder: std::path::PathBuf,
    run: Run,
    history: History,
    frames: FrameSeries,
    /// Keeps other runs out of the folder.
    _claim: Option<std::fs::File>,
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
    /// Makes the folder and starts afresh in it: what an earlier run of this name left there is removed.
    ///
    /// # Errors
    /// [`OutputError`] when the folder cannot be written, or another run is writing there.
    pub fn create(folder: &Path, scene: &Scene, interface: Interface, threads: usize) -> Result<Self, OutputError> {
        let claim = claim(folder)?;
        files::clear(folder)?;
        Ok(Self {
            folder: folder.to_path_buf(),
            run: Run::start(scene, interface, threads),
            history: History::create(&folder.join("history.csv"), scene.fragment.len())?,
            frames: FrameSeries::create(folder, scene)?,
            _claim: claim,
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
            self.run.initial_mass = Some(frame().mass);
        }
        if self.frames.is_due(observation.time) { self.frames.append(&frame(), &self.run.scene) } else { Ok(()) }
    }

    /// Forgets rows and frames after `time`, s: an earlier state was restored.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn rewind(&mut self, time: f64) -> Result<(), OutputError> {
        self.history.rewind(time)?;
        self.frames.rewind(time)
    }

    /// Writes `series.pvd`, `summary.json` and `report.html`. `failure` is the diagnosis of a run that stopped early.
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
        let summary = Summary::of(&self.run, ending);
        if !summary.completed {
            self.frames.append_last(ending.frame, &self.run.scene)?;
        }
        files::write(&self.folder.join("summary.json"), summary.to_json().as_bytes())?;
        let rows = self.history.thinned(report::PLOT_POINTS)?;
        let page = report::page(&self.run.scene, &summary, &rows, &self.frames.shots());
        files::write(&self.folder.join("report.html"), page.as_bytes())?;
        Ok(summary)
    }
}
