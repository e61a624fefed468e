//! The command line.

use crate::completions::SceneNameParser;
use crate::trade::Importer;
use ballistic_gel::fmi2;
use ballistic_gel::scene::{Fidelity, Override};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use std::path::PathBuf;

/// A block of ballistic gelatin hit by a rigid projectile, packed as an FMI 2.0 co-simulation FMU.
///
/// Without a subcommand the built-in scene `fbi-bb` is run.
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
    /// Fit the strength of a gel to the depth at which a projectile stopped in it, and print the lines of the scene
    ///
    /// The scene is run with one strength after the other until its projectile stops at the measured depth to 0.1 %; only
    /// gel.strength.yield_stress is changed. Ctrl-C keeps the best strength so far.
    Calibrate(CalibrateOptions),
    /// Check a scene, and print what it models and what is switched off
    ///
    /// The scene is built, so that what cannot be run is refused here, too.
    Check(CheckOptions),
    /// Measure how fast this machine steps a gel, and print tables
    Bench(BenchOptions),
    /// Write the FMU for this host
    Pack(PackOptions),
    /// Draw the steps of an exchange of the mesh: run a planar or axisymmetric scene until its mesh is worn, and write a page of
    /// pictures
    ///
    /// The pictures are those of figure 6 of the paper, of the whole gel and of what is around the worst element: the worn mesh,
    /// the bends of the fields and the target sizes, the quadtree, the Delaunay triangulation of its points, the signed
    /// distance, the gel immersed and cut out, and the velocity on the old mesh and on the new ones of both methods.
    /// `index.html` shows them in order with their figures.
    RemeshDemo(DemoOptions),
    /// Measure what accuracy costs: run a scene with every knob that buys speed turned both ways, and print error against cost
    ///
    /// Errors are those of the motion of the projectile, relative to the limit of refinement of the same scene, and are refused where
    /// that is not monotone. Table, CSV and picture are written into the folder, and finished runs are kept there: the same
    /// command goes on where it was interrupted.
    Trade(TradeOptions),
    /// Run one scene of a ladder and print its row
    #[command(hide = true)]
    TradeRow(RowOptions),
    /// List the built-in scenes, or print one
    Scenes {
        /// Name of the scene to print
        #[arg(value_parser = SceneNameParser, hide_possible_values = true)]
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
pub const DEFAULT_SCENE: &str = "fbi-bb";

/// Which scene to check.
#[derive(Debug, Args)]
pub struct CheckOptions {
    /// Name of a built-in scene, or path of a scene file
    #[arg(value_parser = SceneNameParser, hide_possible_values = true)]
    pub scene: String,
    /// Replace a value of the scene, such as mesh.size=2e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
}

/// How to run a scene.
#[derive(Debug, Default, Args)]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of the command line")]
pub struct RunOptions {
    /// Name of a built-in scene, or path of a scene file (`fbi-bb` if absent)
    #[arg(value_parser = SceneNameParser, hide_possible_values = true)]
    pub scene: Option<String>,
    /// Replace a value of the scene, such as mesh.size=2e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    #[command(flatten)]
    pub level: LevelOptions,
    /// Folder for the results (`gelfmu-out/SCENE` if absent)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the results of an earlier run in the folder; other files in it stay
    #[arg(long)]
    pub force: bool,
    /// Write no frames and no pictures: the same as --set output.frames=0
    #[arg(long)]
    pub no_frames: bool,
    /// Write no report.html: the same as --set output.report=false
    #[arg(long)]
    pub no_report: bool,
    /// Communication step, s (`scene.communication_step` if absent)
    #[arg(long, value_name = "H", value_parser = positive, allow_hyphen_values = true)]
    pub step: Option<f64>,
    /// Step the library without the FMU: same digest
    #[arg(long)]
    pub direct: bool,
    /// Threads, 0 for all cores; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
}

/// How accurate a run is to be.
#[derive(Debug, Default, Args)]
pub struct LevelOptions {
    /// Level of the scene: draft, coarse, standard, fine or reference, or 0 to 4; --set is stronger
    #[arg(long, value_name = "LEVEL", value_parser = levels())]
    pub fidelity: Option<Fidelity>,
    /// Cheapest level whose error is known to be no greater, such as 2%
    #[arg(long, value_name = "PERCENT", conflicts_with = "fidelity", value_parser = accuracy, allow_hyphen_values = true)]
    pub accuracy: Option<f64>,
}

/// What was measured, and in which scene.
#[derive(Debug, Args)]
pub struct CalibrateOptions {
    /// Name of a built-in scene, or path of a scene file, with a gel.strength to begin with (`fbi-bb` if absent)
    #[arg(value_parser = SceneNameParser, hide_possible_values = true)]
    pub scene: Option<String>,
    /// Depth at which the projectile stopped, from the entry surface to its foremost point, m
    #[arg(long, value_name = "DEPTH", default_value_t = 85e-3, value_parser = length, allow_hyphen_values = true)]
    pub depth: f64,
    /// Speed of the projectile along -z, m/s (projectile.velocity if absent)
    #[arg(long, value_name = "SPEED", value_parser = speed, allow_hyphen_values = true)]
    pub speed: Option<f64>,
    /// Replace a value of the scene, such as mesh.size=0.4e-3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Threads, 0 for all cores; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
}

/// Name of the scene whose mesh is exchanged if none is named.
pub const DEMO_SCENE: &str = "ball-square";

/// Which exchange of the mesh to draw.
#[derive(Debug, Args)]
pub struct DemoOptions {
    /// Name of a built-in scene, or path of a scene file (`ball-square` if absent); without a `remesh` table it is given
    /// remesh.quality=0.05 and remesh.compression=0
    #[arg(value_parser = SceneNameParser, hide_possible_values = true)]
    pub scene: Option<String>,
    /// Exchange the mesh at this time, s, worn or not, and draw that (the first exchange if absent)
    #[arg(long, value_name = "TIME", value_parser = positive, allow_hyphen_values = true)]
    pub at: Option<f64>,
    /// Replace a value of the scene, such as projectile.velocity=[0,0,-30]; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Folder for the pictures (`gelfmu-out/SCENE-remesh` if absent)
    #[arg(long, visible_alias = "output", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the pictures of an earlier run of this command in the folder
    #[arg(long)]
    pub force: bool,
    /// Threads, 0 for all cores; results do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
}

/// What to measure.
#[derive(Debug, Args)]
pub struct BenchOptions {
    /// Small meshes and short measurements: seconds instead of minutes
    #[arg(long)]
    pub quick: bool,
    /// Threads to compare with one, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = threads, allow_hyphen_values = true)]
    pub threads: usize,
    /// About how many elements the meshes have, such as 26000,165000,1000000 (the default; 7000 if quick)
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = elements, allow_hyphen_values = true)]
    pub elements: Vec<usize>,
    /// Measure elements of this kind alone, in the sections that tell them apart
    #[arg(long, value_name = "KIND", value_enum)]
    pub element: Option<ElementName>,
    /// Measure this section alone; may be repeated
    #[arg(long, value_name = "NAME", value_enum)]
    pub only: Vec<SectionName>,
}

