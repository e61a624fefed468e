//! The life cycle: which call is allowed when (FMI 2.0.4, section 4.2.4).

use serde::{Deserialize, Serialize};
use std::fmt;

/// Where an instance is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Phase {
    /// Made, or reset.
    Instantiated,
    /// In initialization mode.
    Initialization,
    /// Between two steps.
    StepComplete,
    /// A step could not be completed: the simulation is frozen.
    StepFailed,
    /// Ended by the importer.
    Terminated,
    /// A panic was caught.
    Fatal,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initialization mode",
            Self::StepComplete => "step complete",
            Self::StepFailed => "step failed",
            Self::Terminated => "terminated",
            Self::Fatal => "lost after a panic",
        })
    }
}

/// A group of C functions that are allowed in the same phases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Call {
    /// `fmi2SetDebugLogging`.
    SetDebugLogging,
    /// `fmi2SetupExperiment`.
    SetupExperiment,
    /// `fmi2EnterInitializationMode`.
    EnterInitializationMode,
    /// `fmi2ExitInitializationMode`.
    ExitInitializationMode,
    /// `fmi2Terminate`.
    Terminate,
    /// `fmi2Reset`.
    Reset,
    /// `fmi2GetReal`, `…Integer`, `…Boolean`, `…String`.
    Get,
    /// `fmi2SetReal`, `…Integer`, `…Boolean`, `…String`.
    Set,
    /// The six functions of the FMU state.
    State,
    /// `fmi2GetDirectionalDerivative`.
    GetDirectionalDerivative,
    /// `fmi2SetRealInputDerivatives`.
    SetRealInputDerivatives,
    /// `fmi2GetRealOutputDerivatives`.
    GetRealOutputDerivatives,
    /// `fmi2DoStep`.
    DoStep,
    /// `fmi2CancelStep`.
    CancelStep,
    /// `fmi2GetStatus` and its four siblings.
    GetStatus,
}

impl Call {
    /// The phases in which the call is allowed. A failed step may be tried again: it fails again.
    pub(super) fn phases(self) -> &'static [Phase] {
        use Phase::{Initialization, Instantiated, StepComplete, StepFailed, Terminated};
        match self {
            Self::SetupExperiment | Self::EnterInitializationMode => &[Instantiated],
            Self::ExitInitializationMode => &[Initialization],
            Self::Terminate | Self::DoStep => &[StepComplete, StepFailed],
            Self::CancelStep => &[],
            Self::Set | Self::SetRealInputDerivatives => &[Instantiated, Initialization, StepComplete],
            Self::GetRealOutputDerivatives => &[StepComplete, StepFailed, Terminated],
            Self::Get | Self::GetDirectionalDerivative => &[Initialization, StepComplete, StepFailed, Terminated],
            Self::SetDebugLogging | Self::Reset | Self::State | Self::GetStatus => {
                &[Instantiated, Initialization, StepComplete, StepFailed, Terminated]
            }
        }
    }

    /// Whether the call is allowed in the phase.
    pub(super) fn allowed_in(self, phase: Phase) -> bool {
        self.phases().contains(&phase)
    }
}
