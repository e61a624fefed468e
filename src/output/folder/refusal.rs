//! Reasons to refuse a folder, with remedies.

use super::manifest::MANIFEST;
use std::fmt;
use std::path::PathBuf;

/// Reason to refuse a folder. Displays as `found …, expected …`.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum FolderRefusal {
    /// Another run writes into the folder.
    Busy,
    /// The folder has files and no manifest, therefore an unknown owner.
    Foreign {
        /// Name of a file.
        file: String,
    },
    /// The folder has results of a release without manifests.
    Unlisted {
        /// Name of a file.
        file: String,
    },
    /// The folder has results of gelfmu without permission to replace them.
    Occupied,
    /// The folder has results of another command.
    OtherCommand {
        /// Name of the other command.
        command: String,
    },
    /// An unlisted file or folder has the name of a result.
    InTheWay {
        /// Path of the file.
        file: PathBuf,
    },
    /// An input file of the run is among its output files.
    Input {
        /// Path of the file.
        file: PathBuf,
    },
    /// The folder has no results of the command.
    NoResults {
        /// Name of the command.
        command: String,
    },
    /// The manifest is foreign or was changed.
    Damaged {
        /// Number of the first invalid line.
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
            Self::NoResults { command } => {
                write!(
                    f,
                    "found no results of gelfmu {command}, expected a folder that gelfmu {command} or an FMU has written"
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
