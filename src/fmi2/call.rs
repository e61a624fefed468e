//! Error of a refused call, and its status.

use super::envelope::SnapshotError;
use super::lifecycle::{CallGroup, LifecyclePhase};
use super::manifest::ManifestError;
use super::memory::MemoryShortage;
use super::status::CallStatus;
use super::table::Kind;
use crate::output::OutputError;
use crate::scene::SceneError;
use crate::simulation::BuildError;

/// Limit of the characters of a number without exponent: all digits of a double with sign and point.
const MOST_DIGITS: usize = 20;

/// Error of a call that was not carried out. The instance is unchanged, except after an incomplete step.
///
/// A failure to write files during a run is no error: the call succeeds with a warning.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CallError {
    /// Call out of order.
    #[error("{function} is not allowed now ({phase}); it is allowed in: {allowed}")]
    OutOfOrder {
        /// Name of the C function.
        function: &'static str,
        /// Current phase of the instance.
        phase: String,
        /// Phases in which the call is allowed.
        allowed: String,
    },
    /// Null pointer.
    #[error("{function}: argument {argument} is a null pointer")]
    NullPointer {
        /// Name of the C function.
        function: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// Text outside UTF-8.
    #[error("{function}: argument {argument} is not UTF-8 text")]
    NotText {
        /// Name of the C function.
        function: &'static str,
        /// Name of the argument.
        argument: &'static str,
    },
    /// Value reference without a variable of the type.
    #[error("value reference {reference}: there is no {kind} variable with it; see modelDescription.xml of this FMU")]
    UnknownReference {
        /// Value reference.
        reference: u32,
        /// Requested type.
        kind: &'static str,
    },
    /// Variable that cannot be set, at present or ever.
    #[error("{name} cannot be set {when}: {remedy}")]
    NotSettable {
        /// Name of the variable.
        name: String,
        /// Time of the attempt.
        when: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// Variable of a missing fragment.
    #[error("{name}: there is no such fragment; [[fragment]] tables in the scene: {there}")]
    NoBody {
        /// Name of the variable.
        name: String,
        /// Number of fragments in the scene.
        there: usize,
    },
    /// Variable of a missing sensor.
    #[error("{name}: there is no such sensor; [[sensor]] tables in the scene: {there}")]
    NoSensor {
        /// Name of the variable.
        name: String,
        /// Number of sensors in the scene.
        there: usize,
    },
    /// Input of another scene that the FMU lacks.
    #[error(
        "scene {path}: it needs the input {name}, which this FMU lacks; gelfmu pack '{path}' makes one that has it"
    )]
    MissingInput {
        /// Name of the variable.
        name: String,
        /// Path of the scene.
        path: String,
    },
    /// Value outside its domain.
    #[error("{name} = {found}: expected {expected}")]
    Value {
        /// Name of the variable or argument.
        name: String,
        /// Given value.
        found: String,
        /// Allowed values.
        expected: String,
    },
    /// Foreign or changed resources of the archive.
    #[error("{0}")]
    Resources(#[from] ManifestError),
    /// Missing scene.
    #[error("there is no scene: {reason}. Set the parameter `scene` to the absolute path of a scene file")]
    NoScene {
        /// Reason.
        reason: String,
    },
    /// Invalid scene.
    #[error("scene {origin}: {error}")]
    Scene {
        /// Origin of the text.
        origin: String,
        /// Fault of the scene.
        error: Box<SceneError>,
    },
    /// Valid scene that cannot be built.
    #[error("scene {origin}: {error}")]
    Build {
        /// Origin of the text.
        origin: String,
        /// Error of the build.
        error: BuildError,
    },
    /// Incomplete step: the simulation is frozen at its last consistent tick.
    #[error("the simulation has stopped (times since its start): {reason}")]
    Stopped {
        /// Diagnosis, with the time since the start.
        reason: String,
    },
    /// Unusable state.
    #[error("{0}")]
    State(#[from] SnapshotError),
    /// Error of writing files.
    #[error("output_directory: {0}, or leave output_directory empty")]
    Output(#[from] OutputError),
    /// Shortage of memory.
    #[error("{0}")]
    Memory(#[from] MemoryShortage),
    /// Request beyond a synchronous slave.
    #[error("{what} is not available: no step runs asynchronously")]
    NotAvailable {
        /// Name of the requested function.
        what: &'static str,
    },
    /// Instance lost in an earlier panic.
    #[error("{function}: the instance was lost in an earlier call; free it")]
    Lost {
        /// Name of the C function.
        function: &'static str,
    },
}

impl CallError {
    /// Returns the status of the call.
    #[must_use]
    pub fn status(&self) -> CallStatus {
        match self {
            Self::Stopped { .. } | Self::NotAvailable { .. } => CallStatus::Discard,
            Self::Lost { .. } => CallStatus::Fatal,
            Self::OutOfOrder { .. }
            | Self::NullPointer { .. }
            | Self::NotText { .. }
            | Self::UnknownReference { .. }
            | Self::NotSettable { .. }
            | Self::NoBody { .. }
            | Self::NoSensor { .. }
            | Self::MissingInput { .. }
            | Self::Value { .. }
            | Self::Resources(_)
            | Self::NoScene { .. }
            | Self::Scene { .. }
            | Self::Build { .. }
            | Self::State(_)
            | Self::Memory(_)
            | Self::Output(_) => CallStatus::Error,
        }
    }

    pub(super) fn out_of_order(function: &'static str, call: CallGroup, phase: LifecyclePhase) -> Self {
        let allowed: Vec<String> = call.phases().iter().map(LifecyclePhase::to_string).collect();
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
        Self::Value { name: name.into(), found: shorten_number(found.to_string()), expected: expected.into() }
    }
}

/// Shortens a number of more than [`MOST_DIGITS`] characters, such as 10³⁰⁰ with all zeros, to a form with exponent.
fn shorten_number(text: String) -> String {
    match text.parse::<f64>() {
        Ok(value) if text.len() > MOST_DIGITS => format!("{value:e}"),
        Ok(_) | Err(_) => text,
    }
}

/// Formats a number in its shortest digits, with an exponent if long.
pub(super) fn format_number(value: f64) -> String {
    shorten_number(value.to_string())
}
