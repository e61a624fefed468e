//! FMI component behind a C pointer: instance, logger and lent strings.

use super::callbacks::LoggerCallback;
use crate::fmi2::call::CallError;
use crate::fmi2::instance::FmuInstance;
use crate::fmi2::lifecycle::{CallGroup, LifecyclePhase};
use crate::fmi2::parameters::PackedScene;
use crate::fmi2::status::CallStatus;
use std::any::Any;
use std::ffi::{CString, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// FMI component behind a C pointer.
pub(in crate::fmi2) struct Component {
    /// Instance of the FMU.
    pub instance: FmuInstance,
    /// Logger of the importer.
    pub logger: ImporterLogger,
    /// Strings lent by the last `fmi2GetString`.
    pub strings: Vec<CString>,
}

/// Logger of the importer with its arguments.
#[derive(Debug, Clone)]
pub(in crate::fmi2) struct ImporterLogger {
    /// Callback function, if any.
    pub callback: Option<LoggerCallback>,
    /// Component environment, handed back unchanged.
    pub environment: *mut c_void,
    /// Name of the instance.
    pub name: CString,
}

impl Component {
    /// Runs one call with order check, panic guard and status. A panic loses the instance, which can only be freed
    /// afterwards.
    ///
    /// Never inlined: the computation stays between the two changes of the floating-point environment.
    #[inline(never)]
    pub(in crate::fmi2) fn run(
        &mut self,
        function: &'static str,
        call: CallGroup,
        body: impl FnOnce(&mut Self) -> Result<CallStatus, CallError>,
    ) -> CallStatus {
        let outcome = match self.instance.expect_allowed(function, call) {
            Ok(()) => catch_unwind(AssertUnwindSafe(|| body(self))),
            Err(error) => Ok(Err(error)),
        };
        match outcome {
            Ok(Ok(status)) => status,
            Ok(Err(error)) => {
                self.instance.log.refusal(&error);
                error.status()
            }
            Err(panic) => {
                let text = panic_message(&*panic);
                self.instance.phase = LifecyclePhase::Fatal;
                self.instance.log.fatal(format!("{function}: internal error: {text}. The instance is lost; free it"));
                CallStatus::Fatal
            }
        }
    }
}

impl PackedScene {
    /// Returns name and packed scene of a new instance, if the arguments of `fmi2Instantiate` are valid.
    pub(in crate::fmi2) fn from_arguments(
        name: &str,
        fmu_type: i32,
        guid: &str,
        resources: Option<&str>,
    ) -> Result<(String, Self), CallError> {
        if name.trim().is_empty() {
            return Err(CallError::value("instanceName", format!("{name:?}"), "a name"));
        }
        if fmu_type != 1 {
            return Err(CallError::value("fmuType", fmu_type, "1, co-simulation"));
        }
        Ok((name.to_string(), Self::read_at(resources, guid)?))
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
