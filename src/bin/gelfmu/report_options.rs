//! Options of the report and of the film of a run.

use crate::help_headings::RESULTS;
use crate::units_option::UnitsOptions;
use clap::Args;
use std::path::PathBuf;

/// Options of the report of a run.
#[derive(Debug, Default, Args)]
pub struct ReportOptions {
    /// Draw the measured curves of a laboratory over those of the run, and tell the residuals: a CSV file with a column
    /// of time or depth and columns such as velocity_m_per_s, cavity_diameter_mm, track_diameter_mm, yaw_deg or force_N
    #[arg(long, value_name = "FILE.csv", help_heading = RESULTS)]
    pub measured: Option<PathBuf>,
}

/// Options of `gelfmu report`.
#[derive(Debug, Args)]
pub struct ReportFolderOptions {
    /// Folder with the results of a run
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    #[command(flatten)]
    pub report: ReportOptions,
    #[command(flatten)]
    pub units: UnitsOptions,
}

/// Options of `gelfmu movie`.
#[derive(Debug, Args)]
pub struct MovieOptions {
    /// Folder with the results of a run with frames
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// File to write, .gif or .mp4 (DIR.gif if absent); an .mp4 without ffmpeg is a folder of this name with PNG files
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Pictures per second
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=60))]
    pub rate: u32,
    /// Replace an earlier film of the name
    #[arg(long)]
    pub force: bool,
}
