//! C functions of FMU states: states behind pointers and as bytes.

use super::component::guard;
use super::pointers::{OpaquePointer, slice, slice_mut};
use crate::fmi2::call::CallError;
use crate::fmi2::envelope::SnapshotError;
use crate::fmi2::lifecycle::CallGroup;
use crate::fmi2::snapshot::InstanceSnapshot;
use crate::fmi2::status::CallStatus;
use std::ffi::c_int;
use std::ptr;

/// Object behind a state pointer. The first word is zero: a caller that frees by value, not by address, frees
/// nothing.
#[repr(C)]
struct FmuStateObject {
    zero: u64,
    magic: u64,
    snapshot: InstanceSnapshot,
}

const STATE_MAGIC: u64 = 0x4745_4c53_5441_5445;

/// Copies the state of the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: OpaquePointer, target: *mut OpaquePointer) -> c_int {
    let name = "fmi2GetFMUstate";
    guard(c, name, CallGroup::State, |it| {
        let take = |snapshot: &mut InstanceSnapshot| it.instance.snapshot(snapshot);
        // SAFETY: a pointer to a pointer.
        unsafe { fill_target(target, name, take) }
    })
}

/// Restores a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: OpaquePointer, from: OpaquePointer) -> c_int {
    let name = "fmi2SetFMUstate";
    guard(c, name, CallGroup::State, |it| {
        // SAFETY: checked by `state_behind`.
        it.instance.restore(&unsafe { state_behind(from, name) }?.snapshot)
    })
}

/// Frees a state and makes its pointer null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: OpaquePointer, target: *mut OpaquePointer) -> c_int {
    let name = "fmi2FreeFMUstate";
    guard(c, name, CallGroup::State, |_| {
        if target.is_null() {
            return Ok(CallStatus::Ok);
        }
        // SAFETY: a pointer to a pointer; `state_behind` checks the state before it is freed.
        unsafe {
            if !(*target).is_null() {
                // Volatile: the word is read again only through a stale pointer.
                (&raw mut state_behind(*target, name)?.magic).write_volatile(0);
                drop(Box::from_raw((*target).cast::<FmuStateObject>()));
                *target = ptr::null_mut();
            }
        }
        Ok(CallStatus::Ok)
    })
}

/// Returns the number of bytes of a serialised state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(c: OpaquePointer, from: OpaquePointer, size: *mut usize) -> c_int {
    let name = "fmi2SerializedFMUstateSize";
    // SAFETY: a pointer to one size; the state is checked by `state_behind`.
    guard(c, name, CallGroup::State, |_| unsafe {
        let found = state_behind(from, name)?.snapshot.size();
        slice_mut(size, 1, name, "size")?[0] = found;
        Ok(CallStatus::Ok)
    })
}

/// Writes a state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: OpaquePointer,
    from: OpaquePointer,
    to: *mut u8,
    size: usize,
) -> c_int {
    let name = "fmi2SerializeFMUstate";
    guard(c, name, CallGroup::State, |_| {
        // SAFETY: `size` bytes; the state is checked by `state_behind`.
        let (state, to) = unsafe { (state_behind(from, name)?, slice_mut(to, size, name, "serializedState")?) };
        state.snapshot.write(to)?;
        Ok(CallStatus::Ok)
    })
}

/// Creates a state from bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: OpaquePointer,
    from: *const u8,
    size: usize,
    target: *mut OpaquePointer,
) -> c_int {
    let name = "fmi2DeSerializeFMUstate";
    // SAFETY: `size` bytes, and a pointer to a pointer.
    guard(c, name, CallGroup::State, |_| unsafe {
        let bytes = slice(from, size, name, "serializedState")?;
        fill_target(target, name, |snapshot| snapshot.read(bytes))
    })
}

/// Returns the state behind a pointer.
unsafe fn state_behind<'a>(at: OpaquePointer, function: &'static str) -> Result<&'a mut FmuStateObject, CallError> {
    if at.is_null() {
        return Err(CallError::NullPointer { function, argument: "FMUstate" });
    }
    if !at.cast::<FmuStateObject>().is_aligned() {
        return Err(SnapshotError::Foreign.into());
    }
    // SAFETY: not null and aligned; the two words are read before the rest is trusted.
    let words = unsafe { *at.cast::<[u64; 2]>() };
    if words != [0, STATE_MAGIC] {
        return Err(SnapshotError::Foreign.into());
    }
    // SAFETY: the words are those of a state of this FMU.
    Ok(unsafe { &mut *at.cast::<FmuStateObject>() })
}

/// Fills the state behind `*target`: an existing state in its memory, or a new state.
unsafe fn fill_target(
    target: *mut OpaquePointer,
    function: &'static str,
    fill: impl FnOnce(&mut InstanceSnapshot) -> Result<(), SnapshotError>,
) -> Result<CallStatus, CallError> {
    // SAFETY: a pointer to a pointer, as the standard wants it.
    let target = &mut unsafe { slice_mut(target, 1, function, "FMUstate") }?[0];
    if target.is_null() {
        let mut snapshot = InstanceSnapshot::empty();
        fill(&mut snapshot)?;
        *target = Box::into_raw(Box::new(FmuStateObject { zero: 0, magic: STATE_MAGIC, snapshot })).cast();
    } else {
        // SAFETY: checked by `state_behind`.
        fill(&mut unsafe { state_behind(*target, function) }?.snapshot)?;
    }
    Ok(CallStatus::Ok)
}
