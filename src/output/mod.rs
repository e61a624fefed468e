//! Output of a run: history, frames, summary and report. The module reads the simulation and never writes to it.

mod accounts;
mod body;
mod bounds;
mod exit;
mod expansion;
mod files;
mod folder;
mod frames;
mod history;
#[cfg(feature = "cli")]
mod movie;
mod numbers;
mod overlap;
mod penetration;
#[cfg(feature = "cli")]
mod picture;
mod placeholder;
mod reading;
#[cfg(feature = "cli")]
mod report;
#[cfg(feature = "cli")]
mod saved_run;
mod scene_digest;
mod sensors;
mod summary;
#[cfg(feature = "cli")]
mod unit_rows;
#[cfg(feature = "cli")]
mod units;
#[cfg(feature = "cli")]
mod view;
mod vtu;
mod wound;

use crate::scene::{Dimension, FidelityKind, FidelityLevels, Scene};
use crate::simulation::{MeshFrame, Observation, Simulation};
use std::path::Path;

pub use accounts::SummaryAccount;
pub use exit::ExitFigures;
pub use expansion::ExpansionFigures;
pub use files::OutputError;
pub use folder::{FolderClaim, FolderRefusal, FolderState, ResultFolder, TakeoverPolicy};
#[cfg(feature = "cli")]
pub use movie::movie_pictures;
pub use penetration::{CavityCoursePoint, CavityGauge};
#[cfg(feature = "cli")]
pub use picture::{OpaquePicture, model_picture};
pub(crate) use reading::{MOST_FILE_BYTES, read_limited};
pub use reading::{MOST_RESULT_BYTES, MOST_TABLE_BYTES, read_limited_text, read_scene_text, scene_file_reader};
#[cfg(feature = "cli")]
pub use report::{
    ComparedCurve, CurveAbscissa, CurvePoint, CurveResidual, FigureRow, LogoImage, MOST_LOGO_BYTES, ReportDate,
    ReportIdentity, ReportRun, comparison_page, figure_rows, insert_comparison, layer_rows, peak_force_label,
    report_page, summary_schema,
};
#[cfg(feature = "cli")]
pub use saved_run::{ExitedBody, ExitedRun, SavedRunError, exited_run};
pub use sensors::{DentFigures, SensorFigures};
pub use summary::{DriverInterface, EndCause, FinalState, RunSummary, SUMMARY_FORMAT, rebound};
#[cfg(feature = "cli")]
pub use unit_rows::{layer_rows_in_units, rows_in_units};
#[cfg(feature = "cli")]
pub use units::{CustomaryUnit, FOOT, FOOT_POUND, GRAIN, INCH, POUND_FORCE, UnitSystem};
pub use wound::WoundFigures;

use frames::FrameSeries;
use history::HistoryFile;
use penetration::{CavityProfile, LAYERS, PenetrationRecord, PermanentTrack, ShotLine};
use scene_digest::scene_digest;
use summary::RunInfo;

/// Recorder of one run: writes the result folder while the run advances.
///
/// `history.csv`, `frames/` and `series.pvd` are complete after every call, therefore a killed run leaves readable
/// files. Results of an earlier run are replaced with the first record.
#[derive(Debug)]
pub struct RunRecorder {
    folder: ResultFolder,
    run: RunInfo,
    /// Digest of the scene, for the manifest of the folder.
    scene_digest: String,
    history: HistoryFile,
    frames: FrameSeries,
    /// Shot line of the projectile; absent before the first record, and in a scene without a shot.
    shot_line: Option<ShotLine>,
    /// Cavity profiles in the order of time: at each frame, and in between.
    cavities: Vec<CavityProfile>,
}

/// Name of the command `run`, under which a recorder claims its folder; the FMU uses the same name.
pub const RUN: &str = "run";
/// Cavity profiles of a run at least, about an axis and in the plane.
const CAVITY_PROFILES: f64 = 200.0;
/// Tolerance of times relative to their interval, for round-off.
const TIME_TOLERANCE: f64 = 1e-6;
/// File name of the history table.
const HISTORY: &str = "history.csv";
/// File names of the summary, the report and the tables of a shot; a scene with layers has [`LAYERS`], too.
const FILES: [&str; 6] = ["summary.json", REPORT, "shot.csv", "cavity.csv", "track.csv", "cracks.csv"];
/// File name of the report.
pub const REPORT: &str = "report.html";
/// File name of the scene of a run.
pub const SCENE: &str = "scene.toml";

/// Returns the names of all files that a recorder can write for a scene.
#[must_use]
pub fn result_names(scene: &Scene) -> Vec<String> {
    let layers = (!scene.layer.is_empty()).then_some(LAYERS);
    let tables = [HISTORY].into_iter().chain(FILES).chain(layers).map(str::to_owned);
    tables.chain(frames::frame_file_names(scene)).collect()
}

