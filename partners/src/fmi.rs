//! The 34 exported functions of FMI 2.0 co-simulation around one partner, `crate::MODEL`.
//!
//! # Safety
//! As in the gel itself the C standard's side of the contract is the importer's: a component or state comes from here and
//! was not freed, arrays have the length that is passed with them, and one instance is used by one thread at a time. Null
//! pointers are refused, and no panic reaches C.

#![allow(unsafe_code)]
#![allow(non_snake_case)] // the names are those of the standard
#![allow(clippy::missing_safety_doc)] // one contract for all of them, above
#![allow(clippy::too_many_arguments)] // the signatures are those of the standard

use crate::MODEL;
use crate::instance::{Instance, State};
use crate::starts;
use crate::table::Model;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

type Handle = *mut c_void;
type Text = *const c_char;
type Logger = unsafe extern "C" fn(Handle, Text, c_int, Text, Text, ...);

const OK: c_int = 0;
const DISCARD: c_int = 2;
const ERROR: c_int = 3;
const FATAL: c_int = 4;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;
const CO_SIMULATION: c_int = 1;

static PARTNER: Model = MODEL;

/// The beginning of the standard's table of callbacks; the rest is not used.
#[repr(C)]
pub struct Callbacks {
    logger: Option<Logger>,
}

struct Component {
    instance: Instance,
    name: CString,
    logger: Option<Logger>,
    environment: Handle,
    broken: bool,
}

impl Component {
    fn report(&self, status: c_int, message: &str) {
        // A percent sign would be taken for a format.
        let (Some(logger), Ok(text)) = (self.logger, CString::new(message.replace('%', "%%"))) else { return };
        // SAFETY: the importer's function with its own environment, and text that ends with a null byte.
        unsafe { logger(self.environment, self.name.as_ptr(), status, c"error".as_ptr(), text.as_ptr()) }
    }
}

/// Runs one call: panic guard, status, and one line of log if it fails.
fn call(component: Handle, body: impl FnOnce(&mut Instance) -> Result<(), String>) -> c_int {
    if component.is_null() {
        return ERROR;
    }
    // SAFETY: not null, so it came from `fmi2Instantiate` and is used by this thread alone.
    let it = unsafe { &mut *component.cast::<Component>() };
    if it.broken {
        return FATAL;
    }
    match catch_unwind(AssertUnwindSafe(|| body(&mut it.instance))) {
        Ok(Ok(())) => OK,
        Ok(Err(message)) => {
            it.report(ERROR, &message);
            ERROR
        }
        Err(_) => {
            it.broken = true;
            it.report(FATAL, "a bug in this component: it answers fmi2Fatal from now on");
            FATAL
        }
    }
}

/// The array behind a pointer; empty if its length is 0, whatever the pointer.
unsafe fn slice<'a, T>(at: *const T, n: usize) -> Result<&'a [T], String> {
    match (n, at.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err("an array is a null pointer".to_owned()),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(at, n) }),
    }
}

/// The array behind a pointer, to be written.
unsafe fn slice_mut<'a, T>(at: *mut T, n: usize) -> Result<&'a mut [T], String> {
    match (n, at.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err("an array is a null pointer".to_owned()),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(at, n) }),
    }
}

fn none(n: usize, kind: &str) -> Result<(), String> {
    if n == 0 { Ok(()) } else { Err(format!("there are no {kind} variables: all of them are Real")) }
}

/// "default".
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> Text {
    c"default".as_ptr()
}

/// "2.0".
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> Text {
    c"2.0".as_ptr()
}

/// Only errors are logged, and always.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(c: Handle, _: c_int, _: usize, _: *const Text) -> c_int {
    call(c, |_| Ok(()))
}

