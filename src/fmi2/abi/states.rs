//! States behind pointers and as bytes.

use super::pointers::{slice, slice_mut};
use super::{Handle, guard};
use crate::fmi2::call::CallError;
use crate::fmi2::lifecycle::Call;
use crate::fmi2::snapshot::{Snapshot, SnapshotError};
use crate::fmi2::status::Status;
use std::ffi::c_int;
use std::ptr;

/// What a state points to. The first word is zero: a caller that frees by value, not by address, frees nothing.
#[repr(C)]
struct State {
    zero: u64,
    magic: u64,
    snapshot: Snapshot,
}

const STATE_MAGIC: u64 = 0x4745_4c53_5441_5445;

/// Copies the state of the instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: Handle, target: *mut Handle) -> c_int {
    let name = "fmi2GetFMUstate";
    guard(c, name, Call::State, |it| {
        let take = |snapshot: &mut Snapshot| it.instance.snapshot(snapshot);
        // SAFETY: a pointer to a pointer.
        unsafe { keep(target, name, take) }
    })
}

/// Goes to a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: Handle, from: Handle) -> c_int {
    let name = "fmi2SetFMUstate";
    guard(c, name, Call::State, |it| {
        // SAFETY: checked by `state`.
        it.instance.restore(&unsafe { state(from, name) }?.snapshot)
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
                // Volatile: the word is read again only through a pointer that should not be used any more.
                (&raw mut state(*target, name)?.magic).write_volatile(0);
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
        state.snapshot.write(to)?;
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
        keep(target, name, |snapshot| snapshot.read(bytes))
    })
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

/// Fills the state behind `*target`: the one that is there, in its memory, or a new one.
unsafe fn keep(
    target: *mut Handle,
    function: &'static str,
    fill: impl FnOnce(&mut Snapshot) -> Result<(), SnapshotError>,
) -> Result<Status, CallError> {
    // SAFETY: a pointer to a pointer, as the standard wants it.
    let target = &mut unsafe { slice_mut(target, 1, (function, "FMUstate")) }?[0];
    if target.is_null() {
        let mut snapshot = Snapshot::empty();
        fill(&mut snapshot)?;
        *target = Box::into_raw(Box::new(State { zero: 0, magic: STATE_MAGIC, snapshot })).cast();
    } else {
        // SAFETY: checked by `state`.
        fill(&mut unsafe { state(*target, function) }?.snapshot)?;
    }
    Ok(Status::Ok)
}