/// Returns the text of a scene whose file no command has written. Its values are those of the run, so it is `standard`
/// and its levels have nothing left to set.
fn scene_text(scene: &Scene) -> String {
    let mut scene = scene.clone();
    // The reduced model has no values that the scene could have.
    if scene.scene.fidelity != FidelityKind::Instant {
        scene.scene.fidelity = FidelityKind::Standard;
    }
    let FidelityLevels { draft, coarse, standard, fine, reference } = &mut scene.fidelity;
    [draft, coarse, standard, fine, reference].into_iter().flatten().for_each(|level| level.set.clear());
    let text = toml::to_string(&scene).expect("a scene consists of tables, numbers and text");
    format!("# Scene of this run.\n\n{text}")
}

impl RunRecorder {
    /// Claims the folder. Results of an earlier run are replaced at the first record.
    ///
    /// # Errors
    /// [`OutputError`] if the folder belongs to another owner or cannot be written.
    pub fn create(
        folder: &Path,
        scene: &Scene,
        interface: DriverInterface,
        threads: usize,
    ) -> Result<Self, OutputError> {
        let (policy, needs) = (TakeoverPolicy::Replace, result_names(scene));
        let claim = FolderClaim { command: RUN, policy, needs: &needs, inputs: &[], is_of_fmu: false };
        Self::within(ResultFolder::claim(folder, &claim)?, scene, interface, threads)
    }

    /// Creates the recorder in a claimed folder.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be written.
    pub fn within(
        mut folder: ResultFolder,
        scene: &Scene,
        interface: DriverInterface,
        threads: usize,
    ) -> Result<Self, OutputError> {
        let history = folder.prepare(HISTORY)?;
        if !folder.place(SCENE).exists() {
            folder.write(SCENE, scene_text(scene).as_bytes())?;
        }
        Ok(Self {
            run: RunInfo::start(scene, interface, threads),
            scene_digest: scene_digest(scene),
            history: HistoryFile::create(&history, scene)?,
            frames: FrameSeries::create(&mut folder, scene)?,
            shot_line: None,
            cavities: vec![],
            folder,
        })
    }

    /// Appends one row of history, and a frame when a frame is due. Call it after initialisation and after each
    /// communication step.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be written.
    pub fn record(&mut self, simulation: &Simulation) -> Result<(), OutputError> {
        self.record_observation(&simulation.observe(), || simulation.frame())
    }

    /// Records an existing observation, see [`RunRecorder::record`]; `frame` is called only when a frame is due.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be written.
    pub fn record_observation(
        &mut self,
        observation: &Observation,
        frame: impl Fn() -> MeshFrame,
    ) -> Result<(), OutputError> {
        self.history.append(observation)?;
        if self.run.initial_mass.is_none() {
            self.record_start(&frame());
        }
        let needs_frame = self.frames.has_files() || self.shot_line.is_some();
        if needs_frame && self.frames.is_due(observation.time) {
            self.record_frame(&frame())?;
        } else if self.is_cavity_due(observation.time) {
            self.record_cavity(&frame());
        }
        self.begin_results()
    }

    /// Moves the first results to their final place in the folder.
    fn begin_results(&mut self) -> Result<(), OutputError> {
        self.folder.begin()?;
        self.folder.record_scene(&self.scene_digest)?;
        self.history.set_path(self.folder.place(HISTORY));
        Ok(())
    }

    /// Returns true if a cavity profile between the frames is due; in space a profile takes as long as many steps.
    fn is_cavity_due(&self, time: f64) -> bool {
        let scene = &self.run.scene;
        let interval = scene.scene.end_time / CAVITY_PROFILES;
        let last = self.cavities.last().map_or(0.0, |last| last.time);
        self.shot_line.is_some()
            && scene.scene.dimension != Dimension::Spatial
            && time - last >= interval * (1.0 - TIME_TOLERANCE)
    }

    /// Stores the initial mass, the velocity of the block and the shot line.
    fn record_start(&mut self, start: &MeshFrame) {
        self.run.initial_mass = Some(start.mass);
        self.run.block_velocity = start.block.velocity;
        self.shot_line = ShotLine::of(&self.run.scene, start);
    }

    /// Records a due frame.
    fn record_frame(&mut self, frame: &MeshFrame) -> Result<(), OutputError> {
        self.record_cavity(frame);
        self.frames.append(frame, &self.run.scene, &mut self.folder)
    }

    /// Records the cavity profile of a frame later than all recorded frames.
    fn record_cavity(&mut self, frame: &MeshFrame) {
        let Some(line) = &self.shot_line else { return };
        if self.cavities.last().is_none_or(|last| last.time < frame.time) {
            self.cavities.push(CavityProfile::of(line, &self.run.scene, frame));
        }
    }

