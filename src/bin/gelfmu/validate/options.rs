//! Options of `gelfmu validate`.

use crate::option_values::parse_jobs;
use clap::Args;
use std::path::PathBuf;

/// Options of `gelfmu validate`.
#[derive(Debug, Args)]
pub struct ValidateOptions {
    /// Run the shots of these names only, e.g. 9mm-fmj-350,45acp-fmj-869
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Run the cases of this level only: draft, coarse or standard
    #[arg(long, value_name = "LEVEL", value_parser = ["draft", "coarse", "standard"])]
    pub level: Option<String>,
    /// Number of concurrent processes, each of one thread
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = parse_jobs, allow_hyphen_values = true)]
    pub jobs: usize,
    /// Folder for the table, the picture and the rows
    #[arg(long, value_name = "DIR", default_value = "gelfmu-out/validation")]
    pub out: PathBuf,
    /// Repeat every run, also the kept ones; files of other commands in the folder stay
    #[arg(long)]
    pub afresh: bool,
}
