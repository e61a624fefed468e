//! Command-line interface: subcommands, their options and the parsers of the values.

use crate::help_headings::{ACCURACY, COMPUTATION, GLOBAL, RESULTS};
use crate::new::NewOptions;
use crate::option_values::{
    PROJECTILE_NAME, SCENE_NAME, level_parser, parse_elements, parse_error, parse_length, parse_speed, parse_threads,
    parse_time,
};
use crate::output_choice::OutputChoice;
use crate::report_options::{MovieOptions, ReportFolderOptions, ReportOptions};
use crate::units_option::UnitsOptions;
use ballistic_gel::scene::{FidelityKind, Override};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;

/// Simulate a block of ballistic gelatin hit by a rigid projectile, and pack it as an FMI 2.0 co-simulation FMU.
///
/// Without a subcommand the built-in scene `fbi-bb` is run.
#[derive(Debug, Parser)]
#[command(name = "gelfmu", version, disable_help_flag = true, disable_version_flag = true)]
pub struct CommandLine {
    /// Print the result as JSON on standard output
    #[arg(long, global = true, help_heading = GLOBAL)]
    pub json: bool,
    /// Print no progress and no notes, only errors (and JSON, if asked for)
    #[arg(long, short, global = true, help_heading = GLOBAL)]
    pub quiet: bool,
    /// End as by SIGTERM when standard input ends, for a program that starts this one and may be killed
    #[arg(long, global = true, help_heading = GLOBAL)]
    pub end_with_input: bool,
    /// Colour the output always, never or on a terminal only; `NO_COLOR` in the environment turns `auto` off
    #[arg(
        long,
        visible_alias = "colour",
        global = true,
        value_enum,
        default_value_t = ColorChoice::Auto,
        value_name = "WHEN",
        help_heading = GLOBAL
    )]
    pub color: ColorChoice,
    /// Print help; -h is shorter, --help says more
    #[arg(long, short, global = true, action = ArgAction::Help, help_heading = GLOBAL)]
    pub help: Option<bool>,
    /// Print the version; --version with the libraries of the FMU
    #[arg(long, short = 'V', action = ArgAction::Version, help_heading = GLOBAL)]
    pub version: Option<bool>,
    /// Subcommand to carry out.
    #[command(subcommand)]
    pub command: Option<GelfmuCommand>,
}

/// Policy for coloured output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ColorChoice {
    /// Colour on a terminal only.
    Auto,
    /// Colour in files and pipes, too.
    Always,
    /// No colour.
    Never,
}

