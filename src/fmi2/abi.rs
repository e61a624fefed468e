//! The 34 exported functions of FMI 2.0 co-simulation.
//!
//! # Safety
//! The C standard's side of the contract is the importer's: a component comes from `fmi2Instantiate` and was not freed,
//! arrays have the length that is passed with them, strings end with a null byte, and one instance is used by one thread
//! at a time. What can be checked is checked here: null pointers, text encoding, and that a state is one of ours. Every
//! function runs inside `guard`, which stops a panic before it reaches C. Log lines are handed over after the
//! instance was let go, so a logger may call back into the FMU.

#![allow(unsafe_code)]
#![allow(non_snake_case)] // the names are those of the standard
#![allow(clippy::missing_safety_doc)] // one contract for all of them, above
#![allow(clippy::too_many_arguments)] // the signatures are those of the standard

use super::call::CallError;
use super::component::{Component, Logger};
use super::instance::Instance;
use super::lifecycle::Call;
use super::logger::{Line, Log, as_format};
use super::parameters::Packed;
use super::snapshot::{Snapshot, SnapshotError};
use super::types::{Callbacks, Status};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;

/// A component or a state.
type Handle = *mut c_void;
/// Text that ends with a null byte.
type Text = *const c_char;
/// A C function and one of its arguments.
type Place = (&'static str, &'static str);

/// What a state points to. The first word is zero: a caller that frees by value, not by address, frees nothing.
#[repr(C)]
struct State {
    zero: u64,
    magic: u64,
    snapshot: Snapshot,
}

const STATE_MAGIC: u64 = 0x4745_4c53_5441_5445;

/// Runs one call: order, panic guard, status and log lines.
fn guard(
    component: Handle,
    function: &'static str,
    call: Call,
    body: impl FnOnce(&mut Component) -> Result<Status, CallError>,
) -> c_int {
    if component.is_null() {
        return Status::Error as c_int;
    }
    let (status, lines, logger) = {
        // SAFETY: not null, so it came from `fmi2Instantiate` and is used by this thread alone.
        let it = unsafe { &mut *component.cast::<Component>() };
        let status = it.run(function, call, body);
        (status, it.instance.log.take(), it.logger.clone())
    };
    logger.write(&lines);
    status as c_int
}

impl Logger {
    /// Hands the lines to the importer.
    fn write(&self, lines: &[Line]) {
        let Some(callback) = self.callback else { return };
        for line in lines {
            let category = CString::new(line.category).unwrap_or_default();
            let message = CString::new(as_format(&line.message)).unwrap_or_default();
            let status = line.status as c_int;
            // SAFETY: the importer's function with its own environment; the format consumes no argument.
            unsafe {
                callback(self.environment, self.name.as_ptr(), status, category.as_ptr(), message.as_ptr());
            }
        }
    }
}

/// The array behind a pointer; empty if its length is 0, whatever the pointer.
unsafe fn slice<'a, T>(at: *const T, n: usize, what: Place) -> Result<&'a [T], CallError> {
    match (n, at.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(CallError::NullPointer { function: what.0, argument: what.1 }),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(at, n) }),
    }
}

/// The array behind a pointer, to be written.
unsafe fn slice_mut<'a, T>(at: *mut T, n: usize, what: Place) -> Result<&'a mut [T], CallError> {
    match (n, at.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err(CallError::NullPointer { function: what.0, argument: what.1 }),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(at, n) }),
    }
}

/// The text behind a pointer.
unsafe fn text<'a>(at: Text, what: Place) -> Result<&'a str, CallError> {
    if at.is_null() {
        return Err(CallError::NullPointer { function: what.0, argument: what.1 });
    }
    // SAFETY: not null, so it ends with a null byte.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|_| CallError::NotText { function: what.0, argument: what.1 })
}

/// The state behind a pointer.
unsafe fn state<'a>(at: Handle, function: &'static str) -> Result<&'a mut State, CallError> {
    if at.is_null() {
        return Err(CallError::NullPointer { function, argument: "FMUstate" });
    }
    if !at.cast::<State>().is_aligned() {
        return Err(SnapshotError::Foreign.into());
    }
    // SAFETY: not null and aligned; the two words are read before the rest is trusted.
    let words = unsafe { *at.cast::<[u64; 2]>() };
    if words != [0, STATE_MAGIC] {
        return Err(SnapshotError::Foreign.into());
    }
    // SAFETY: the words are those of a state of ours.
    Ok(unsafe { &mut *at.cast::<State>() })
}

