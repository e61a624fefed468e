//! Options of `gelfmu bench`.

use crate::option_values::parse_threads;
use clap::{Args, ValueEnum};

/// Options of `gelfmu bench`.
#[derive(Debug, Args)]
pub struct BenchOptions {
    /// Small meshes and short measurements: seconds instead of minutes
    #[arg(long)]
    pub quick: bool,
    /// Number of threads to compare with one thread, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = parse_threads, allow_hyphen_values = true)]
    pub threads: usize,
    /// Approximate numbers of elements of the meshes, e.g. 26000,165000,1000000 (the default; 7000 if quick)
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = parse_elements, allow_hyphen_values = true)]
    pub elements: Vec<usize>,
    /// Measure this kind of element only
    #[arg(long, value_name = "KIND", value_enum)]
    pub element: Option<ElementName>,
    /// Measure this section only; may be repeated
    #[arg(long, value_name = "NAME", value_enum)]
    pub only: Vec<SectionName>,
}

/// Kinds of elements, named like `mesh.element` in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ElementName {
    /// Single triangles or tetrahedra
    Plain,
    /// F-bar patches: pairs of triangles, groups of four tetrahedra
    Patch,
}

impl ElementName {
    /// Returns the value of `mesh.element` in a scene.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Patch => "patch",
        }
    }
}

/// Sections of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SectionName {
    /// Memory per element, bytes
    Memory,
    /// Whole step with contact, on one and more threads
    Steps,
    /// FMI calls of the packed FMU
    Calls,
}

impl SectionName {
    /// Returns the name on the command line and in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Steps => "steps",
            Self::Calls => "calls",
        }
    }

    /// Describes the figures of the section and their measurement.
    pub fn about(self) -> &'static str {
        match self {
            Self::Memory => {
                "bytes per element: counted by the engine, and growth of the resident set of a separate process while a gel is \
                 built and first stepped"
            }
            Self::Steps => {
                "the whole step of sphere-block in mid-contact, all of the gel moving (at 0.01 m/s): the same steps from the \
                 same state, repeated by each number of threads in turn; cores are free if no thread waits for a core: a \
                 step then takes the CPU time of the caller and of the busiest thread"
            }
            Self::Calls => "calls through the packed FMU, as an importer makes them, one thread",
        }
    }
}

/// Least and greatest number of elements of a benchmark mesh: cells of a fifth of the height of the block; the memory
/// of a process.
const ELEMENT_RANGE: (usize, usize) = (7000, 20_000_000);

fn parse_elements(text: &str) -> Result<usize, String> {
    let (least, most) = ELEMENT_RANGE;
    match text.parse::<usize>() {
        Ok(n) if (least..=most).contains(&n) => Ok(n),
        _ => Err(format!("expected a number of elements from {least} to {most}")),
    }
}
