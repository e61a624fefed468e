//! Life cycle: phases and allowed calls (FMI 2.0.4, section 4.2.4).

use serde::{Deserialize, Serialize};
use std::fmt;

/// Phase of the life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum LifecyclePhase {
    /// New or reset.
    Instantiated,
    /// Initialization mode.
    Initialization,
    /// Between two steps.
    StepComplete,
    /// Incomplete step; the simulation is frozen.
    StepFailed,
    /// Terminated by the importer.
    Terminated,
    /// Lost in a panic.
    Fatal,
}

impl fmt::Display for LifecyclePhase {
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

/// Group of C functions with the same allowed phases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CallGroup {
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

impl CallGroup {
    /// Returns the phases in which the call is allowed. A failed step may be repeated; it fails again.
    pub(super) fn phases(self) -> &'static [LifecyclePhase] {
        use LifecyclePhase::{Initialization, Instantiated, StepComplete, StepFailed, Terminated};
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

    /// Returns true if the call is allowed in the phase.
    pub(super) fn is_allowed_in(self, phase: LifecyclePhase) -> bool {
        self.phases().contains(&phase)
    }
}
