//! Why a call was refused, and the one place that maps it to a status.

use super::lifecycle::{Call, Phase};
use super::manifest::ManifestError;
use super::memory::MemoryShortage;
use super::snapshot::SnapshotError;
use super::status::Status;
use super::table::Kind;
use crate::output::OutputError;
use crate::scene::SceneError;
use crate::simulation::BuildError;

/// Characters of the longest number that is printed without an exponent: all digits of a double with its sign and point.
const MOST_DIGITS: usize = 20;

/// A call that was not carried out. The instance is as it was before, but for a step that could not be completed.
///
/// Files that cannot be written once a run is going on are no such error: the call is done, with a warning.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CallError {
    /// Out of order.
    #[error("{function} is not allowed now ({phase}); it is allowed in: {allowed}")]
    OutOfOrder {
        /// The C function.
        function: &'static str,
        /// Where the instance is.
        phase: String,
        /// Where it could be called.
        allowed: String,
    },
    /// A pointer that must not be null.
    #[error("{function}: argument {argument} is a null pointer")]
    NullPointer {
        /// The C function.
        function: &'static str,
        /// Its argument.
        argument: &'static str,
    },
    /// Text that is not UTF-8.
    #[error("{function}: argument {argument} is not UTF-8 text")]
    NotText {
        /// The C function.
        function: &'static str,
        /// Its argument.
        argument: &'static str,
    },
    /// No variable of the type has the value reference.
    #[error("value reference {reference}: there is no {kind} variable with it; see modelDescription.xml of this FMU")]
    UnknownReference {
        /// What was asked for.
        reference: u32,
        /// The type asked for.
        kind: &'static str,
    },
    /// A variable that is not to be set, ever or now.
    #[error("{name} cannot be set {when}: {remedy}")]
    NotSettable {
        /// The variable.
        name: String,
        /// When it was tried.
        when: String,
        /// What can be set then.
        remedy: &'static str,
    },
    /// A variable of a fragment that the scene does not have.
    #[error("{name}: there is no such fragment; [[fragment]] tables in the scene: {there}")]
    NoBody {
        /// The variable.
        name: String,
        /// Fragments that there are.
        there: usize,
    },
    /// A variable of a sensor that the scene does not have.
    #[error("{name}: there is no such sensor; [[sensor]] tables in the scene: {there}")]
    NoSensor {
        /// The variable.
        name: String,
        /// Sensors that there are.
        there: usize,
    },
    /// A value outside its domain.
    #[error("{name} = {found}: expected {expected}")]
    Value {
        /// The variable or the argument.
        name: String,
        /// What was given.
        found: String,
        /// What may be given.
        expected: String,
    },
    /// Resources that are not those of the archive.
    #[error("{0}")]
    Resources(#[from] ManifestError),
    /// There is no scene to simulate.
    #[error("there is no scene: {reason}. Set the parameter `scene` to the absolute path of a scene file")]
    NoScene {
        /// Why not.
        reason: String,
    },
    /// The scene cannot be used.
    #[error("scene {origin}: {error}")]
    Scene {
        /// Where the text comes from.
        origin: String,
        /// What is wrong with it.
        error: Box<SceneError>,
    },
    /// The scene is good but cannot be built.
    #[error("scene {origin}: {error}")]
    Build {
        /// Where the text comes from.
        origin: String,
        /// Why not.
        error: BuildError,
    },
    /// The step could not be completed: the simulation is frozen at its last consistent tick.
    #[error("the simulation has stopped (times since its start): {reason}")]
    Stopped {
        /// Diagnosis, with the time since the start.
        reason: String,
    },
    /// A state that cannot be used.
    #[error("{0}")]
    State(#[from] SnapshotError),
    /// A file that cannot be written.
    #[error("output_directory: {0}, or leave output_directory empty")]
    Output(#[from] OutputError),
    /// More memory than is available.
    #[error("{0}")]
    Memory(#[from] MemoryShortage),
    /// Asked for what a synchronous slave has not.
    #[error("{what} is not available: no step runs asynchronously")]
    NotAvailable {
        /// What was asked for.
        what: &'static str,
    },
    /// An earlier panic.
    #[error("{function}: the instance was lost in an earlier call; free it")]
    Lost {
        /// The C function.
        function: &'static str,
    },
}

impl CallError {
    /// The status that the call returns.
    #[must_use]
    pub fn status(&self) -> Status {
        match self {
            Self::Stopped { .. } | Self::NotAvailable { .. } => Status::Discard,
            Self::Lost { .. } => Status::Fatal,
            Self::OutOfOrder { .. }
            | Self::NullPointer { .. }
            | Self::NotText { .. }
            | Self::UnknownReference { .. }
            | Self::NotSettable { .. }
            | Self::NoBody { .. }
            | Self::NoSensor { .. }
            | Self::Value { .. }
            | Self::Resources(_)
            | Self::NoScene { .. }
            | Self::Scene { .. }
            | Self::Build { .. }
            | Self::State(_)
            | Self::Memory(_)
            | Self::Output(_) => Status::Error,
        }
    }

    pub(super) fn out_of_order(function: &'static str, call: Call, phase: Phase) -> Self {
        let allowed: Vec<String> = call.phases().iter().map(Phase::to_string).collect();
        let allowed = if allowed.is_empty() { "no phase of this FMU".to_string() } else { allowed.join(", ") };
        Self::OutOfOrder { function, phase: phase.to_string(), allowed }
    }

    pub(super) fn unknown(reference: u32, kind: Kind) -> Self {
        let kind = match kind {
            Kind::Real => "Real",
            Kind::Integer | Kind::Enumeration => "Integer or Enumeration",
            Kind::Boolean => "Boolean",
            Kind::String => "String",
        };
        Self::UnknownReference { reference, kind }
    }

    #[allow(clippy::needless_pass_by_value)] // numbers and texts alike, made for this call
    pub(super) fn value(name: impl Into<String>, found: impl ToString, expected: impl Into<String>) -> Self {
        Self::Value { name: name.into(), found: legible(found.to_string()), expected: expected.into() }
    }
}

/// A text that is a number of more than [`MOST_DIGITS`] characters, such as 10³⁰⁰ with all of its zeros, as one with an exponent.
fn legible(text: String) -> String {
    match text.parse::<f64>() {
        Ok(value) if text.len() > MOST_DIGITS => format!("{value:e}"),
        Ok(_) | Err(_) => text,
    }
}

/// A number in words: in its shortest digits, with an exponent if these are many.
pub(super) fn number(value: f64) -> String {
    legible(value.to_string())
}
