//! What a run leaves behind: history, frames, summary and report. Reads the simulation; never writes to it.

mod body;
mod bounds;
mod files;
mod frames;
mod history;
mod overlap;
mod penetration;
mod picture;
mod report;
mod sensors;
mod steps;
mod summary;
mod vtu;

use crate::scene::Scene;
use crate::simulation::{Frame, Observation, Simulation};
use std::path::Path;

pub use files::{OutputError, claim};
pub use picture::model_picture;
pub use sensors::{Dent, SensorFigures};
pub use steps::{Figures, draw as draw_steps};
pub use summary::{Account, EndCause, Interface, Summary, rebound};

use frames::FrameSeries;
use history::History;
use penetration::{Line, Penetration, Profile};
use report::Seen;
use summary::Run;

/// Writes the folder of one run as it goes.
///
/// `history.csv`, `frames/` and `series.pvd` are complete after every call, so that a killed run leaves readable files;
/// `summary.json` and `report.html`, and of a shot `shot.csv` and `cavity.csv`, are written by [`Recorder::finish`].
#[derive(Debug)]
pub struct Recorder {
    folder: std::path::PathBuf,
    run: Run,
    history: History,
    frames: FrameSeries,
    /// Where a projectile runs into the gel.
    line: Option<Line>,
    /// The cavity at each frame.
    cavities: Vec<Profile>,
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
            history: History::create(&folder.join("history.csv"), scene)?,
            frames: FrameSeries::create(folder, scene)?,
            line: None,
            cavities: vec![],
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
            self.begin(&frame());
        }
        if self.frames.is_due(observation.time) { self.take(&frame()) } else { Ok(()) }
    }

    /// Notes what is compared with the start.
    fn begin(&mut self, start: &Frame) {
        self.run.initial_mass = Some(start.mass);
        self.line = Line::of(&self.run.scene, start);
    }

    /// A frame that is due.
    fn take(&mut self, frame: &Frame) -> Result<(), OutputError> {
        self.see(frame);
        self.frames.append(frame, &self.run.scene)
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
        self.frames.rewind(time)
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
        self.see(ending.frame);
        let penetration = self.penetration()?;
        let sensors = sensors::figures(&self.run.scene, &self.history)?;
        let summary = Summary { sensors, ..Summary::of(&self.run, ending, penetration.as_ref()) };
        if summary.ended_by != EndCause::EndTime {
            self.frames.append_last(ending.frame, &self.run.scene)?;
        }
        files::write(&self.folder.join("summary.json"), summary.to_json().as_bytes())?;
        let rows = self.history.thinned(report::PLOT_POINTS)?;
        let seen = Seen { rows: &rows, shots: &self.frames.shots(), penetration: penetration.as_ref() };
        let page = report::page(&self.run.scene, &summary, &seen);
        files::write(&self.folder.join("report.html"), page.as_bytes())?;
        Ok(summary)
    }

    /// The shot, if it is one; its tables are written.
    fn penetration(&self) -> Result<Option<Penetration>, OutputError> {
        let Some(line) = &self.line else { return Ok(None) };
        let penetration = Penetration::of(line, &self.history, &self.cavities)?;
        if let Some(penetration) = &penetration {
            penetration.write(&self.folder)?;
        }
        Ok(penetration)
    }
}
