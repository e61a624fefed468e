//! C functions that read and set variables and their derivatives.

use super::component::{Component, guard};
use super::pointers::{OpaquePointer, TextPointer, read_each, references_and_values, slice, slice_mut, text};
use crate::fmi2::call::CallError;
use crate::fmi2::lifecycle::CallGroup;
use crate::fmi2::status::CallStatus;
use std::ffi::{CString, c_int};
use std::ptr;

/// Reads Reals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(c: OpaquePointer, vr: *const u32, n: usize, value: *mut f64) -> c_int {
    let name = "fmi2GetReal";
    // SAFETY: both arrays have n items.
    guard(c, name, CallGroup::Get, |it| unsafe { read_each(vr, n, value, name, |r| it.instance.real(r)) })
}

/// Reads Integers and Enumerations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(c: OpaquePointer, vr: *const u32, n: usize, value: *mut c_int) -> c_int {
    let name = "fmi2GetInteger";
    // SAFETY: both arrays have n items.
    guard(c, name, CallGroup::Get, |it| unsafe { read_each(vr, n, value, name, |r| it.instance.integer(r)) })
}

/// Reads Booleans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(c: OpaquePointer, vr: *const u32, n: usize, value: *mut c_int) -> c_int {
    let name = "fmi2GetBoolean";
    // SAFETY: both arrays have n items.
    guard(c, name, CallGroup::Get, |it| unsafe {
        read_each(vr, n, value, name, |r| it.instance.boolean(r).map(c_int::from))
    })
}

/// Reads Strings, valid until the next call of this function.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(c: OpaquePointer, vr: *const u32, n: usize, value: *mut TextPointer) -> c_int {
    let name = "fmi2GetString";
    guard(c, name, CallGroup::Get, |it| {
        it.strings.clear();
        let Component { instance, strings, .. } = it;
        // SAFETY: both arrays have n items; the bytes of a string stay where they are when the list grows.
        unsafe {
            read_each(vr, n, value, name, |r| {
                strings.push(CString::new(instance.text(r)?).unwrap_or_default());
                Ok(strings.last().map_or(ptr::null(), |s| s.as_ptr()))
            })
        }
    })
}

/// Sets Reals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(c: OpaquePointer, vr: *const u32, n: usize, value: *const f64) -> c_int {
    let name = "fmi2SetReal";
    guard(c, name, CallGroup::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { references_and_values(vr, n, value, name) }?;
        it.instance.set_reals(vr, value).map(|()| CallStatus::Ok)
    })
}

/// Sets Integers and Enumerations.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(c: OpaquePointer, vr: *const u32, n: usize, value: *const c_int) -> c_int {
    let name = "fmi2SetInteger";
    guard(c, name, CallGroup::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { references_and_values(vr, n, value, name) }?;
        it.instance.set_integers(vr, value).map(|()| CallStatus::Ok)
    })
}

/// Sets Booleans: any number but 0 is true.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(c: OpaquePointer, vr: *const u32, n: usize, value: *const c_int) -> c_int {
    let name = "fmi2SetBoolean";
    guard(c, name, CallGroup::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { references_and_values(vr, n, value, name) }?;
        let values: Vec<bool> = value.iter().map(|value| *value != 0).collect();
        it.instance.set_booleans(vr, &values).map(|()| CallStatus::Ok)
    })
}

/// Sets Strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(c: OpaquePointer, vr: *const u32, n: usize, value: *const TextPointer) -> c_int {
    let name = "fmi2SetString";
    guard(c, name, CallGroup::Set, |it| {
        // SAFETY: both arrays have n items.
        let (vr, value) = unsafe { references_and_values(vr, n, value, name) }?;
        let texts = value.iter().map(|&at| unsafe { text(at, name, "value") });
        it.instance.set_texts(vr, &texts.collect::<Result<Vec<&str>, CallError>>()?).map(|()| CallStatus::Ok)
    })
}

/// Returns the directional derivatives of unknowns along a seed of knowns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: OpaquePointer,
    unknown: *const u32,
    n_unknown: usize,
    known: *const u32,
    n_known: usize,
    seed: *const f64,
    value: *mut f64,
) -> c_int {
    let name = "fmi2GetDirectionalDerivative";
    guard(c, name, CallGroup::GetDirectionalDerivative, |it| {
        // SAFETY: both arrays of knowns have n_known items, those of unknowns n_unknown.
        let (known, seed) =
            unsafe { (slice(known, n_known, name, "vKnown_ref")?, slice(seed, n_known, name, "dvKnown")?) };
        let seeds: Vec<(u32, f64)> = known.iter().copied().zip(seed.iter().copied()).collect();
        unsafe { read_each(unknown, n_unknown, value, name, |r| it.instance.directional_derivative(r, &seeds)) }
    })
}

/// Sets first derivatives of inputs for the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: OpaquePointer,
    vr: *const u32,
    n: usize,
    order: *const c_int,
    value: *const f64,
) -> c_int {
    let name = "fmi2SetRealInputDerivatives";
    guard(c, name, CallGroup::SetRealInputDerivatives, |it| {
        // SAFETY: the three arrays have n items.
        let (asked, value) = unsafe { (orders(vr, order, n, name)?, slice(value, n, name, "value")?) };
        it.instance.set_input_rates(&asked, value).map(|()| CallStatus::Ok)
    })
}

/// Returns first derivatives of outputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: OpaquePointer,
    vr: *const u32,
    n: usize,
    order: *const c_int,
    value: *mut f64,
) -> c_int {
    let name = "fmi2GetRealOutputDerivatives";
    guard(c, name, CallGroup::GetRealOutputDerivatives, |it| {
        // SAFETY: the three arrays have n items.
        let (asked, value) = unsafe { (orders(vr, order, n, name)?, slice_mut(value, n, name, "value")?) };
        for (value, (reference, order)) in value.iter_mut().zip(asked) {
            *value = it.instance.output_rate(reference, order)?;
        }
        Ok(CallStatus::Ok)
    })
}

unsafe fn orders(
    vr: *const u32,
    order: *const c_int,
    n: usize,
    name: &'static str,
) -> Result<Vec<(u32, c_int)>, CallError> {
    // SAFETY: both arrays have n items.
    let (vr, order) = unsafe { (slice(vr, n, name, "vr")?, slice(order, n, name, "order")?) };
    Ok(vr.iter().copied().zip(order.iter().copied()).collect())
}
