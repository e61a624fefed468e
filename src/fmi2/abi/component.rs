//! FMI component behind a C pointer, and the guard of every call to it.

use super::callbacks::ImporterLogger;
use super::environment::HostEnvironment;
use super::pointers::OpaquePointer;
use super::reserve;
use crate::fmi2::call::CallError;
use crate::fmi2::instance::FmuInstance;
use crate::fmi2::lifecycle::{CallGroup, LifecyclePhase};
use crate::fmi2::logger::CallLog;
use crate::fmi2::parameters::PackedScene;
use crate::fmi2::status::CallStatus;
use std::any::Any;
use std::ffi::{CString, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// FMI component behind a C pointer.
pub(super) struct Component {
    /// Instance of the FMU.
    pub instance: FmuInstance,
    /// Logger of the importer.
    pub logger: ImporterLogger,
    /// Strings lent by the last `fmi2GetString`.
    pub strings: Vec<CString>,
}

impl Component {
    /// Runs one call with order check, panic guard and status. A panic loses the instance, which can only be freed
    /// afterwards.
    ///
    /// Never inlined: the computation stays between the two changes of the floating-point environment.
    #[inline(never)]
    pub(super) fn run(
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

impl FmuInstance {
    /// Returns a new instance, if the arguments of `fmi2Instantiate` are valid.
    pub(super) fn from_arguments(
        name: &str,
        fmu_type: c_int,
        guid: &str,
        resources: Option<&str>,
        debug: bool,
    ) -> Result<Self, CallError> {
        if name.trim().is_empty() {
            return Err(CallError::value("instanceName", format!("{name:?}"), "a name"));
        }
        if fmu_type != 1 {
            return Err(CallError::value("fmuType", fmu_type, "1, co-simulation"));
        }
        Ok(Self::new(name.to_owned(), PackedScene::read_at(resources, guid)?, CallLog::new(debug)))
    }
}

fn panic_message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Runs one call: floating-point environment, call order, panic guard, status and log lines.
pub(super) fn guard(
    component: OpaquePointer,
    function: &'static str,
    call: CallGroup,
    body: impl FnOnce(&mut Component) -> Result<CallStatus, CallError>,
) -> c_int {
    if component.is_null() {
        return CallStatus::Error as c_int;
    }
    // Freeing memory needs no reserve.
    if function != "fmi2FreeFMUstate" && !reserve::ensure_standing_reserve() {
        // SAFETY: not null, so it came from `fmi2Instantiate` and is used by this thread alone.
        unsafe { &*component.cast::<Component>() }.logger.report_shortage();
        return CallStatus::Error as c_int;
    }
    let (status, lines, logger) = {
        let _environment = HostEnvironment::replace();
        // SAFETY: not null, so it came from `fmi2Instantiate` and is used by this thread alone.
        let it = unsafe { &mut *component.cast::<Component>() };
        let status = it.run(function, call, body);
        let lines = it.instance.log.take();
        let logger = (!lines.is_empty()).then(|| it.logger.clone());
        (status, lines, logger)
    };
    if let Some(logger) = logger {
        logger.write(&lines);
    }
    status as c_int
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::abi::{fmi2FreeInstance, fmi2Reset};
    use std::ptr;

    #[test]
    fn a_panic_is_fatal_until_the_instance_is_freed() {
        let instance = FmuInstance::new("a".into(), PackedScene::default(), CallLog::new(false));
        let logger = ImporterLogger { callback: None, environment: ptr::null_mut(), name: CString::default() };
        let component = Box::into_raw(Box::new(Component { instance, logger, strings: Vec::new() })).cast();
        let status = guard(component, "fmi2Reset", CallGroup::Reset, |_| panic!("on purpose"));
        assert_eq!(status, CallStatus::Fatal as c_int);
        // SAFETY: made above, freed once.
        unsafe {
            assert_eq!(fmi2Reset(component), CallStatus::Fatal as c_int);
            fmi2FreeInstance(component);
        }
    }
}
