//! The mesh at equally spaced times: files for ParaView, and what the report needs for its pictures.

use super::body;
use super::bounds::Bounds;
use super::files::OutputError;
use super::folder::ResultFolder;
use super::picture::{Camera, Shot};
use super::vtu;
use crate::scene::Scene;
use crate::simulation::Frame;
use std::fmt::Write;

/// Most steps between pictures of the report; a page of 13 pictures stays below some megabytes.
const PICTURE_STEPS: usize = 12;

/// Name of the file that ParaView opens.
const COLLECTION: &str = "series.pvd";

/// A frame on disk.
#[derive(Debug)]
struct Written {
    time: f64,
    /// Which due time comes after it.
    next: usize,
    shot: Option<Shot>,
}

/// Moments at which the cavity of a shot is looked at in a run without frames.
const UNSEEN_MOMENTS: usize = 41;

/// The frames of a run.
#[derive(Debug)]
pub(super) struct FrameSeries {
    due: Vec<f64>,
    tolerance: f64,
    /// Whether frames are written; without, they are looked at for the cavity alone.
    has_files: bool,
    /// Whether there is a report that shows pictures of them.
    has_pictures: bool,
    camera: Option<Camera>,
    written: Vec<Written>,
}

impl FrameSeries {
    /// No frame yet; the first is due at once.
    pub(super) fn create(folder: &mut ResultFolder, scene: &Scene) -> Result<Self, OutputError> {
        let has_files = scene.output.frames > 0;
        let (n, end) = (if has_files { scene.output.frames } else { UNSEEN_MOMENTS }, scene.scene.end_time);
        let due = (0..n).map(|i| end * i as f64 / n.saturating_sub(1).max(1) as f64).collect();
        let series = Self {
            due,
            // Communication points are sums of steps: they may miss a due time by round-off.
            tolerance: 1e-9 * end,
            has_files,
            has_pictures: has_files && scene.output.report,
            camera: None,
            written: Vec::new(),
        };
        series.write_collection(folder)?;
        Ok(series)
    }

    /// Returns true if frames are written.
    pub(super) fn has_files(&self) -> bool {
        self.has_files
    }

    /// Whether a frame is due at `time`, s.
    pub(super) fn is_due(&self, time: f64) -> bool {
        self.due.get(self.next()).is_some_and(|due| time + self.tolerance >= *due)
    }

    /// Writes a frame that is due.
    pub(super) fn append(
        &mut self,
        frame: &Frame,
        scene: &Scene,
        folder: &mut ResultFolder,
    ) -> Result<(), OutputError> {
        let before = self.next();
        let next = self.due.partition_point(|due| *due <= frame.time + self.tolerance);
        let stride = (self.due.len() - 1).div_ceil(PICTURE_STEPS).max(1);
        let pictured = next == self.due.len() || (before..next).any(|i| i.is_multiple_of(stride));
        self.write(frame, scene, folder)?;
        let shot = (pictured && self.has_pictures).then(|| self.shoot(frame, scene));
        self.written.push(Written { time: frame.time, next, shot });
        self.write_collection(folder)
    }

    /// Writes the frame of a run that stops here, unless frames are off or it is there already.
    pub(super) fn append_last(
        &mut self,
        frame: &Frame,
        scene: &Scene,
        folder: &mut ResultFolder,
    ) -> Result<(), OutputError> {
        if !self.has_files || self.written.last().is_some_and(|last| last.time >= frame.time) {
            return Ok(());
        }
        self.write(frame, scene, folder)?;
        let shot = self.has_pictures.then(|| self.shoot(frame, scene));
        self.written.push(Written { time: frame.time, next: self.next(), shot });
        self.write_collection(folder)
    }

    /// Drops the frames after `time`, s.
    pub(super) fn rewind(&mut self, time: f64, folder: &mut ResultFolder) -> Result<(), OutputError> {
        let kept = self.written.partition_point(|written| written.time <= time);
        for number in kept..self.written.len() {
            folder.remove(&file("frame", number))?;
            folder.remove(&file("projectile", number))?;
        }
        self.written.truncate(kept);
        self.write_collection(folder)
    }

    /// The pictures, in order of time.
    pub(super) fn shots(&self) -> Vec<&Shot> {
        self.written.iter().filter_map(|written| written.shot.as_ref()).collect()
    }

    fn next(&self) -> usize {
        self.written.last().map_or(0, |written| written.next)
    }

    fn write(&self, frame: &Frame, scene: &Scene, folder: &mut ResultFolder) -> Result<(), OutputError> {
        if !self.has_files {
            return Ok(());
        }
        let number = self.written.len();
        let scenery = Bounds::around(frame.points.iter().copied());
        let solids = body::solids(scene, frame, &scenery);
        folder.write(&file("frame", number), &vtu::gel(frame))?;
        let surface = vtu::bodies(&solids, frame.time);
        folder.write(&file("projectile", number), &surface)
    }

    /// Every picture is taken by the camera of the first one.
    fn shoot(&mut self, frame: &Frame, scene: &Scene) -> Shot {
        let camera = self.camera.get_or_insert_with(|| Camera::of(frame, scene));
        Shot::take(frame, scene, camera)
    }

    fn write_collection(&self, folder: &mut ResultFolder) -> Result<(), OutputError> {
        if !self.has_files {
            return Ok(());
        }
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
        folder.write(COLLECTION, text.as_bytes())
    }
}

/// Names of all files that the frames of a scene can have: one more than it asks for, of a run that stops early.
pub(super) fn names(scene: &Scene) -> Vec<String> {
    if scene.output.frames == 0 {
        return vec![];
    }
    let numbers = 0..=scene.output.frames;
    let files = numbers.flat_map(|number| ["frame", "projectile"].map(|name| file(name, number)));
    files.chain([COLLECTION.to_owned()]).collect()
}

/// Path of a frame's file from the folder of the run.
fn file(name: &str, number: usize) -> String {
    format!("frames/{name}_{number:05}.vtu")
}
