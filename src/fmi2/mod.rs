//! FMI 2.0 co-simulation interface: exported functions, life cycle, variables, state.
//!
//! [`abi`] holds the 34 C functions and the only `unsafe` code of the crate. The other modules are safe Rust on plain
//! values; they log into a list that `abi` hands to the importer before it returns.

pub mod abi;
mod body;
mod call;
mod derivatives;
mod envelope;
mod inputs;
mod instance;
mod lifecycle;
mod logger;
mod manifest;
mod memory;
mod model;
mod parameters;
mod ports;
mod recording;
mod scalar;
mod snapshot;
mod status;
mod stepping;
mod table;
mod uri;
mod variables;

pub use abi::{CallbackFunctions, LoggerCallback, MemoryReserve};
#[cfg(feature = "cli")]
pub use abi::{ImportError, LoadedFmu};
pub use call::CallError;
pub use logger::CATEGORIES;
pub use manifest::{ArchiveContent, ArchiveManifest, ManifestError, SOURCE_STAMP};
pub use memory::{
    AmountOfMemory, AvailableMemory, MemoryLimit, MemoryPhase, MemoryShortage, RoomError, available_memory,
    reserve_for_building, reserve_for_step, reserve_memory,
};
pub use parameters::most_threads;
pub use ports::VariablePorts;
pub use recording::instance_folder_name;
pub use scalar::{ScalarVariable, table_of};
pub use status::CallStatus;
pub use table::{Causality, DisplayUnit, Item, Kind, OutputSet, Start, UNITS, Unit, VARIABLES, Variable};

/// Name of the model and of its library inside the archive.
pub const MODEL: &str = "BallisticGel";