/// A new instance; null if the interface or the kind is another one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    name: Text,
    kind: c_int,
    guid: Text,
    resources: Text,
    callbacks: *const Callbacks,
    _: c_int,
    _: c_int,
) -> Handle {
    if name.is_null() || guid.is_null() {
        return ptr::null_mut();
    }
    // SAFETY: text that ends with a null byte or null, and a table of callbacks or null; the environment stands behind four
    // function pointers.
    let (name, guid, location, logger, environment) = unsafe {
        let logger = callbacks.as_ref().and_then(|callbacks| callbacks.logger);
        let environment = if callbacks.is_null() { ptr::null_mut() } else { *callbacks.cast::<Handle>().add(4) };
        let location = if resources.is_null() { None } else { CStr::from_ptr(resources).to_str().ok() };
        (CStr::from_ptr(name).to_owned(), CStr::from_ptr(guid), location, logger, environment)
    };
    let made =
        catch_unwind(|| starts::at(&PARTNER, location)).unwrap_or_else(|_| Err("a bug in this component".into()));
    let (starts, fault) = made.map_or_else(|fault| (PARTNER.values(), Some(fault)), |starts| (starts, None));
    let expected = PARTNER.guid(&starts);
    let component = Component { instance: Instance::new(&PARTNER, starts), name, logger, environment, broken: false };
    if let Some(fault) = fault {
        component.report(ERROR, &format!("{fault}; pack the FMU again"));
        return ptr::null_mut();
    }
    if kind != CO_SIMULATION || guid.to_bytes() != expected.as_bytes() {
        component.report(ERROR, &format!("expected co-simulation and the guid {expected}: pack the FMU again"));
        return ptr::null_mut();
    }
    Box::into_raw(Box::new(component)).cast()
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: Handle) {
    if !c.is_null() {
        // SAFETY: made by `fmi2Instantiate`, freed once.
        drop(unsafe { Box::from_raw(c.cast::<Component>()) });
    }
}

/// Start time; a stop time is not needed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(c: Handle, _: c_int, _: f64, start: f64, _: c_int, _: f64) -> c_int {
    call(c, |it| it.setup(start))
}

/// Enters initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: Handle) -> c_int {
    call(c, Instance::enter_initialization)
}

/// Leaves initialization mode.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: Handle) -> c_int {
    call(c, Instance::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: Handle) -> c_int {
    call(c, Instance::terminate)
}

/// Back to the state after `fmi2Instantiate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Handle) -> c_int {
    call(c, |it| {
        it.reset();
        Ok(())
    })
}

/// Reads values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: Handle, vr: *const u32, n: usize, value: *mut f64) -> c_int {
    call(c, |it| {
        // SAFETY: both arrays have n items.
        let (references, to) = unsafe { (slice(vr, n)?, slice_mut(value, n)?) };
        to.copy_from_slice(&it.get(references)?);
        Ok(())
    })
}

/// There are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: Handle, _: *const u32, n: usize, _: *mut c_int) -> c_int {
    call(c, |_| none(n, "Integer"))
}

/// There are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: Handle, _: *const u32, n: usize, _: *mut c_int) -> c_int {
    call(c, |_| none(n, "Boolean"))
}

/// There are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(c: Handle, _: *const u32, n: usize, _: *mut Text) -> c_int {
    call(c, |_| none(n, "String"))
}

/// Sets values: all, or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: Handle, vr: *const u32, n: usize, value: *const f64) -> c_int {
    call(c, |it| {
        // SAFETY: both arrays have n items.
        let (references, values) = unsafe { (slice(vr, n)?, slice(value, n)?) };
        it.set(references, values)
    })
}

/// There are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: Handle, _: *const u32, n: usize, _: *const c_int) -> c_int {
    call(c, |_| none(n, "Integer"))
}

/// There are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: Handle, _: *const u32, n: usize, _: *const c_int) -> c_int {
    call(c, |_| none(n, "Boolean"))
}

/// There are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(c: Handle, _: *const u32, n: usize, _: *const Text) -> c_int {
    call(c, |_| none(n, "String"))
}

/// The state behind a pointer.
unsafe fn state<'a>(at: Handle) -> Result<&'a State, String> {
    // SAFETY: null, or a state that was made by `keep` and not freed.
    unsafe { at.cast::<State>().as_ref() }.ok_or_else(|| "the state is a null pointer".to_owned())
}

/// Puts a state behind `*target`: into the one that is there, or into a new one.
unsafe fn keep(target: *mut Handle, state: State) -> Result<(), String> {
    // SAFETY: a pointer to a pointer, which is null or that of a state.
    let target = &mut unsafe { slice_mut(target, 1) }?[0];
    match unsafe { target.cast::<State>().as_mut() } {
        Some(known) => *known = state,
        None => *target = Box::into_raw(Box::new(state)).cast(),
    }
    Ok(())
}