/// Subcommands of `gelfmu`.
#[derive(Debug, Subcommand)]
pub enum GelfmuCommand {
    /// Run a scene through the packed FMU, as an importer would, and write a result folder with a report
    Run(RunOptions),
    /// Run the shots on standard input, each a line of JSON with a scene and a list of overrides
    ///
    /// A line has the keys `scene`, a built-in scene or a file, `text` in the place of that file, and `set`, overrides such
    /// as "mesh.size=2e-3". Each shot is answered by a line of JSON with index, status, reason and the figures of summary.json, in the order in
    /// which they end; no folder is written. The communication steps of a shot are at most 100, so that its figures by
    /// step and frame are coarser than those of `gelfmu run`. Made for the level `instant`.
    Batch(BatchOptions),
    /// Fit a gel to the depth at which a projectile rests, and print the lines of the scene
    ///
    /// The scene is run with one gel.strength_scale after the other, until the rest depth is the measured one to 0.1 %.
    /// Ctrl-C keeps the best value so far. Several parameters are fitted to several shots by the Python package.
    Calibrate(CalibrateOptions),
    /// Check a scene, and print the modelled physics and the physics switched off
    ///
    /// The scene is built, so a scene without a valid mesh is refused here, too.
    Check(CheckOptions),
    /// Measure the element updates per second of this machine, by threads, and print a table
    Bench(BenchOptions),
    /// Write the FMU of a scene, for every platform whose library is inside this gelfmu
    Pack(PackOptions),
    /// Make the report of a finished run from the files in its folder, or a page that compares several runs
    ///
    /// `gelfmu run` makes it at its end; an FMU with an output directory, and a run with --no-report, leave it to this
    /// command.
    Report(ReportFolderOptions),
    /// Make a film of a finished run: a GIF, or an MP4 with ffmpeg if it is installed, else the pictures as PNG files
    Movie(MovieOptions),
    /// Refuse the former command with that of the Python package
    #[command(hide = true)]
    Trade {
        /// Former options
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Refuse the former command with that of the Python package
    #[command(hide = true)]
    Validate {
        /// Former options
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Refuse the former command with where its pictures are
    #[command(hide = true)]
    RemeshDemo {
        /// Former options
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Write the scene of a shot: a projectile of the library, or one that has left the gel of a run, and a block of gel
    ///
    /// The scene is complete and commented: mesh and remeshing from the calibre, end time from an estimate of the path.
    New(NewOptions),
    /// List the projectiles of the library, or print one with the source of each value
    Projectiles {
        /// Name of the projectile to print
        #[arg(value_parser = PROJECTILE_NAME, hide_possible_values = true)]
        name: Option<String>,
        #[command(flatten)]
        units: UnitsOptions,
    },
    /// List the built-in scenes, or print one
    Scenes {
        /// Name of the scene to print
        #[arg(value_parser = SCENE_NAME, hide_possible_values = true)]
        name: Option<String>,
    },
    /// Print a JSON schema: of a scene file, for completion and validation in an editor, or of summary.json
    Schema {
        /// File that the schema describes; that of summary.json has meaning, unit and sampling of every figure
        #[arg(value_enum, default_value_t)]
        of: SchemaFile,
    },
    /// Write the manual pages: one of this program and one of each command
    ///
    /// `man -l DIR/gelfmu-run.1` shows one; in a folder man1 of the search path of man, such as
    /// ~/.local/share/man/man1, all are found by name.
    Man {
        /// Folder for the pages, which is made if it is absent; pages of the names are replaced
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Print a shell completion script
    Completions {
        /// Shell that reads the script
        shell: Shell,
    },
}

/// Name of the scene that is run and packed by default.
pub const DEFAULT_SCENE: &str = "fbi-bb";

/// Options of `gelfmu check`.
#[derive(Debug, Args)]
pub struct CheckOptions {
    /// Name of a built-in scene, or path of a scene file
    #[arg(value_parser = SCENE_NAME, hide_possible_values = true)]
    pub scene: String,
    /// Replace a value of the scene, e.g. mesh.size=2e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    #[command(flatten)]
    pub units: UnitsOptions,
}

/// Options of `gelfmu run`.
#[derive(Debug, Default, Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of the command line")]
pub struct RunOptions {
    /// Name of a built-in scene, or path of a scene file (`fbi-bb` if absent)
    #[arg(value_parser = SCENE_NAME, hide_possible_values = true)]
    pub scene: Option<String>,
    /// Replace a value of the scene, e.g. mesh.size=2e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    #[command(flatten)]
    pub units: UnitsOptions,
    #[command(flatten)]
    pub level: LevelOptions,
    /// Folder for the results (`gelfmu-out/SCENE` if absent, or `gelfmu-out/SCENE-LEVEL` at another level than its own)
    #[arg(long, value_name = "DIR", help_heading = RESULTS)]
    pub out: Option<PathBuf>,
    /// Replace the results of an earlier run in the folder; other files stay
    #[arg(long, help_heading = RESULTS)]
    pub force: bool,
    /// Write no frames and no pictures; short for --set output.frames=0
    #[arg(long, help_heading = RESULTS)]
    pub no_frames: bool,
    /// Write no report.html; short for --set output.report=false
    #[arg(long, help_heading = RESULTS)]
    pub no_report: bool,
    #[command(flatten)]
    pub report: ReportOptions,
    /// Communication step, s (`scene.communication_step` if absent)
    #[arg(
        long,
        value_name = "H",
        value_parser = parse_time,
        allow_hyphen_values = true,
        help_heading = COMPUTATION
    )]
    pub step: Option<f64>,
    /// Step the library directly, without the FMU; the results are bit-identical
    #[arg(long, help_heading = COMPUTATION)]
    pub direct: bool,
    /// Threads, 0 for all cores; results do not depend on the number
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = parse_threads,
        allow_hyphen_values = true,
        help_heading = COMPUTATION
    )]
    pub threads: usize,
}

/// Accuracy options of a run.
#[derive(Debug, Default, Args)]
pub struct LevelOptions {
    /// Accuracy level of the scene: draft, coarse, standard, fine, reference or instant, or 0 to 5; --set overrides its values
    #[arg(long, value_name = "LEVEL", value_parser = level_parser(), help_heading = ACCURACY)]
    pub fidelity: Option<FidelityKind>,
    /// Largest expected error, e.g. 2%; runs the cheapest level known to meet it
    #[arg(
        long,
        value_name = "PERCENT",
        conflicts_with = "fidelity",
        value_parser = parse_error,
        allow_hyphen_values = true,
        help_heading = ACCURACY
    )]
    pub accuracy: Option<f64>,
}

