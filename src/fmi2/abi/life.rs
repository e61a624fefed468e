//! Inquiry, log, creation and destruction, and the way through the life cycle.

use super::environment::HostEnvironment;
use super::pointers::{slice, text};
use super::{Callbacks, Handle, Text, done, guard, reserve};
use crate::fmi2::call::CallError;
use crate::fmi2::component::{Component, Logger};
use crate::fmi2::instance::Instance;
use crate::fmi2::lifecycle::Call;
use crate::fmi2::logger::Log;
use crate::fmi2::parameters::Packed;
use crate::fmi2::status::Status;
use std::ffi::{CStr, CString, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

/// The types of `fmi2TypesPlatform.h`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

/// Switches debug logging.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(c: Handle, on: c_int, n: usize, categories: *const Text) -> c_int {
    let what = ("fmi2SetDebugLogging", "categories");
    guard(c, what.0, Call::SetDebugLogging, |it| {
        // SAFETY: n pointers to text.
        let texts = unsafe { slice(categories, n, what) }?.iter().map(|&at| unsafe { text(at, what) });
        let names = texts.map(|t| t.map(str::to_string)).collect::<Result<Vec<String>, CallError>>()?;
        it.instance.log.select(on != 0, &names).map(done)
    })
}

/// Makes an instance; null if it was refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: Text,
    fmu_type: c_int,
    guid: Text,
    resources: Text,
    functions: *const Callbacks,
    _visible: c_int,
    debug: c_int,
) -> Handle {
    if functions.is_null() {
        return ptr::null_mut();
    }
    // SAFETY: not null; the importer's structure of callbacks.
    let callbacks = unsafe { *functions };
    if !reserve::begins() {
        callbacks.complain(name);
        return ptr::null_mut();
    }
    let (component, lines, logger) = {
        let _environment = HostEnvironment::replace();
        let label = if name.is_null() { CString::default() } else { unsafe { CStr::from_ptr(name) }.to_owned() };
        let logger = Logger { callback: callbacks.logger, environment: callbacks.environment, name: label };
        let mut log = Log::new(debug != 0);
        // SAFETY: text or null each.
        let made = catch_unwind(|| unsafe { instantiate(name, fmu_type, guid, resources) });
        let made = match made {
            Ok(Ok((name, packed))) => Some(Instance::new(name, packed, Log::new(debug != 0))),
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
            reserve::ends();
        }
        let own = logger.clone();
        let component = made.map(|instance| Box::new(Component { instance, logger: own, strings: Vec::new() }));
        (component.map_or(ptr::null_mut(), |it| Box::into_raw(it).cast()), log.take(), logger)
    };
    logger.write(&lines);
    component
}

#[inline(never)] // what it computes stays within the environment that is set around it
unsafe fn instantiate(name: Text, fmu_type: c_int, guid: Text, resources: Text) -> Result<(String, Packed), CallError> {
    const FUNCTION: &str = "fmi2Instantiate";
    // SAFETY: null-terminated text or null each.
    let name = unsafe { text(name, (FUNCTION, "instanceName")) }?;
    let guid = unsafe { text(guid, (FUNCTION, "fmuGUID")) }?;
    let resources = if resources.is_null() {
        None
    } else {
        // SAFETY: not null.
        Some(unsafe { text(resources, (FUNCTION, "fmuResourceLocation")) }?)
    };
    Packed::found(name, fmu_type, guid, resources)
}

/// Completes the files, joins the threads and frees the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Handle) {
    if c.is_null() {
        return;
    }
    let (lines, logger) = {
        let _environment = HostEnvironment::replace();
        // SAFETY: from `fmi2Instantiate`, and not used again.
        let mut it = unsafe { Box::from_raw(c.cast::<Component>()) };
        // A panic here has nobody left to tell, but for the lines that were logged before it. Without memory files stay as they are.
        if reserve::stands() {
            drop(catch_unwind(AssertUnwindSafe(|| it.instance.finish_recording())));
        }
        let lines = it.instance.log.take();
        let logger = (!lines.is_empty()).then(|| it.logger.clone());
        drop(catch_unwind(AssertUnwindSafe(|| drop(it))));
        reserve::ends();
        (lines, logger)
    };
    if let Some(logger) = logger {
        logger.write(&lines);
    }
}

/// Takes start and stop time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: Handle,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start: f64,
    stop_defined: c_int,
    stop: f64,
) -> c_int {
    guard(c, "fmi2SetupExperiment", Call::SetupExperiment, |it| {
        it.instance.set_up(start, (stop_defined != 0).then_some(stop)).map(done)
    })
}

/// Enters initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: Handle) -> c_int {
    guard(c, "fmi2EnterInitializationMode", Call::EnterInitializationMode, |it| {
        it.instance.enter_initialization();
        Ok(Status::Ok)
    })
}

/// Leaves initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: Handle) -> c_int {
    guard(c, "fmi2ExitInitializationMode", Call::ExitInitializationMode, |it| {
        it.instance.exit_initialization().map(done)
    })
}

/// Ends the run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: Handle) -> c_int {
    guard(c, "fmi2Terminate", Call::Terminate, |it| Ok(it.instance.terminate()))
}

/// Back to a fresh instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Handle) -> c_int {
    guard(c, "fmi2Reset", Call::Reset, |it| Ok(it.instance.reset()))
}
