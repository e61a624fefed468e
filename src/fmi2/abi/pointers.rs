//! Conversion of C pointers to slices and text, and back.

use crate::fmi2::call::CallError;
use crate::fmi2::status::CallStatus;
use std::ffi::{CStr, c_char, c_void};

/// Pointer to a component or a state.
pub(super) type OpaquePointer = *mut c_void;
/// Pointer to a text that ends with a null byte.
pub(super) type TextPointer = *const c_char;

/// Returns the array behind a pointer; empty for length 0, even with a null pointer.
pub(super) unsafe fn slice<'a, T>(
    at: *const T,
    n: usize,
    function: &'static str,
    argument: &'static str,
) -> Result<&'a [T], CallError> {
    match (n, at.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(CallError::NullPointer { function, argument }),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(at, n) }),
    }
}

/// Returns the writable array behind a pointer.
pub(super) unsafe fn slice_mut<'a, T>(
    at: *mut T,
    n: usize,
    function: &'static str,
    argument: &'static str,
) -> Result<&'a mut [T], CallError> {
    match (n, at.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err(CallError::NullPointer { function, argument }),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(at, n) }),
    }
}

/// Returns the text behind a pointer.
pub(super) unsafe fn text<'a>(
    at: TextPointer,
    function: &'static str,
    argument: &'static str,
) -> Result<&'a str, CallError> {
    if at.is_null() {
        return Err(CallError::NullPointer { function, argument });
    }
    // SAFETY: not null, so it ends with a null byte.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|_| CallError::NotText { function, argument })
}

/// Returns references and their values.
pub(super) unsafe fn references_and_values<'a, T>(
    references: *const u32,
    n: usize,
    values: *const T,
    name: &'static str,
) -> Result<(&'a [u32], &'a [T]), CallError> {
    // SAFETY: both arrays have n items.
    unsafe { Ok((slice(references, n, name, "vr")?, slice(values, n, name, "value")?)) }
}

/// Reads one variable for each reference.
pub(super) unsafe fn read_each<T>(
    references: *const u32,
    n: usize,
    values: *mut T,
    function: &'static str,
    mut read: impl FnMut(u32) -> Result<T, CallError>,
) -> Result<CallStatus, CallError> {
    // SAFETY: both arrays have n items.
    let (references, values) =
        unsafe { (slice(references, n, function, "vr")?, slice_mut(values, n, function, "value")?) };
    for (value, &reference) in values.iter_mut().zip(references) {
        *value = read(reference)?;
    }
    Ok(CallStatus::Ok)
}

/// Writes the answer of a status query.
pub(super) unsafe fn write_answer<T>(
    at: *mut T,
    function: &'static str,
    value: Result<T, CallError>,
) -> Result<CallStatus, CallError> {
    // SAFETY: a pointer to one value.
    let at = unsafe { slice_mut(at, 1, function, "value") }?;
    at[0] = value?;
    Ok(CallStatus::Ok)
}