/// Kinds of elements, named as `mesh.element` in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ElementName {
    /// Each triangle or tetrahedron by itself
    Plain,
    /// Pairs of triangles, groups of four tetrahedra
    Patch,
}

impl ElementName {
    /// As in a scene.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Patch => "patch",
        }
    }

    /// Whether elements share their volume change.
    pub fn is_patched(self) -> bool {
        self == Self::Patch
    }
}

/// What can be measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SectionName {
    /// Bytes per element
    Memory,
    /// What memory gives
    Bandwidth,
    /// Element updates per second of each kernel
    Kernels,
    /// Where the time of a step goes
    Phases,
    /// The whole step with contact, on one and more threads
    Steps,
    /// Bins, queue and one global stable step
    Schedules,
    /// How evenly the work divides into 2 to 64 parts
    Partitions,
    /// Calls of the packed FMU
    Calls,
}

impl SectionName {
    /// Its name on the command line and in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Bandwidth => "bandwidth",
            Self::Kernels => "kernels",
            Self::Phases => "phases",
            Self::Steps => "steps",
            Self::Schedules => "schedules",
            Self::Partitions => "partitions",
            Self::Calls => "calls",
        }
    }

    /// What its numbers are.
    pub fn about(self) -> &'static str {
        match self {
            Self::Memory => {
                "bytes per element, as the engine counts them and as the resident set of a process of its own grows while a gel \
                 is built and first stepped"
            }
            Self::Bandwidth => {
                "a = b + s c over arrays that no cache holds, 24 bytes an item (STREAM triad), wall time"
            }
            Self::Kernels => {
                "element updates of one thread: a run of elements again and again, its nodes in cache; and all runs with their \
                 nodes loaded and what they give kept, as the engine does. Bytes are those of the layout, to and from memory"
            }
            Self::Phases => {
                "where the time of a step of one thread goes, ns of CPU time per element update: each column but the first is \
                 the time of a part run by itself, or the difference of two; waiting is what nodes of its own save each \
                 element, contact what the step costs more than that of the same gel without the ball"
            }
            Self::Steps => {
                "the whole step of sphere-block in mid-contact, all of the gel moving (it is given 0.01 m/s), the same steps from \
                 the same state again and again, by each number of threads in turn; cores \
                 are free if no thread waits for one: then a step takes the CPU time of the caller and of the busiest thread"
            }
            Self::Schedules => {
                "sphere-block and its graded meshes from the first touch on, one thread, each schedule at 0.8 of the stable step; \
                 the last column is relative to what one step of the assembled system would cost if nothing were at rest"
            }
            Self::Partitions => {
                "strong scaling on paper: updates per second of each run of elements in contact, all of the gel moving, divided \
                 into contiguous parts; a node is shared if it belongs to more than one part"
            }
            Self::Calls => "calls through the packed FMU, as an importer makes them, one thread",
        }
    }
}

