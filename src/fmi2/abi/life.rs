//! C functions of inquiry, log, creation, destruction and life cycle.

use super::callbacks::{CallbackFunctions, ImporterLogger};
use super::component::{Component, guard};
use super::environment::HostEnvironment;
use super::pointers::{OpaquePointer, TextPointer, slice, text};
use super::reserve;
use crate::fmi2::call::CallError;
use crate::fmi2::instance::FmuInstance;
use crate::fmi2::lifecycle::CallGroup;
use crate::fmi2::logger::CallLog;
use crate::fmi2::status::CallStatus;
use std::ffi::{CStr, CString, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

/// Returns the platform types of `fmi2TypesPlatform.h`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> TextPointer {
    c"default".as_ptr()
}

/// Returns the version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> TextPointer {
    c"2.0".as_ptr()
}

/// Switches debug logging.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: OpaquePointer,
    on: c_int,
    n: usize,
    categories: *const TextPointer,
) -> c_int {
    let name = "fmi2SetDebugLogging";
    guard(c, name, CallGroup::SetDebugLogging, |it| {
        // SAFETY: n pointers to text.
        let texts = unsafe { slice(categories, n, name, "categories") }?
            .iter()
            .map(|&at| unsafe { text(at, name, "categories") });
        let names = texts.map(|t| t.map(str::to_string)).collect::<Result<Vec<String>, CallError>>()?;
        it.instance.log.select(on != 0, &names).map(|()| CallStatus::Ok)
    })
}

/// Creates an instance; a refused call returns null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: TextPointer,
    fmu_type: c_int,
    guid: TextPointer,
    resources: TextPointer,
    functions: *const CallbackFunctions,
    _visible: c_int,
    debug: c_int,
) -> OpaquePointer {
    if functions.is_null() {
        return ptr::null_mut();
    }
    // SAFETY: not null; the importer's structure of callbacks.
    let callbacks = unsafe { *functions };
    if !reserve::register_instance() {
        callbacks.report_shortage(name);
        return ptr::null_mut();
    }
    let (component, lines, logger) = {
        let _environment = HostEnvironment::replace();
        let label = if name.is_null() { CString::default() } else { unsafe { CStr::from_ptr(name) }.to_owned() };
        let logger = ImporterLogger { callback: callbacks.logger, environment: callbacks.environment, name: label };
        let mut log = CallLog::new(debug != 0);
        // SAFETY: text or null each.
        let made = catch_unwind(|| unsafe { instantiate(name, fmu_type, guid, resources, debug != 0) });
        let made = match made {
            Ok(Ok(instance)) => Some(instance),
            Ok(Err(error)) => {
                log.refusal(&error);
                None
            }
            Err(_) => {
                log.fatal("fmi2Instantiate: internal error".to_string());
                None
            }
        };
        if made.is_none() {
            reserve::unregister_instance();
        }
        let own = logger.clone();
        let component = made.map(|instance| Box::new(Component { instance, logger: own, strings: Vec::new() }));
        (component.map_or(ptr::null_mut(), |it| Box::into_raw(it).cast()), log.take(), logger)
    };
    logger.write(&lines);
    component
}

#[inline(never)] // what it computes stays within the environment that is set around it
unsafe fn instantiate(
    name: TextPointer,
    fmu_type: c_int,
    guid: TextPointer,
    resources: TextPointer,
    debug: bool,
) -> Result<FmuInstance, CallError> {
    const FUNCTION: &str = "fmi2Instantiate";
    // SAFETY: null-terminated text or null each.
    let name = unsafe { text(name, FUNCTION, "instanceName") }?;
    let guid = unsafe { text(guid, FUNCTION, "fmuGUID") }?;
    let resources = if resources.is_null() {
        None
    } else {
        // SAFETY: not null.
        Some(unsafe { text(resources, FUNCTION, "fmuResourceLocation") }?)
    };
    FmuInstance::from_arguments(name, fmu_type, guid, resources, debug)
}

/// Completes the files, joins the threads and frees the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: OpaquePointer) {
    if c.is_null() {
        return;
    }
    let (lines, logger) = {
        let _environment = HostEnvironment::replace();
        // SAFETY: from `fmi2Instantiate`, and not used again.
        let mut it = unsafe { Box::from_raw(c.cast::<Component>()) };
        // A panic here can only be reported by the lines logged before it. Without memory the files stay unchanged.
        if reserve::ensure_standing_reserve() {
            drop(catch_unwind(AssertUnwindSafe(|| it.instance.finish_recording())));
        }
        let lines = it.instance.log.take();
        let logger = (!lines.is_empty()).then(|| it.logger.clone());
        drop(catch_unwind(AssertUnwindSafe(|| drop(it))));
        reserve::unregister_instance();
        (lines, logger)
    };
    if let Some(logger) = logger {
        logger.write(&lines);
    }
}

/// Sets start and stop time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: OpaquePointer,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    stop_defined: c_int,
    stop: f64,
) -> c_int {
    guard(c, "fmi2SetupExperiment", CallGroup::SetupExperiment, |it| {
        it.instance.set_up_experiment(start, (stop_defined != 0).then_some(stop)).map(|()| CallStatus::Ok)
    })
}

/// Enters initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: OpaquePointer) -> c_int {
    guard(c, "fmi2EnterInitializationMode", CallGroup::EnterInitializationMode, |it| {
        it.instance.enter_initialization();
        Ok(CallStatus::Ok)
    })
}

/// Leaves initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: OpaquePointer) -> c_int {
    guard(c, "fmi2ExitInitializationMode", CallGroup::ExitInitializationMode, |it| {
        it.instance.exit_initialization().map(|()| CallStatus::Ok)
    })
}

/// Ends the run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: OpaquePointer) -> c_int {
    guard(c, "fmi2Terminate", CallGroup::Terminate, |it| Ok(it.instance.terminate()))
}

/// Resets the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: OpaquePointer) -> c_int {
    guard(c, "fmi2Reset", CallGroup::Reset, |it| Ok(it.instance.reset()))
}
