//! The 34 exported functions of FMI 2.0 co-simulation.
//!
//! # Safety
//! The C standard's side of the contract is the importer's: a component comes from `fmi2Instantiate` and was not freed,
//! arrays have the length that is passed with them, strings end with a null byte, and one instance is used by one thread
//! at a time. What can be checked is checked here: null pointers, text encoding, and that a state is one of ours. Every
//! function runs inside `guard`, which stops a panic before it reaches C and computes in the default floating-point
//! environment. Log lines are handed over after the instance was let go and the importer's environment is back, so a
//! logger may call back into the FMU.

#![allow(unsafe_code)]
#![allow(non_snake_case)] // the names are those of the standard
#![allow(clippy::missing_safety_doc)] // one contract for all of them, above
#![allow(clippy::too_many_arguments)] // the signatures are those of the standard

mod callbacks;
mod environment;
#[cfg(feature = "cli")]
mod importer;
mod life;
mod pointers;
mod reserve;
mod states;
mod steps;
mod values;

pub use callbacks::{Callbacks, LoggerCallback};
#[cfg(feature = "cli")]
pub use importer::{ImportError, LoadedFmu, LoadedState};
pub use life::*;
pub use reserve::MemoryReserve;
pub use states::*;
pub use steps::*;
pub use values::*;

use super::call::CallError;
use super::component::Component;
use super::lifecycle::Call;
use super::status::Status;
use environment::HostEnvironment;
use std::ffi::{c_char, c_int, c_void};

/// A component or a state.
type Handle = *mut c_void;
/// Text that ends with a null byte.
type Text = *const c_char;
/// A C function and one of its arguments.
type Place = (&'static str, &'static str);

/// Runs one call: floating-point environment, order, panic guard, status and log lines.
fn guard(
    component: Handle,
    function: &'static str,
    call: Call,
    body: impl FnOnce(&mut Component) -> Result<Status, CallError>,
) -> c_int {
    if component.is_null() {
        return Status::Error as c_int;
    }
    // What frees memory needs none.
    if function != "fmi2FreeFMUstate" && !reserve::stands() {
        // SAFETY: not null, so it came from `fmi2Instantiate` and is used by this thread alone.
        unsafe { &*component.cast::<Component>() }.logger.complain();
        return Status::Error as c_int;
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

fn done((): ()) -> Status {
    Status::Ok
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::component::Logger;
    use crate::fmi2::instance::Instance;
    use crate::fmi2::logger::Log;
    use crate::fmi2::parameters::Packed;
    use std::ffi::CString;
    use std::ptr;

    #[test]
    fn a_panic_is_fatal_until_the_instance_is_freed() {
        let instance = Instance::new("a".into(), Packed::default(), Log::new(false));
        let logger = Logger { callback: None, environment: ptr::null_mut(), name: CString::default() };
        let component = Box::into_raw(Box::new(Component { instance, logger, strings: Vec::new() })).cast();
        let status = guard(component, "fmi2Reset", Call::Reset, |_| panic!("on purpose"));
        assert_eq!(status, Status::Fatal as c_int);
        // SAFETY: made above, freed once.
        unsafe {
            assert_eq!(fmi2Reset(component), Status::Fatal as c_int);
            fmi2FreeInstance(component);
        }
    }
}
