//! The 34 exported C functions of FMI 2.0 co-simulation.
//!
//! # Safety
//! The importer keeps the C side of the contract. A component comes from `fmi2Instantiate` and was not freed. Arrays
//! have the length passed with them, and strings end with a null byte. One thread at a time uses an instance. Null
//! pointers, text encoding and the origin of a state are checked here. Every function runs inside `guard`, which
//! stops a panic before it reaches C and computes in the default floating-point environment. Log lines are handed
//! over after the instance is released and the environment of the importer is restored, therefore a logger may call
//! back into the FMU.

#![allow(unsafe_code)]
#![allow(non_snake_case)] // the names are those of the standard
#![allow(clippy::missing_safety_doc)] // one contract for all of them, above
#![allow(clippy::too_many_arguments)] // the signatures are those of the standard

mod callbacks;
mod component;
mod environment;
#[cfg(feature = "cli")]
mod importer;
mod life;
mod pointers;
mod reserve;
mod states;
mod steps;
mod values;

pub use callbacks::{CallbackFunctions, LoggerCallback};
#[cfg(feature = "cli")]
pub use importer::{ImportError, LoadedFmu};
pub use life::*;
pub use reserve::MemoryReserve;
pub use states::*;
pub use steps::*;
pub use values::*;
