//! Options of the report and of the film of a run.

use crate::failure::CommandError;
use crate::help_headings::RESULTS;
use crate::units_option::UnitsOptions;
use ballistic_gel::output::{LogoImage, MOST_LOGO_BYTES, ReportDate, ReportIdentity};
use clap::Args;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Options of the report of a run.
#[derive(Debug, Default, Args)]
pub struct ReportOptions {
    /// Draw the measured curves of a laboratory over those of the run, and tell the residuals: a CSV file with a column
    /// of time or depth and columns such as velocity_m_per_s, cavity_diameter_mm, track_diameter_mm, yaw_deg or force_N
    #[arg(long, value_name = "FILE.csv", help_heading = RESULTS)]
    pub measured: Option<PathBuf>,
    /// Case on the first page of the report and at the foot of its print
    #[arg(long, value_name = "TEXT")]
    pub case: Option<String>,
    /// Author on the first page of the report and at the foot of its print
    #[arg(long, value_name = "TEXT")]
    pub author: Option<String>,
    /// Logo on the first page of the report: a PNG, JPEG or SVG file of at most 1 MiB
    #[arg(long, value_name = "FILE")]
    pub logo: Option<PathBuf>,
}

impl ReportOptions {
    /// Returns the files that the options name.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.measured.clone().into_iter().chain(self.logo.clone())
    }

    /// Returns case, author and logo with the date of today; a file that is no image is refused.
    pub fn identity(&self) -> Result<ReportIdentity, CommandError> {
        let logo = self.logo.as_deref().map(read_logo).transpose()?;
        Ok(ReportIdentity {
            case: self.case.clone(),
            author: self.author.clone(),
            logo,
            date: Some(ReportDate::today()),
        })
    }
}

/// Reads the logo of `--logo`.
fn read_logo(path: &Path) -> Result<LogoImage, CommandError> {
    let refused = |found: &str| {
        CommandError::BadInput(format!(
            "--logo {}: found {found}, expected a PNG, JPEG or SVG file of at most 1 MiB; convert it, or make it smaller",
            path.display()
        ))
    };
    let unreadable = |error: io::Error| refused(&format!("no readable file ({error})"));
    // A pipe would never end, and is not opened.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(refused("a folder, a device or a pipe"));
    }
    let mut bytes = vec![];
    let file = File::open(path).map_err(unreadable)?;
    file.take(MOST_LOGO_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MOST_LOGO_BYTES {
        return Err(refused("a larger file"));
    }
    LogoImage::from_bytes(bytes).map_err(|found| refused(&found))
}

/// Options of `gelfmu report`.
#[derive(Debug, Args)]
pub struct ReportFolderOptions {
    /// Folder with the results of a run; several folders are compared on one page, which needs --out
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    #[command(flatten)]
    pub report: ReportOptions,
    /// File to write (report.html in the folder of one run if absent)
    #[arg(long, value_name = "FILE.html")]
    pub out: Option<PathBuf>,
    /// Replace an earlier file of --out
    #[arg(long)]
    pub force: bool,
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
