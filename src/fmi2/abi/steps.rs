//! Steps, and what can be asked about them.

use super::pointers::answer;
use super::{Handle, Text, guard};
use crate::fmi2::call::CallError;
use crate::fmi2::lifecycle::Call;
use crate::fmi2::status::Status;
use std::ffi::c_int;

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
