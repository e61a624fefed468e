//! The command line.

use ballistic_gel::fmi2;
use ballistic_gel::scene::Override;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;

/// A block of ballistic gelatin hit by a rigid projectile, packed as an FMI 2.0 co-simulation FMU.
///
/// Without a subcommand the built-in scene `sphere-block` is run.
#[derive(Debug, Parser)]
#[command(name = "gelfmu", version)]
pub struct Options {
    /// Print the result as JSON on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Print no progress and no notes, only errors (and JSON, if asked for)
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// When to use colour; `NO_COLOR` in the environment turns `auto` off
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto, value_name = "WHEN")]
    pub color: Color,
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// When to use colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene through the packed FMU, as an importer would, and write a folder to look at
    Run(RunOptions),
    /// Check a scene, and print what it models and what is switched off
    Check {
        /// Name of a built-in scene, or path of a scene file
        scene: String,
    },
    /// Write the FMU for this host
    Pack(PackOptions),
    /// List the built-in scenes, or print one
    Scenes {
        /// Name of the scene to print
        name: Option<String>,
    },
    /// Print the JSON schema of a scene file, with which editors complete and check
    Schema,
    /// Print a completion script
    Completions {
        /// The shell it is for
        shell: Shell,
    },
}

/// Name of the scene that is run and packed if none is named.
pub const DEFAULT_SCENE: &str = "sphere-block";

/// How to run a scene.
#[derive(Debug, Default, Args)]
pub struct RunOptions {
    /// Name of a built-in scene, or path of a scene file (`sphere-block` if absent)
    pub scene: Option<String>,
    /// Replace a value of the scene, such as mesh.size=2e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Folder for the results (`gelfmu-out/SCENE` if absent)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write into a folder that is not empty
    #[arg(long)]
    pub force: bool,
    /// Communication step, s (`scene.communication_step` if absent)
    #[arg(long, value_name = "H", value_parser = positive)]
    pub step: Option<f64>,
    /// Step the library without the FMU: same digest
    #[arg(long)]
    pub direct: bool,
    /// Threads, 0 for all cores; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads)]
    pub threads: usize,
}

/// What to pack.
#[derive(Debug, Args)]
pub struct PackOptions {
    /// Name of a built-in scene, or path of a scene file
    #[arg(long, default_value = DEFAULT_SCENE)]
    pub scene: String,
    /// Replace a value of the scene, such as coupling.mode=corrected; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Fragments with variables of their own (all of the scene if absent); the others move by themselves
    #[arg(long, value_name = "N")]
    pub fragments: Option<usize>,
    /// File to write
    #[arg(long, value_name = "FILE.fmu", default_value = "BallisticGel.fmu")]
    pub out: PathBuf,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("expected a positive time, s".to_owned()),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    let most = fmi2::most_threads();
    match text.parse::<usize>() {
        Ok(n) if n <= most => Ok(n),
        _ => Err(format!("expected 0 for all cores, or a number of threads up to {most}")),
    }
}