/// Options of `gelfmu batch`.
#[derive(Debug, Args)]
pub struct BatchOptions {
    /// Accuracy level of all shots (that of each scene if absent)
    #[arg(long, value_name = "LEVEL", value_parser = level_parser())]
    pub fidelity: Option<FidelityKind>,
    /// Shots at the same time, 0 for one on each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads, allow_hyphen_values = true)]
    pub threads: usize,
}

/// Options of `gelfmu calibrate`: the measured shots and their scenes.
#[derive(Debug, Args)]
pub struct CalibrateOptions {
    /// Name of a built-in scene, or path of a scene file, with the gel to begin with (`fbi-bb` if absent)
    #[arg(value_parser = SCENE_NAME, hide_possible_values = true)]
    pub scene: Option<String>,
    /// Rest depth of the projectile, from the entry surface to its foremost point, m
    #[arg(long, value_name = "DEPTH", default_value_t = 85e-3, value_parser = parse_length, allow_hyphen_values = true)]
    pub depth: f64,
    /// Speed of the projectile along -z, m/s (projectile.velocity if absent)
    #[arg(long, value_name = "SPEED", value_parser = parse_speed, allow_hyphen_values = true)]
    pub speed: Option<f64>,
    /// Difference of the depth that counts as none, e.g. 1%: on coarse remeshed cells depths scatter by more than 0.1 %
    #[arg(long, value_name = "PERCENT", default_value = "0.1%", value_parser = parse_error, allow_hyphen_values = true)]
    pub tolerance: f64,
    /// Former option, refused with the command of the Python package
    #[arg(long, hide = true, allow_hyphen_values = true)]
    pub shots: Option<String>,
    /// Former option, refused with the command of the Python package
    #[arg(long, hide = true, allow_hyphen_values = true)]
    pub sensitivity: Option<String>,
    /// Accuracy level of the runs (that of the scene if absent)
    #[arg(long, value_name = "LEVEL", value_parser = level_parser())]
    pub level: Option<FidelityKind>,
    /// Replace a value of the scene, e.g. mesh.size=0.4e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Threads, 0 for all cores; results do not depend on the number
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads, allow_hyphen_values = true)]
    pub threads: usize,
}

/// File that has a schema.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
pub enum SchemaFile {
    /// Scene file
    #[default]
    Scene,
    /// Figures of a run, summary.json
    Summary,
}

/// Options of `gelfmu bench`.
#[derive(Debug, Args)]
pub struct BenchOptions {
    /// Small mesh and few repetitions: a second instead of half a minute
    #[arg(long)]
    pub quick: bool,
    /// Number of threads to compare with one thread, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads, allow_hyphen_values = true)]
    pub threads: usize,
    /// Approximate number of elements (165000 if absent; 7000 if quick)
    #[arg(long, value_name = "N", value_parser = parse_elements, allow_hyphen_values = true)]
    pub elements: Option<usize>,
}

/// Options of `gelfmu pack`.
#[derive(Debug, Args)]
pub struct PackOptions {
    /// Name of a built-in scene, or path of a scene file (`fbi-bb` if absent)
    #[arg(value_name = "SCENE", value_parser = SCENE_NAME, hide_possible_values = true)]
    pub named: Option<String>,
    /// Name or path of the scene, as an option
    #[arg(
        long,
        value_name = "SCENE",
        conflicts_with = "named",
        value_parser = SCENE_NAME,
        hide_possible_values = true
    )]
    pub scene: Option<String>,
    /// Replace a value of the scene, e.g. coupling.mode=corrected; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Number of fragments with FMU variables (all of the scene if absent); the other fragments move by themselves
    #[arg(long, value_name = "N")]
    pub fragments: Option<usize>,
    /// Number of sensors with FMU variables (all of the scene if absent)
    #[arg(long, value_name = "N")]
    pub sensors: Option<usize>,
    /// Variables that are outputs (those of the coupling mode of the scene if absent); other results are locals
    #[arg(long, value_name = "SET", value_enum)]
    pub outputs: Option<OutputChoice>,
    /// Describe each body and sensor as a terminal, too (FMI 2.0.4); importers with FMI Library 3, among them PyFMI and
    /// the FMU Compliance Checker, report an error in such an archive
    #[arg(long)]
    pub terminals: bool,
    /// Platforms whose libraries are packed, e.g. linux64,win64 (all that are inside this gelfmu if absent)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub platforms: Vec<String>,
    /// File to write
    #[arg(long, value_name = "FILE.fmu", default_value = "BallisticGel.fmu")]
    pub out: PathBuf,
}