/// Puts a snapshot behind `*target`: into the state that is there, or into a new one.
unsafe fn keep(target: *mut Handle, snapshot: Snapshot, function: &'static str) -> Result<Status, CallError> {
    // SAFETY: a pointer to a pointer, as the standard wants it.
    let target = &mut unsafe { slice_mut(target, 1, (function, "FMUstate")) }?[0];
    if target.is_null() {
        *target = Box::into_raw(Box::new(State { zero: 0, magic: STATE_MAGIC, snapshot })).cast();
    } else {
        // SAFETY: checked by `state`.
        unsafe { state(*target, function) }?.snapshot = snapshot;
    }
    Ok(Status::Ok)
}

/// References and the values that go with them.
unsafe fn both<'a, T>(
    (references, n): (*const u32, usize),
    values: *const T,
    name: &'static str,
) -> Result<(&'a [u32], &'a [T]), CallError> {
    // SAFETY: both arrays have n items.
    unsafe { Ok((slice(references, n, (name, "vr"))?, slice(values, n, (name, "value"))?)) }
}

fn done((): ()) -> Status {
    Status::Ok
}

/// Reads one variable for each reference.
unsafe fn get<T>(
    (references, n): (*const u32, usize),
    values: *mut T,
    function: &'static str,
    mut read: impl FnMut(u32) -> Result<T, CallError>,
) -> Result<Status, CallError> {
    // SAFETY: both arrays have n items.
    let (references, values) =
        unsafe { (slice(references, n, (function, "vr"))?, slice_mut(values, n, (function, "value"))?) };
    for (value, &reference) in values.iter_mut().zip(references) {
        *value = read(reference)?;
    }
    Ok(Status::Ok)
}

/// Writes the answer of a status request.
unsafe fn answer<T>(at: *mut T, function: &'static str, value: Result<T, CallError>) -> Result<Status, CallError> {
    // SAFETY: a pointer to one value.
    let at = unsafe { slice_mut(at, 1, (function, "value")) }?;
    at[0] = value?;
    Ok(Status::Ok)
}

// Inquiry and log

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

// Creation and destruction

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
    logger.write(&log.take());
    let component = made.map(|instance| Box::new(Component { instance, logger, strings: Vec::new() }));
    component.map_or(ptr::null_mut(), |it| Box::into_raw(it).cast())
}

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
    // SAFETY: from `fmi2Instantiate`, and not used again.
    let mut it = unsafe { Box::from_raw(c.cast::<Component>()) };
    let finished = catch_unwind(AssertUnwindSafe(|| it.instance.finish_recording()));
    if let Ok(Err(error)) = finished {
        it.instance.log.refusal(&error);
    }
    let (lines, logger) = (it.instance.log.take(), it.logger.clone());
    // A panic here has nobody left to tell.
    drop(catch_unwind(AssertUnwindSafe(|| drop(it))));
    logger.write(&lines);
}

// Life cycle

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
    guard(c, "fmi2Terminate", Call::Terminate, |it| it.instance.terminate().map(done))
}

/// Back to a fresh instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: Handle) -> c_int {
    guard(c, "fmi2Reset", Call::Reset, |it| it.instance.reset().map(done))
}

// Variables

/// Reads Reals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: Handle, vr: *const u32, n: usize, value: *mut f64) -> c_int {
    let name = "fmi2GetReal";
    // SAFETY: both arrays have n items.
    guard(c, name, Call::Get, |it| unsafe { get((vr, n), value, name, |r| it.instance.real(r)) })
}

/// Reads Integers and Enumerations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: Handle, vr: *const u32, n: usize, value: *mut c_int) -> c_int {
    let name = "fmi2GetInteger";
    // SAFETY: both arrays have n items.
    guard(c, name, Call::Get, |it| unsafe { get((vr, n), value, name, |r| it.instance.integer(r)) })
}

/// Reads Booleans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: Handle, vr: *const u32, n: usize, value: *mut c_int) -> c_int {
    let name = "fmi2GetBoolean";
    // SAFETY: both arrays have n items.
    guard(c, name, Call::Get, |it| unsafe { get((vr, n), value, name, |r| it.instance.boolean(r).map(c_int::from)) })
}

/// Reads Strings; they stay valid until the next call of this function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(c: Handle, vr: *const u32, n: usize, value: *mut Text) -> c_int {
    let name = "fmi2GetString";
    guard(c, name, Call::Get, |it| {
        it.strings.clear();
        let Component { instance, strings, .. } = it;
        // SAFETY: both arrays have n items; the bytes of a string stay where they are when the list grows.
        unsafe {
            get((vr, n), value, name, |r| {
                strings.push(CString::new(instance.text(r)?).unwrap_or_default());
                Ok(strings.last().map_or(ptr::null(), |s| s.as_ptr()))
            })
        }
    })
}

