//! What a component is to C: an instance, where its log goes, and the strings it lent.

use super::abi::LoggerCallback;
use super::call::CallError;
use super::instance::Instance;
use super::lifecycle::{Call, Phase};
use super::parameters::Packed;
use super::status::Status;
use std::any::Any;
use std::ffi::{CString, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a component points to.
pub(super) struct Component {
    /// The instance.
    pub instance: Instance,
    /// Where its log goes.
    pub logger: Logger,
    /// Strings given out by the last `fmi2GetString`.
    pub strings: Vec<CString>,
}

/// The importer's logger and what it is called with.
#[derive(Debug, Clone)]
pub(super) struct Logger {
    /// The function, if there is one.
    pub callback: Option<LoggerCallback>,
    /// Handed back as it is.
    pub environment: *mut c_void,
    /// Name of the instance.
    pub name: CString,
}

impl Component {
    /// Runs one call: order, panic guard, status. A panic loses the instance, which then only can be freed.
    ///
    /// Never inlined: what is computed in it stays between the two changes of the floating-point environment around it.
    #[inline(never)]
    pub(super) fn run(
        &mut self,
        function: &'static str,
        call: Call,
        body: impl FnOnce(&mut Self) -> Result<Status, CallError>,
    ) -> Status {
        let outcome = match self.instance.expect(function, call) {
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
                let text = said(&*panic);
                self.instance.phase = Phase::Fatal;
                self.instance.log.fatal(format!("{function}: internal error: {text}. The instance is lost; free it"));
                Status::Fatal
            }
        }
    }
}

impl Packed {
    /// Name and packed scene of an instance to be made, if the arguments of `fmi2Instantiate` are good.
    pub(super) fn found(
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
        Ok((name.to_string(), Self::at(resources, guid)?))
    }
}

fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}
