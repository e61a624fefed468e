//! C functions of steps and status queries.

use super::component::guard;
use super::pointers::{OpaquePointer, TextPointer, write_answer};
use crate::fmi2::call::CallError;
use crate::fmi2::lifecycle::CallGroup;
use crate::fmi2::status::CallStatus;
use std::ffi::c_int;

/// Performs one communication step. States are kept independent of `noSetFMUStatePriorToCurrentPoint`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(c: OpaquePointer, current: f64, step: f64, _no_state_before: c_int) -> c_int {
    guard(c, "fmi2DoStep", CallGroup::DoStep, |it| it.instance.do_step(current, step))
}

/// Refuses the call: no step runs asynchronously.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: OpaquePointer) -> c_int {
    guard(c, "fmi2CancelStep", CallGroup::CancelStep, |_| Ok(CallStatus::Ok))
}

/// Returns "not available": no step runs asynchronously.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: OpaquePointer, _kind: c_int, value: *mut c_int) -> c_int {
    let name = "fmi2GetStatus";
    // SAFETY: a pointer to one value.
    guard(c, name, CallGroup::GetStatus, |_| unsafe { write_answer(value, name, Err(not_available(name))) })
}

/// Returns the last successful time (kind 2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: OpaquePointer, kind: c_int, value: *mut f64) -> c_int {
    let name = "fmi2GetRealStatus";
    guard(c, name, CallGroup::GetStatus, |it| {
        let time = it.instance.last_successful_time();
        // SAFETY: a pointer to one value.
        unsafe { write_answer(value, name, if kind == 2 { Ok(time) } else { Err(not_available(name)) }) }
    })
}

/// Returns "not available": FMUs of this crate have no integer status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: OpaquePointer, _kind: c_int, value: *mut c_int) -> c_int {
    let name = "fmi2GetIntegerStatus";
    // SAFETY: a pointer to one value.
    guard(c, name, CallGroup::GetStatus, |_| unsafe { write_answer(value, name, Err(not_available(name))) })
}

/// Returns true if the simulation has stopped by itself (kind 3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(c: OpaquePointer, kind: c_int, value: *mut c_int) -> c_int {
    let name = "fmi2GetBooleanStatus";
    guard(c, name, CallGroup::GetStatus, |it| {
        let stopped = c_int::from(it.instance.has_stopped());
        // SAFETY: a pointer to one value.
        unsafe { write_answer(value, name, if kind == 3 { Ok(stopped) } else { Err(not_available(name)) }) }
    })
}

/// Returns "not available": no step is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(c: OpaquePointer, _kind: c_int, value: *mut TextPointer) -> c_int {
    let name = "fmi2GetStringStatus";
    // SAFETY: a pointer to one value.
    guard(c, name, CallGroup::GetStatus, |_| unsafe { write_answer(value, name, Err(not_available(name))) })
}

fn not_available(what: &'static str) -> CallError {
    CallError::NotAvailable { what }
}