/// Sets Reals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: Handle, vr: *const u32, n: usize, value: *const f64) -> c_int {
    let name = "fmi2SetReal";
    guard(c, name, Call::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { both((vr, n), value, name) }?;
        it.instance.set_reals(vr, value).map(done)
    })
}

/// Sets Integers and Enumerations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: Handle, vr: *const u32, n: usize, value: *const c_int) -> c_int {
    let name = "fmi2SetInteger";
    guard(c, name, Call::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { both((vr, n), value, name) }?;
        it.instance.set_integers(vr, value).map(done)
    })
}

/// Refuses to set Booleans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: Handle, vr: *const u32, n: usize, _value: *const c_int) -> c_int {
    let name = "fmi2SetBoolean";
    guard(c, name, Call::Set, |it| {
        // SAFETY: n items.
        it.instance.set_booleans(unsafe { slice(vr, n, (name, "vr")) }?)?;
        Ok(Status::Ok)
    })
}

/// Sets Strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(c: Handle, vr: *const u32, n: usize, value: *const Text) -> c_int {
    let name = "fmi2SetString";
    guard(c, name, Call::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { both((vr, n), value, name) }?;
        let texts = value.iter().map(|&at| unsafe { text(at, (name, "value")) });
        it.instance.set_texts(vr, &texts.collect::<Result<Vec<&str>, CallError>>()?).map(done)
    })
}

// State

/// Copies the state of the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Handle, target: *mut Handle) -> c_int {
    let name = "fmi2GetFMUstate";
    // SAFETY: a pointer to a pointer.
    guard(c, name, Call::State, |it| unsafe { keep(target, it.instance.snapshot(), name) })
}

/// Goes to a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Handle, from: Handle) -> c_int {
    let name = "fmi2SetFMUstate";
    guard(c, name, Call::State, |it| {
        // SAFETY: checked by `state`.
        it.instance.restore(&unsafe { state(from, name) }?.snapshot).map(done)
    })
}

/// Frees a state and makes its pointer null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: Handle, target: *mut Handle) -> c_int {
    let name = "fmi2FreeFMUstate";
    guard(c, name, Call::State, |_| {
        if target.is_null() {
            return Ok(Status::Ok);
        }
        // SAFETY: a pointer to a pointer; what it points to is checked by `state` before it is freed.
        unsafe {
            if !(*target).is_null() {
                state(*target, name)?.magic = 0;
                drop(Box::from_raw((*target).cast::<State>()));
                *target = ptr::null_mut();
            }
        }
        Ok(Status::Ok)
    })
}

/// Number of bytes of a serialised state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: Handle, from: Handle, size: *mut usize) -> c_int {
    let name = "fmi2SerializedFMUstateSize";
    // SAFETY: a pointer to one size; the state is checked by `state`.
    guard(c, name, Call::State, |_| unsafe {
        let found = state(from, name)?.snapshot.size();
        slice_mut(size, 1, (name, "size"))?[0] = found;
        Ok(Status::Ok)
    })
}

/// Writes a state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(c: Handle, from: Handle, to: *mut u8, size: usize) -> c_int {
    let name = "fmi2SerializeFMUstate";
    guard(c, name, Call::State, |_| {
        // SAFETY: `size` bytes; the state is checked by `state`.
        let (state, to) = unsafe { (state(from, name)?, slice_mut(to, size, (name, "serializedState"))?) };
        let bytes = state.snapshot.to_bytes();
        if bytes.len() != to.len() {
            return Err(SnapshotError::Buffer { found: to.len(), expected: bytes.len() }.into());
        }
        to.copy_from_slice(&bytes);
        Ok(Status::Ok)
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
    let name = "fmi2DeSerializeFMUstate";
    // SAFETY: `size` bytes, and a pointer to a pointer.
    guard(c, name, Call::State, |_| unsafe {
        let bytes = slice(from, size, (name, "serializedState"))?;
        keep(target, Snapshot::from_bytes(bytes)?, name)
    })
}

// Derivatives

/// Sensitivity of unknowns to knowns, times a seed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: Handle,
    unknown: *const u32,
    n_unknown: usize,
    known: *const u32,
    n_known: usize,
    seed: *const f64,
    value: *mut f64,
) -> c_int {
    let name = "fmi2GetDirectionalDerivative";
    guard(c, name, Call::GetDirectionalDerivative, |it| {
        // SAFETY: both arrays of knowns have n_known items, those of unknowns n_unknown.
        let (known, seed) =
            unsafe { (slice(known, n_known, (name, "vKnown_ref"))?, slice(seed, n_known, (name, "dvKnown"))?) };
        let seeds: Vec<(u32, f64)> = known.iter().copied().zip(seed.iter().copied()).collect();
        unsafe { get((unknown, n_unknown), value, name, |r| it.instance.directional(r, &seeds)) }
    })
}

