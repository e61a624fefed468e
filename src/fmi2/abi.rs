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
pub use importer::{ImportError, LoadedFmu, LoadedState};
pub use life::*;
pub use reserve::MemoryReserve;
pub use states::*;
pub use steps::*;
pub use values::*;

use super::call::CallError;
use super::lifecycle::CallGroup;
use super::status::CallStatus;
use component::Component;
use environment::HostEnvironment;
use std::ffi::{c_char, c_int, c_void};

/// Pointer to a component or a state.
type OpaquePointer = *mut c_void;
/// Pointer to a text that ends with a null byte.
type TextPointer = *const c_char;

/// Runs one call: floating-point environment, call order, panic guard, status and log lines.
fn guard(
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
    use super::component::ImporterLogger;
    use super::*;
    use crate::fmi2::instance::FmuInstance;
    use crate::fmi2::logger::CallLog;
    use crate::fmi2::parameters::PackedScene;
    use std::ffi::CString;
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
