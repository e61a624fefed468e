//! The FMI, and input without sense: what an importer calls.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#![allow(unsafe_code, reason = "the interface is one of pointers")]

#[path = "../fmi2/host.rs"]
#[allow(dead_code, reason = "the tests of the interface use more of it")]
mod host;
#[path = "../hostile/random.rs"]
#[allow(dead_code, reason = "hostile use draws more")]
mod random;

mod drawn;
mod extremes;
mod fmi2;
mod hostile;
