//! From pointers to slices and text, and back.

use super::{Place, Text};
use crate::fmi2::call::CallError;
use crate::fmi2::status::Status;
use std::ffi::CStr;

/// The array behind a pointer; empty if its length is 0, whatever the pointer.
pub(super) unsafe fn slice<'a, T>(at: *const T, n: usize, what: Place) -> Result<&'a [T], CallError> {
    match (n, at.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(CallError::NullPointer { function: what.0, argument: what.1 }),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(at, n) }),
    }
}

/// The array behind a pointer, to be written.
pub(super) unsafe fn slice_mut<'a, T>(at: *mut T, n: usize, what: Place) -> Result<&'a mut [T], CallError> {
    match (n, at.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err(CallError::NullPointer { function: what.0, argument: what.1 }),
        // SAFETY: not null, and of the length that was passed with it.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(at, n) }),
    }
}

/// The text behind a pointer.
pub(super) unsafe fn text<'a>(at: Text, what: Place) -> Result<&'a str, CallError> {
    if at.is_null() {
        return Err(CallError::NullPointer { function: what.0, argument: what.1 });
    }
    // SAFETY: not null, so it ends with a null byte.
    let text = unsafe { CStr::from_ptr(at) };
    text.to_str().map_err(|_| CallError::NotText { function: what.0, argument: what.1 })
}

/// References and the values that go with them.
pub(super) unsafe fn both<'a, T>(
    (references, n): (*const u32, usize),
    values: *const T,
    name: &'static str,
) -> Result<(&'a [u32], &'a [T]), CallError> {
    // SAFETY: both arrays have n items.
    unsafe { Ok((slice(references, n, (name, "vr"))?, slice(values, n, (name, "value"))?)) }
}

/// Reads one variable for each reference.
pub(super) unsafe fn get<T>(
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
pub(super) unsafe fn answer<T>(
    at: *mut T,
    function: &'static str,
    value: Result<T, CallError>,
) -> Result<Status, CallError> {
    // SAFETY: a pointer to one value.
    let at = unsafe { slice_mut(at, 1, (function, "value")) }?;
    at[0] = value?;
    Ok(Status::Ok)
}
