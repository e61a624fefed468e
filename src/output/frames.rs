//! The mesh at equally spaced times: files for ParaView, and what the report needs for its pictures.

use super::body;
use super::bounds::Bounds;
use super::files::{self, OutputError};
use super::picture::{Camera, Shot};
use super::vtu;
use crate::scene::Scene;
use crate::simulation::Frame;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Most steps between pictures of the report; a page of 13 pictures stays below some megabytes.
const PICTURE_STEPS: usize = 12;

/// A frame on disk.
#[derive(Debug)]
struct Written {
    time: f64,
    /// Which due time comes after it.
    next: usize,
    shot: Option<Shot>,
}

/// The frames of a run.
#[derive(Debug)]
pub(super) struct FrameSeries {
    folder: PathBuf,
    due: Vec<f64>,
    tolerance: f64,
    camera: Option<Camera>,
    written: Vec<Written>,
}

impl FrameSeries {
    /// No frame yet; the first is due at once.
    pub(super) fn create(folder: &Path, scene: &Scene) -> Result<Self, OutputError> {
        let (n, end) = (scene.output.frames, scene.scene.end_time);
        let due = (0..n).map(|i| end * i as f64 / n.saturating_sub(1).max(1) as f64).collect();
        let series = Self {
            folder: folder.to_path_buf(),
            due,
            // Communication points are sums of steps: they may miss a due time by round-off.
            tolerance: 1e-9 * end,
            camera: None,
            written: Vec::new(),
        };
        series.write_collection()?;
        Ok(series)
    }

    /// Whether a frame is due at `time`, s.
    pub(super) fn is_due(&self, time: f64) -> bool {
        self.due.get(self.next()).is_some_and(|due| time + self.tolerance >= *due)
    }

    /// Writes a frame that is due.
    pub(super) fn append(&mut self, frame: &Frame, scene: &Scene) -> Result<(), OutputError> {
        let before = self.next();
        let next = self.due.partition_point(|due| *due <= frame.time + self.tolerance);
        let stride = (self.due.len() - 1).div_ceil(PICTURE_STEPS).max(1);
        let pictured = next == self.due.len() || (before..next).any(|i| i.is_multiple_of(stride));
        self.write(frame, scene)?;
        let shot = pictured.then(|| self.shoot(frame, scene));
        self.written.push(Written { time: frame.time, next, shot });
        self.write_collection()
    }

    /// Writes the frame of a run that stops here, unless frames are off or it is there already.
    pub(super) fn append_last(&mut self, frame: &Frame, scene: &Scene) -> Result<(), OutputError> {
        if self.due.is_empty() || self.written.last().is_some_and(|last| last.time >= frame.time) {
            return Ok(());
        }
        self.write(frame, scene)?;
        let shot = Some(self.shoot(frame, scene));
        self.written.push(Written { time: frame.time, next: self.next(), shot });
        self.write_collection()
    }

    /// Drops the frames after `time`, s.
    pub(super) fn rewind(&mut self, time: f64) -> Result<(), OutputError> {
        let kept = self.written.partition_point(|written| written.time <= time);
        for number in kept..self.written.len() {
            files::remove(&self.folder.join(file("frame", number)))?;
            files::remove(&self.folder.join(file("projectile", number)))?;
        }
        self.written.truncate(kept);
        self.write_collection()
    }

    /// The pictures, in order of time.
    pub(super) fn shots(&self) -> Vec<&Shot> {
        self.written.iter().filter_map(|written| written.shot.as_ref()).collect()
    }

    fn next(&self) -> usize {
        self.written.last().map_or(0, |written| written.next)
    }

    fn write(&self, frame: &Frame, scene: &Scene) -> Result<(), OutputError> {
        let number = self.written.len();
        let scenery = Bounds::around(frame.points.iter().copied());
        let solids = body::solids(scene, frame, &scenery);
        files::write(&self.folder.join(file("frame", number)), &vtu::gel(frame))?;
        let surface = vtu::bodies(&solids, frame.time);
        files::write(&self.folder.join(file("projectile", number)), &surface)
    }

    /// Every picture is taken by the camera of the first one.
    fn shoot(&mut self, frame: &Frame, scene: &Scene) -> Shot {
        let camera = self.camera.get_or_insert_with(|| Camera::of(frame, scene));
        Shot::take(frame, scene, camera)
    }

    fn write_collection(&self) -> Result<(), OutputError> {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (number, Written { time, .. }) in self.written.iter().enumerate() {
            for (part, name) in ["frame", "projectile"].iter().enumerate() {
                let file = file(name, number);
                writeln!(text, "<DataSet timestep=\"{time:e}\" part=\"{part}\" file=\"{file}\"/>")
                    .expect("a string grows");
            }
        }
        text += "</Collection>\n</VTKFile>\n";
        files::write(&self.folder.join("series.pvd"), text.as_bytes())
    }
}

/// Path of a frame's file from the folder of the run.
fn file(name: &str, number: usize) -> String {
    format!("frames/{name}_{number:05}.vtu")
}