/// Whose curve to measure.
#[derive(Debug, Args)]
pub struct TradeOptions {
    /// Name of a built-in scene, or path of a scene file
    #[arg(value_parser = SceneNameParser, hide_possible_values = true)]
    pub scene: String,
    /// Replace a value of the scene in every run, such as remesh.quality=0.3; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Turn these knobs alone, beside the mesh, such as cfl,element
    #[arg(long, value_name = "KNOB,...", value_delimiter = ',')]
    pub only: Vec<String>,
    /// How often all edges are refined by √2 beyond those of the scene
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=6))]
    pub finer: u32,
    /// Processes at once, each of one thread
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = jobs, allow_hyphen_values = true)]
    pub jobs: usize,
    /// Folder for the curve and its runs (`gelfmu-out/SCENE-trade` if absent)
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Draw the runs of other codes beside ours: a CSV file with the columns run, cpu_seconds and some of those of trade.csv, such
    /// as peak_depth
    #[arg(long, value_name = "FILE")]
    pub with: Option<PathBuf>,
    /// Measure what each option that the scene leaves out costs when it is on, and when it is off, instead of the curve
    #[arg(long, conflicts_with_all = ["only", "with", "finer"])]
    pub options: bool,
    /// Make every run again, also those that are kept in the folder; files that this command has not made stay
    #[arg(long)]
    pub afresh: bool,
}

/// One run of a ladder.
#[derive(Debug, Args)]
pub struct RowOptions {
    /// Path of the scene file
    pub scene: PathBuf,
    /// Folder to which the names of its files are relative
    #[arg(long, value_name = "DIR", default_value = "")]
    pub folder: PathBuf,
    /// Who moves the projectile
    #[arg(long, value_enum, default_value_t)]
    pub importer: Importer,
    /// How often it is run; the least time counts
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub repeat: usize,
}

/// What to pack.
#[derive(Debug, Args)]
pub struct PackOptions {
    /// Name of a built-in scene, or path of a scene file (`fbi-bb` if absent)
    #[arg(value_name = "SCENE", value_parser = SceneNameParser, hide_possible_values = true)]
    pub named: Option<String>,
    /// Name or path of the scene, as an option
    #[arg(
        long,
        value_name = "SCENE",
        conflicts_with = "named",
        value_parser = SceneNameParser,
        hide_possible_values = true
    )]
    pub scene: Option<String>,
    /// Replace a value of the scene, such as coupling.mode=corrected; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Fragments with variables of their own (all of the scene if absent); the others move by themselves
    #[arg(long, value_name = "N")]
    pub fragments: Option<usize>,
    /// Sensors with variables of their own (all of the scene if absent)
    #[arg(long, value_name = "N")]
    pub sensors: Option<usize>,
    /// File to write
    #[arg(long, value_name = "FILE.fmu", default_value = "BallisticGel.fmu")]
    pub out: PathBuf,
}

/// Levels by name, which are completed, or by number.
fn levels() -> impl TypedValueParser<Value = Fidelity> {
    let numbered = Fidelity::ALL.iter().zip(["0", "1", "2", "3", "4"]);
    let levels = numbered.map(|(level, number)| PossibleValue::new(level.as_str()).alias(number));
    PossibleValuesParser::new(levels.collect::<Vec<_>>()).try_map(|text| text.parse::<Fidelity>())
}

fn positive(text: &str) -> Result<f64, String> {
    above_zero(text, "time, s")
}

fn length(text: &str) -> Result<f64, String> {
    above_zero(text, "length, m")
}

fn speed(text: &str) -> Result<f64, String> {
    above_zero(text, "speed, m/s")
}

fn above_zero(text: &str, what: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("expected a positive {what}")),
    }
}

/// Elements of the smallest and the largest mesh to measure: cells of a fifth of the height of the block; what a process can hold.
const ELEMENTS: (usize, usize) = (7000, 20_000_000);

fn elements(text: &str) -> Result<usize, String> {
    let (least, most) = ELEMENTS;
    match text.parse::<usize>() {
        Ok(n) if (least..=most).contains(&n) => Ok(n),
        _ => Err(format!("expected a number of elements from {least} to {most}")),
    }
}

/// A part of one.
fn accuracy(text: &str) -> Result<f64, String> {
    above_zero(text.trim().trim_end_matches('%').trim_end(), "error in percent, such as 2%")
        .map(|percent| 0.01 * percent)
}

fn jobs(text: &str) -> Result<usize, String> {
    let most = fmi2::most_threads();
    match text.parse::<usize>() {
        Ok(n) if (1..=most).contains(&n) => Ok(n),
        _ => Err(format!("expected a number of processes from 1 to {most}")),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    let most = fmi2::most_threads();
    match text.parse::<usize>() {
        Ok(n) if n <= most => Ok(n),
        _ => Err(format!("expected 0 for all cores, or a number of threads up to {most}")),
    }
}