/// Copies the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Handle, target: *mut Handle) -> c_int {
    // SAFETY: a pointer to a pointer.
    call(c, |it| unsafe { keep(target, it.state().clone()) })
}

/// Goes to a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Handle, from: Handle) -> c_int {
    call(c, |it| {
        // SAFETY: a state or null.
        it.restore(unsafe { state(from) }?.clone());
        Ok(())
    })
}

/// Frees a state and makes its pointer null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: Handle, target: *mut Handle) -> c_int {
    call(c, |_| {
        // SAFETY: null, or a pointer to a pointer that is null or that of a state.
        if let Some(target) = unsafe { target.as_mut() }.filter(|target| !target.is_null()) {
            drop(unsafe { Box::from_raw(target.cast::<State>()) });
            *target = ptr::null_mut();
        }
        Ok(())
    })
}

/// Number of bytes of a serialised state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: Handle, from: Handle, size: *mut usize) -> c_int {
    // SAFETY: a state or null, and a pointer to one size.
    call(c, |it| unsafe {
        slice_mut(size, 1)?[0] = state(from)?.to_bytes(it.model).len();
        Ok(())
    })
}

/// Writes a state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(c: Handle, from: Handle, to: *mut u8, size: usize) -> c_int {
    call(c, |it| {
        // SAFETY: a state or null, and `size` bytes.
        let (bytes, to) = unsafe { (state(from)?.to_bytes(it.model), slice_mut(to, size)?) };
        if bytes.len() != size {
            return Err(format!("serialised state: found room for {size} bytes, expected {}", bytes.len()));
        }
        to.copy_from_slice(&bytes);
        Ok(())
    })
}

/// Makes a state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: Handle,
    from: *const u8,
    size: usize,
    target: *mut Handle,
) -> c_int {
    // SAFETY: `size` bytes, and a pointer to a pointer.
    call(c, |it| unsafe { keep(target, State::from_bytes(slice(from, size)?, it.model)?) })
}

/// Not offered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: Handle,
    _: *const u32,
    _: usize,
    _: *const u32,
    _: usize,
    _: *const f64,
    _: *mut f64,
) -> c_int {
    call(c, |_| Err("directional derivatives are not offered".to_owned()))
}

/// Not offered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: Handle,
    _: *const u32,
    _: usize,
    _: *const c_int,
    _: *const f64,
) -> c_int {
    call(c, |_| Err("derivatives of inputs are not offered: they are constant over a step".to_owned()))
}

/// Not offered.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: Handle,
    _: *const u32,
    _: usize,
    _: *const c_int,
    _: *mut f64,
) -> c_int {
    call(c, |_| Err("derivatives of outputs are not offered".to_owned()))
}

/// Takes one step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(c: Handle, from: f64, length: f64, _: c_int) -> c_int {
    call(c, |it| it.step(from, length))
}

/// There is nothing to cancel: steps are synchronous.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: Handle) -> c_int {
    call(c, |_| Err("there is nothing to cancel: steps are synchronous".to_owned()))
}

/// Nothing is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(_: Handle, _: c_int, _: *mut c_int) -> c_int {
    DISCARD
}

/// The last successful time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Handle, kind: c_int, value: *mut f64) -> c_int {
    if kind != LAST_SUCCESSFUL_TIME {
        return DISCARD;
    }
    call(c, |it| {
        // SAFETY: a pointer to one value.
        unsafe { slice_mut(value, 1) }?[0] = it.time();
        Ok(())
    })
}

/// Nothing is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(_: Handle, _: c_int, _: *mut c_int) -> c_int {
    DISCARD
}

/// A partner never ends by itself.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Handle, kind: c_int, value: *mut c_int) -> c_int {
    if kind != TERMINATED {
        return DISCARD;
    }
    call(c, |_| {
        // SAFETY: a pointer to one value.
        unsafe { slice_mut(value, 1) }?[0] = 0;
        Ok(())
    })
}

/// Nothing is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(_: Handle, _: c_int, _: *mut Text) -> c_int {
    DISCARD
}