/// Sets first derivatives of inputs for the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: Handle,
    vr: *const u32,
    n: usize,
    order: *const c_int,
    value: *const f64,
) -> c_int {
    let name = "fmi2SetRealInputDerivatives";
    guard(c, name, Call::SetRealInputDerivatives, |it| {
        // SAFETY: the three arrays have n items.
        let (asked, value) = unsafe { (orders(vr, order, n, name)?, slice(value, n, (name, "value"))?) };
        it.instance.set_input_rates(&asked, value).map(done)
    })
}

/// First derivatives of outputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: Handle,
    vr: *const u32,
    n: usize,
    order: *const c_int,
    value: *mut f64,
) -> c_int {
    let name = "fmi2GetRealOutputDerivatives";
    guard(c, name, Call::GetRealOutputDerivatives, |it| {
        // SAFETY: the three arrays have n items.
        let (asked, value) = unsafe { (orders(vr, order, n, name)?, slice_mut(value, n, (name, "value"))?) };
        for (value, (reference, order)) in value.iter_mut().zip(asked) {
            *value = it.instance.output_rate(reference, order)?;
        }
        Ok(Status::Ok)
    })
}

unsafe fn orders(
    vr: *const u32,
    order: *const c_int,
    n: usize,
    name: &'static str,
) -> Result<Vec<(u32, c_int)>, CallError> {
    // SAFETY: both arrays have n items.
    let (vr, order) = unsafe { (slice(vr, n, (name, "vr"))?, slice(order, n, (name, "order"))?) };
    Ok(vr.iter().copied().zip(order.iter().copied()).collect())
}

// Steps

/// One communication step. States are kept whatever the importer promises about going back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(c: Handle, current: f64, step: f64, _no_state_before: c_int) -> c_int {
    guard(c, "fmi2DoStep", Call::DoStep, |it| it.instance.do_step(current, step))
}

/// Refused: no step runs asynchronously.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: Handle) -> c_int {
    guard(c, "fmi2CancelStep", Call::CancelStep, |_| Ok(Status::Ok))
}

/// Not available: no step runs asynchronously.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: Handle, _kind: c_int, value: *mut c_int) -> c_int {
    let name = "fmi2GetStatus";
    // SAFETY: a pointer to one value.
    guard(c, name, Call::GetStatus, |_| unsafe { answer(value, name, Err(not_available(name))) })
}

/// The last successful time (kind 2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: Handle, kind: c_int, value: *mut f64) -> c_int {
    let name = "fmi2GetRealStatus";
    guard(c, name, Call::GetStatus, |it| {
        let time = it.instance.last_successful_time();
        // SAFETY: a pointer to one value.
        unsafe { answer(value, name, if kind == 2 { Ok(time) } else { Err(not_available(name)) }) }
    })
}

/// Not available: there is no integer status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: Handle, _kind: c_int, value: *mut c_int) -> c_int {
    let name = "fmi2GetIntegerStatus";
    // SAFETY: a pointer to one value.
    guard(c, name, Call::GetStatus, |_| unsafe { answer(value, name, Err(not_available(name))) })
}

/// Whether the simulation has stopped by itself (kind 3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: Handle, kind: c_int, value: *mut c_int) -> c_int {
    let name = "fmi2GetBooleanStatus";
    guard(c, name, Call::GetStatus, |it| {
        let stopped = c_int::from(it.instance.has_stopped());
        // SAFETY: a pointer to one value.
        unsafe { answer(value, name, if kind == 3 { Ok(stopped) } else { Err(not_available(name)) }) }
    })
}

/// Not available: no step is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: Handle, _kind: c_int, value: *mut Text) -> c_int {
    let name = "fmi2GetStringStatus";
    // SAFETY: a pointer to one value.
    guard(c, name, Call::GetStatus, |_| unsafe { answer(value, name, Err(not_available(name))) })
}

fn not_available(what: &'static str) -> CallError {
    CallError::NotAvailable { what }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_fatal_until_the_instance_is_freed() {
        let instance = Instance::new("a".into(), Packed::of(Err("none".into())), Log::new(false));
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
