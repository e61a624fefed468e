//! Frames: the mesh at equally spaced times, as VTK files for ParaView, of which the report is made, too.

use super::body;
use super::bounds::AxisAlignedBox;
use super::files::OutputError;
use super::folder::ResultFolder;
use super::vtu;
use crate::scene::Scene;
use crate::simulation::MeshFrame;
use std::fmt::Write;

/// Name of the collection file that ParaView opens.
const COLLECTION: &str = "series.pvd";

/// Frame on disk.
#[derive(Debug)]
struct WrittenFrame {
    time: f64,
    /// Index of the next due time.
    next_due: usize,
}

/// Number of times at which the cavity is evaluated in a run without frames.
const CAVITY_TIMES: usize = 41;

/// Frame series of a run.
#[derive(Debug)]
pub(super) struct FrameSeries {
    due: Vec<f64>,
    tolerance: f64,
    /// True if frames are written; otherwise they serve the cavity alone.
    has_files: bool,
    written: Vec<WrittenFrame>,
}

impl FrameSeries {
    /// Creates a series without frames; the first frame is due at once.
    pub(super) fn create(folder: &mut ResultFolder, scene: &Scene) -> Result<Self, OutputError> {
        let has_files = scene.output.frames > 0;
        let (n, end) = (if has_files { scene.output.frames } else { CAVITY_TIMES }, scene.scene.end_time);
        let due = (0..n).map(|i| end * i as f64 / n.saturating_sub(1).max(1) as f64).collect();
        let series = Self {
            due,
            // A communication point is a sum of steps and may miss a due time by round-off.
            tolerance: 1e-9 * end,
            has_files,
            written: Vec::new(),
        };
        series.write_collection(folder)?;
        Ok(series)
    }

    /// Returns true if frames are written.
    pub(super) fn has_files(&self) -> bool {
        self.has_files
    }

    /// Returns true if a frame is due at `time`, s.
    pub(super) fn is_due(&self, time: f64) -> bool {
        self.due.get(self.next_due()).is_some_and(|due| time + self.tolerance >= *due)
    }

    /// Writes a due frame.
    pub(super) fn append(
        &mut self,
        frame: &MeshFrame,
        scene: &Scene,
        folder: &mut ResultFolder,
    ) -> Result<(), OutputError> {
        let next_due = self.due.partition_point(|due| *due <= frame.time + self.tolerance);
        self.write_files(frame, scene, folder)?;
        self.written.push(WrittenFrame { time: frame.time, next_due });
        self.write_collection(folder)
    }

    /// Writes the last frame of a run that stops early, unless frames are off or the frame is already written.
    pub(super) fn append_last(
        &mut self,
        frame: &MeshFrame,
        scene: &Scene,
        folder: &mut ResultFolder,
    ) -> Result<(), OutputError> {
        if !self.has_files || self.written.last().is_some_and(|last| last.time >= frame.time) {
            return Ok(());
        }
        self.write_files(frame, scene, folder)?;
        self.written.push(WrittenFrame { time: frame.time, next_due: self.next_due() });
        self.write_collection(folder)
    }

    /// Drops the frames after `time`, s.
    pub(super) fn rewind(&mut self, time: f64, folder: &mut ResultFolder) -> Result<(), OutputError> {
        let kept = self.written.partition_point(|written| written.time <= time);
        for number in kept..self.written.len() {
            folder.remove(&frame_file("frame", number))?;
            folder.remove(&frame_file("projectile", number))?;
        }
        self.written.truncate(kept);
        self.write_collection(folder)
    }

    fn next_due(&self) -> usize {
        self.written.last().map_or(0, |written| written.next_due)
    }

    fn write_files(&self, frame: &MeshFrame, scene: &Scene, folder: &mut ResultFolder) -> Result<(), OutputError> {
        if !self.has_files {
            return Ok(());
        }
        let number = self.written.len();
        let scenery = AxisAlignedBox::around(frame.points.iter().copied());
        let solids = body::body_surfaces(scene, frame, &scenery);
        folder.write(&frame_file("frame", number), &vtu::gel_file(frame))?;
        let surface = vtu::bodies_file(&solids, frame.time);
        folder.write(&frame_file("projectile", number), &surface)
    }

    fn write_collection(&self, folder: &mut ResultFolder) -> Result<(), OutputError> {
        if !self.has_files {
            return Ok(());
        }
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (number, WrittenFrame { time, .. }) in self.written.iter().enumerate() {
            for (part, name) in ["frame", "projectile"].iter().enumerate() {
                let file = frame_file(name, number);
                writeln!(text, "<DataSet timestep=\"{time:e}\" part=\"{part}\" file=\"{file}\"/>")
                    .expect("a string grows");
            }
        }
        text += "</Collection>\n</VTKFile>\n";
        folder.write(COLLECTION, text.as_bytes())
    }
}

/// Returns the names of all files of the frame series: one frame more than requested, for a run that stops early.
pub(super) fn frame_file_names(scene: &Scene) -> Vec<String> {
    if scene.output.frames == 0 {
        return vec![];
    }
    let numbers = 0..=scene.output.frames;
    let files = numbers.flat_map(|number| ["frame", "projectile"].map(|name| frame_file(name, number)));
    files.chain([COLLECTION.to_owned()]).collect()
}

/// Returns the path of a frame file relative to the folder of the run.
pub(super) fn frame_file(name: &str, number: usize) -> String {
    format!("frames/{name}_{number:05}.vtu")
}
