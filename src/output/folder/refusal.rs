//! Why a folder is not for a run, and what helps.

use super::MANIFEST;
use std::fmt;
use std::path::PathBuf;

/// Why a folder cannot be written into. Shows as `found …, expected …`.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum FolderRefusal {
    /// Another run writes there.
    Busy,
    /// The folder has files, and no manifest: it is somebody's own.
    Foreign {
        /// One of the files.
        file: String,
    },
    /// The folder has results of a release that wrote no manifest.
    Unlisted {
        /// One of them.
        file: String,
    },
    /// The folder has results of ours, and nobody has said that they may go.
    Occupied,
    /// The folder has results of another command.
    OtherCommand {
        /// That command.
        command: String,
    },
    /// A file or folder that is not ours has the name of a result.
    InTheWay {
        /// Its path.
        file: PathBuf,
    },
    /// A file that the run reads is among those that it would write.
    Input {
        /// Its path.
        file: PathBuf,
    },
    /// The manifest is none of ours, or was changed.
    Damaged {
        /// The first line that is none of a manifest.
        line: usize,
    },
}

const EMPTY: &str = "an empty or new folder";

impl fmt::Display for FolderRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => {
                write!(f, "found that another run is writing there, expected a folder that no other run uses")
            }
            Self::Foreign { file } => write!(
                f,
                "found a folder that is not empty and was not made by gelfmu (it has {file:?} and no {MANIFEST}), expected {EMPTY}"
            ),
            Self::Unlisted { file } => write!(
                f,
                "found {file:?} and no {MANIFEST}, as in a folder of an earlier release of gelfmu, expected {EMPTY}: remove this one \
                 yourself if nobody needs it"
            ),
            Self::Occupied => {
                write!(
                    f,
                    "found a folder that is not empty, with results of gelfmu, expected {EMPTY}, or --force to replace them"
                )
            }
            Self::OtherCommand { command } => {
                write!(
                    f,
                    "found results of gelfmu {command}, expected {EMPTY}: remove this one yourself if nobody needs it"
                )
            }
            Self::InTheWay { file } => write!(
                f,
                "found {}, which gelfmu has not made and which has the name of a result, expected {EMPTY}: or move the file away",
                file.display()
            ),
            Self::Input { file } => write!(
                f,
                "found {}, which is read, among the files that would be replaced, expected another folder",
                file.display()
            ),
            Self::Damaged { line } => {
                write!(f, "found a {MANIFEST} whose line {line} is none of a manifest of gelfmu, expected {EMPTY}")
            }
        }
    }
}
