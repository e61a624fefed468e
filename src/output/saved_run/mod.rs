//! Results of a finished run, read back from its folder: tables, summary and frames.

mod exit;
mod frame;
mod grid;
mod shot;
mod table;

pub use exit::{ExitedBody, ExitedRun, exited_run};
pub(super) use shot::{SavedShot, ShotPoint, layer_passages};

use super::SCENE;
use super::folder::read_scene_digest;
use super::history::{self, HistoryRow};
use super::reading::{MOST_RESULT_BYTES, MOST_TABLE_BYTES, read_limited, read_limited_text};
use super::scene_digest::scene_digest;
use super::summary::{RunSummary, SUMMARY_FORMAT};
use crate::scene::Scene;
use crate::simulation::MeshFrame;
use serde::Deserialize;
use std::io;
use std::path::{Path, PathBuf};
use table::CsvTable;

/// Error of reading the results of a run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SavedRunError {
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file has another content than gelfmu writes.
    #[error("{}: found {found}, expected {expected}", path.display())]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// Content.
        found: String,
        /// Remedy.
        expected: &'static str,
    },
}

/// Remedy of a damaged summary.
const WHOLE: &str = "the summary of a run of this release; run the scene again";

/// Keys of a summary of any format.
#[derive(Deserialize)]
struct SummaryHead {
    format: Option<u32>,
    version: Option<String>,
}

/// Folder with the results of a run of this scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct SavedRun<'a> {
    folder: &'a Path,
    scene: &'a Scene,
}

impl<'a> SavedRun<'a> {
    /// Opens a folder; another scene than that of its results is refused.
    pub(super) fn open(folder: &'a Path, scene: &'a Scene) -> Result<Self, SavedRunError> {
        let own = read_scene_digest(folder)
            .map_err(|source| SavedRunError::Read { path: folder.join("gelfmu.jsonl"), source })?;
        if own.is_some_and(|own| own != scene_digest(scene)) {
            return Err(SavedRunError::Content {
                path: folder.join(SCENE),
                found: format!("another scene ({}) than that of these results", scene.scene.name),
                expected: "the file as the run wrote it; put it back, or run the scene into a folder of its own",
            });
        }
        Ok(Self { folder, scene })
    }

    /// Reads `summary.json`.
    pub(super) fn summary(&self) -> Result<RunSummary, SavedRunError> {
        let path = self.folder.join("summary.json");
        let content = |found, expected| SavedRunError::Content { path: path.clone(), found, expected };
        let text = read_text(&path, MOST_TABLE_BYTES)?;
        let head: SummaryHead = serde_json::from_str(&text).map_err(|error| content(error.to_string(), WHOLE))?;
        if head.format != Some(SUMMARY_FORMAT) {
            let format = head.format.map_or("no format".to_owned(), |format| format!("format {format}"));
            let release = head.version.map_or(String::new(), |version| format!(", written by gelfmu {version}"));
            let own = format!("{format}{release}, in the place of format {SUMMARY_FORMAT}");
            return Err(content(own, "a run of this release: gelfmu run FOLDER/scene.toml --out ANOTHER"));
        }
        serde_json::from_str(&text).map_err(|error| content(error.to_string(), WHOLE))
    }

    /// Reads at most `limit` rows of `history.csv`, evenly spaced by number, the last row included.
    pub(super) fn history(&self, limit: usize) -> Result<Vec<HistoryRow>, SavedRunError> {
        let path = self.folder.join("history.csv");
        history::read_thinned(&path, self.scene, limit).map_err(|source| SavedRunError::Read { path, source })
    }

    /// Reads the tables of a shot; `None` for a run without them.
    pub(super) fn shot(&self, summary: &RunSummary) -> Result<Option<SavedShot>, SavedRunError> {
        SavedShot::read(self.folder, summary)
    }

    /// Returns the number of frames.
    pub(super) fn n_frames(&self) -> usize {
        (0..usize::MAX).take_while(|number| self.frame_path(*number).is_file()).count()
    }

    /// Reads the frames of these numbers one after the other, with the bodies of the history.
    pub(super) fn frames(
        &self,
        numbers: impl Iterator<Item = usize>,
    ) -> Result<impl Iterator<Item = Result<MeshFrame, SavedRunError>>, SavedRunError> {
        let (history, mut boundary) =
            (CsvTable::read(&self.folder.join("history.csv"))?, frame::KnownBoundary::default());
        Ok(numbers.map(move |number| {
            let path = self.frame_path(number);
            let bytes = read_limited(&path, MOST_RESULT_BYTES)
                .map_err(|source| SavedRunError::Read { path: path.clone(), source })?;
            let content = |found| SavedRunError::Content {
                path: path.clone(),
                found,
                expected: "a frame as gelfmu run writes it; run the scene again",
            };
            frame::read(&bytes, self.scene, &history, &mut boundary).map_err(content)
        }))
    }

    fn frame_path(&self, number: usize) -> PathBuf {
        self.folder.join(super::frames::frame_file("frame", number))
    }
}

fn read_text(path: &Path, most: u64) -> Result<String, SavedRunError> {
    read_limited_text(path, most).map_err(|source| SavedRunError::Read { path: path.to_path_buf(), source })
}