    /// Drops the rows and frames after `time`, s, once an earlier state is restored.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be written.
    pub fn rewind(&mut self, time: f64) -> Result<(), OutputError> {
        self.history.rewind(time)?;
        self.cavities.retain(|cavity| cavity.time <= time);
        self.frames.rewind(time, &mut self.folder)
    }

    /// Writes `series.pvd` and `summary.json`, for a shot `shot.csv`, `cavity.csv`, `track.csv` and `cracks.csv`, with
    /// layers `layers.csv`, and a page that names the command that makes the report.
    /// `failure` is the diagnosis of a run that stopped early.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be written.
    pub fn finish(&mut self, simulation: &Simulation, failure: Option<&str>) -> Result<RunSummary, OutputError> {
        let (observation, frame) = (simulation.observe(), simulation.frame());
        self.conclude(&FinalState { observation: &observation, frame: &frame, digest: simulation.digest(), failure })
    }

    /// Completes the files from an existing observation, see [`RunRecorder::finish`]; returns the contents of
    /// `summary.json`.
    ///
    /// # Errors
    /// [`OutputError`] if a file cannot be written.
    pub fn conclude(&mut self, ending: &FinalState) -> Result<RunSummary, OutputError> {
        self.begin_results()?;
        self.record_cavity(ending.frame);
        let penetration = self.evaluate_penetration(ending.frame)?;
        let rest = wound::find_rest(&self.history)?.filter(|_| ending.observation.projectile().exit.is_none());
        let wound = WoundFigures::of(penetration.as_ref(), rest);
        let sensors = sensors::figures(&self.run.scene, &self.history)?;
        let summary = RunSummary { wound, sensors, ..RunSummary::of(&self.run, ending, penetration.as_ref()) };
        if summary.ended_by != EndCause::EndTime {
            self.frames.append_last(ending.frame, &self.run.scene, &mut self.folder)?;
        }
        self.folder.write("summary.json", summary.to_json().as_bytes())?;
        if self.run.scene.output.report {
            self.folder.write(REPORT, placeholder::placeholder_page(&summary).as_bytes())?;
        }
        self.folder.mark(match (summary.completed, ending.failure) {
            (true, _) => FolderState::Complete,
            (false, None) => FolderState::Interrupted,
            (false, Some(_)) => FolderState::Failed,
        })?;
        Ok(summary)
    }

    /// Evaluates the penetration and writes the tables of a shot; returns `None` without a shot.
    fn evaluate_penetration(&mut self, end: &MeshFrame) -> Result<Option<PenetrationRecord>, OutputError> {
        let Some(line) = &self.shot_line else { return Ok(None) };
        let damage = PermanentTrack::of(line, &self.run.scene, end);
        let tear_diameter = line.tear_diameter(&self.run.scene, &end.bodies[0]);
        let penetration = PenetrationRecord::of(line, &self.history, &self.cavities, damage, tear_diameter)?;
        if let Some(penetration) = &penetration {
            penetration.write(&self.run.scene, &mut self.folder)?;
        }
        Ok(penetration)
    }
}

#[cfg(test)]
mod tests {
    use super::{scene_digest, scene_text};
    use crate::scene;

    #[test]
    fn the_written_scene_of_a_run_is_the_scene_of_the_run() {
        for (name, text) in scene::builtins() {
            let mut run = scene::read(text).unwrap();
            run.mesh.size *= 1.5;
            let again = scene::read(&scene_text(&run)).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(again.mesh, run.mesh, "{name}");
            assert_eq!(scene_digest(&again), scene_digest(&run), "{name}");
            assert_eq!((again.gel, again.projectile), (run.gel, run.projectile), "{name}");
        }
    }

    #[test]
    fn the_digest_of_a_scene_is_that_of_its_values_also_at_a_level() {
        let text = scene::builtin("sphere-block").unwrap();
        let read = |set: &str| scene::read(&scene::resolve(text, &[set.parse().unwrap()]).unwrap()).unwrap();
        let run = read("scene.fidelity=draft");
        let again = scene::read(&scene_text(&run)).expect("the scene of a run at a level is one that can be read");
        assert_eq!(again.mesh, run.mesh);
        let [own, written, standard, titled, faster] =
            [run, again, scene::read(text).unwrap(), read("scene.title=mine"), read("projectile.velocity=[0, 0, -7]")]
                .map(|scene| scene_digest(&scene));
        assert!(own == written && own != standard);
        assert!(titled == standard && faster != standard);
        let prescribed = read("coupling.mode=prescribed");
        assert_ne!(prescribed.coupling.mode, scene::read(text).unwrap().coupling.mode);
        assert_eq!(scene_digest(&prescribed), standard);
    }
}
