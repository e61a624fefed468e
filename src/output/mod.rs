//! What a run leaves behind: history, frames, summary and report. Reads the simulation; never writes to it.

use crate::scene::Scene;
use crate::simulation::Simulation;
use std::path::Path;

/// How the simulation was driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interface {
    /// Through the FMI 2.0 C interface.
    Fmi2,
    /// By the library.
    Direct,
}

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {path}: {source}")]
pub struct OutputError {
    /// The file or folder.
    pub path: std::path::PathBuf,
    /// Why.
    pub source: std::io::Error,
}

/// Writes the folder of one run as it goes.
pub struct Recorder {}

impl Recorder {
    /// Makes the folder and starts afresh in it.
    ///
    /// # Errors
    /// [`OutputError`] when the folder cannot be written.
    pub fn create(_folder: &Path, _scene: &Scene, _interface: Interface, _threads: usize) -> Result<Self, OutputError> {
        todo!()
    }
    /// One row of history, and a frame when one is due. Called after initialisation and after each communication step.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn record(&mut self, _simulation: &Simulation) -> Result<(), OutputError> {
        todo!()
    }
    /// Forgets rows and frames after `time`, s: an earlier state was restored.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn rewind(&mut self, _time: f64) -> Result<(), OutputError> {
        todo!()
    }
    /// Writes `series.pvd`, `summary.json` and `report.html`. `failure` is the diagnosis of a run that stopped early.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be written.
    pub fn finish(&mut self, _simulation: &Simulation, _failure: Option<&str>) -> Result<(), OutputError> {
        todo!()
    }
}
